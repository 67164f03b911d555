"""The lesions of a vessel: found once, off the application's thread."""

from typing import Any, NamedTuple

import numpy as np
from slicer.i18n import tr as _

from SDFStentLib.plan import flow_answer, flow_model
from SDFStentLib.validation import InputError

from .Portions import inPortions


def withSections(lesions):
    """The same lesions, their sections cut: the application's thread would wait for those that it tells of."""
    for lesion in lesions:
        _cut = lesion.section
    return lesions


class Around(NamedTuple):
    """How wide the vessel is along a lesion, and healthy vessel on both sides."""

    points: Any
    """(k, 3) mm."""
    along: Any
    """(k,) from the root, mm."""
    diameters: Any
    """(k,) mm; NaN where not known."""
    healthy: Any
    """(k,) mm; NaN beside the lesion."""


DIAMETERS, SPACING = 2.0, 0.5
"""The length of healthy vessel that is shown on both sides of a lesion, in its diameters; between places there, mm."""


def around(vessel, lesion):
    """The `Around` of a lesion of the library's `Vessel`."""
    tree, line = vessel.centerline, lesion.line
    reach = DIAMETERS * lesion.reference_diameter
    ways = (
        tree.path_from_distal(line.points[0], reach).line,
        tree.path_from_proximal(line.points[-1], reach).line,
    )
    parts = [(line.points, line.arc_lengths, lesion.diameters, lesion.healthy)]
    for way, offset, side in zip(ways, (-ways[0].length, line.length), (0, 1), strict=True):
        if way.length < SPACING:
            continue  # the vessel ends there
        found = vessel.diameters(way, SPACING)
        kept = slice(None, -1) if side == 0 else slice(1, None)
        unknown = np.full(len(found.arc_length), np.nan)
        columns = found.centers, found.arc_length + offset, found.inscribed_diameter, unknown
        parts.insert(len(parts) * side, tuple(column[kept] for column in columns))
    points, along, diameters, healthy = map(np.concatenate, zip(*parts, strict=True))
    return Around(points, lesion.start + along, diameters, healthy)


class LesionSearch:
    """The lesions of one vessel with one centerline. No nodes in here.

    `found` is None until `portions` was run to its end, then a tuple of the library's `Lesion`, in its order; `sentence`
    says why it is empty where the vessel could not be searched, `remark` what to know of the vessel, `endNames` what its ends are called,
    `vessel` the library's `Vessel`.
    """

    def __init__(self, inputs):
        """`inputs()` is a generator that yields None in between and returns the remark and the library's `Vessel`."""
        self._inputs = inputs
        self.found, self.sentence, self.remark = None, "", ""
        self.vessel = self._model = None
        self._around, self.endNames = {}, ()

    def portions(self):
        """Search; yields None until it is done. Does nothing when it is."""
        if self.found is not None:
            return
        try:
            self.remark, self.vessel = yield from self._inputs()
            vessel = self.vessel
            cautions = yield from inPortions(lambda: vessel.lesion_cautions)
            sentences = [caution.sentence() for caution in cautions]
            self.remark = "\n".join(filter(None, [self.remark, *sentences]))
            self.endNames = yield from inPortions(lambda: vessel.end_names)
            self.found = yield from inPortions(lambda: withSections(vessel.lesions))
        except InputError as error:
            self.found, self.sentence = (), str(error)

    def around(self, lesion):
        """The `Around` of a lesion that was found; a generator that yields None until it is known."""
        if lesion not in self._around:
            vessel = self.vessel
            self._around[lesion] = yield from inPortions(lambda: around(vessel, lesion))
        return self._around[lesion]

    def sideOf(self, lesion):
        """The patient's side on which a lesion lies from where the root parts first."""
        tree = self.vessel.centerline
        below, counts = np.unique(tree.parent[tree.parent >= 0], return_counts=True)
        partings = below[counts > 1]
        root = partings[np.argmin(tree.arc_length[partings])] if len(partings) else 0
        return _("right") if lesion.point[0] > tree.points[root, 0] else _("left")

    @property
    def landmarks(self):
        """The library's `Landmarks` of the vessel, by which stents are placed; None until they are known."""
        return self.vessel.landmarks if self.found is not None and not self.sentence else None

    def placed(self, stent):
        """A stent of the library where it lies in the vessel; once `portions` was run to its end. Raises as `Vessel.placed`."""
        if self.vessel is None:
            raise InputError(self.sentence)
        return self.vessel.placed(stent)

    def flow(self, known, result):
        """The library's `FlowAnswer` for what is `known` of the flow, and a result; once `portions` was run to its end.

        What is before treatment is kept from one result to the next. Raises as the library's `flow_model` and `flow_answer`.
        """
        if self._model is None or self._model.known != known:
            self._model = flow_model(self.vessel, known, "RAS")
        return flow_answer(self._model, self.vessel, result)
