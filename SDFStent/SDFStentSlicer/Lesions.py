"""The lesions of a vessel: found once, off the application's thread."""

from typing import Any, NamedTuple

import numpy as np
from slicer.i18n import tr as _

from SDFStentLib.plan import flow_answer, flow_model, with_sections
from SDFStentLib.scan import voxel_range
from SDFStentLib.validation import InputError

from .Portions import inPortions


class Around(NamedTuple):
    """Diameters of the vessel along a lesion, and of healthy vessel on both sides."""

    points: Any
    """(k, 3) mm."""
    along: Any
    """(k,) from the root, mm."""
    diameters: Any
    """(k,) mm; NaN where not known."""
    healthy: Any
    """(k,) mm; NaN beside the lesion."""


DIAMETERS, SPACING = 2.0, 0.5
"""Length of healthy vessel shown on both sides of a lesion, in its diameters; spacing of places there, mm."""


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


class _Sides:
    """The sides of the patient that a tree, in world coordinates, leads to.

    They part where the ends beyond two branches lie farthest apart from side to side: a twig that leaves before the lungs do is
    near one of them and both.
    """

    def __init__(self, tree):
        self._points, count = tree.points, np.zeros(len(tree.points))
        self._beyond = np.zeros(len(tree.points))
        for leaf in tree.leaves:
            way = tree.ancestry(leaf)
            count[way] += 1
            self._beyond[way] += tree.points[leaf, 0]
        self._beyond /= count  # the mean of all ends beyond each point
        forks = [(tree.ancestry(one), self._beyond[tree.children(one)]) for one in tree.junctions]
        self._common, beyond = max(forks, key=lambda fork: np.ptp(fork[1]), default=((), None))
        self._middle = None if beyond is None else (beyond.min() + beyond.max()) / 2

    def of(self, place):
        """The side of what lies beyond a place of the tree."""
        at = int(np.argmin(np.linalg.norm(self._points - place, axis=1)))
        if self._middle is None or at in self._common:
            return ""
        return _("right") if self._beyond[at] > self._middle else _("left")


class LesionSearch:
    """The lesions of one vessel with one centerline. No nodes in here.

    `found` is None until `portions` was run to its end, then a tuple of the library's `Lesion`, in its order; `sentence`
    says why it is empty where the vessel could not be searched, `remark` what to know of the vessel, `endNames` what its ends are called,
    `vessel` the library's `Vessel`.
    """

    def __init__(self, inputs, halfVoxel):
        """`inputs()` is a generator that yields None in between and returns the remark and the library's `Vessel`.

        `halfVoxel()` is half a voxel, mm, of a vessel that was made of voxels, else None.
        """
        self._inputs, self._halfVoxel = inputs, halfVoxel
        self.found, self.sentence, self.remark = None, "", ""
        self.vessel = self._model = None
        self._around, self._sides, self.endNames = {}, None, ()

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
            self.found = yield from inPortions(lambda: with_sections(vessel.lesions))
        except InputError as error:
            self.found, self.sentence = (), str(error)

    def ranges(self):
        """The library's `VoxelRange` of the lesions that were found; a generator that yields None until it is known, None without voxels."""
        vessel, half = self.vessel, self._halfVoxel()
        if not self.found or half is None:
            return None
        return (yield from inPortions(lambda: voxel_range(vessel, half)))

    def around(self, lesion):
        """The `Around` of a lesion that was found; a generator that yields None until it is known."""
        if lesion not in self._around:
            vessel = self.vessel
            self._around[lesion] = yield from inPortions(lambda: around(vessel, lesion))
        return self._around[lesion]

    def sideOf(self, lesion):
        """The patient's side on which what a lesion leads to lies; "" where it leads to both."""
        if self._sides is None:
            self._sides = _Sides(self.vessel.centerline)
        return self._sides.of(lesion.point)

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
        """`FlowAnswer` of the library for `known` flow data and a result; once `portions` was run to its end.

        What is before treatment is kept from one result to the next. Raises as the library's `flow_model` and `flow_answer`.
        """
        if self._model is None or self._model.known != known:
            self._model = flow_model(self.vessel, known, "RAS")
        return flow_answer(self._model, self.vessel, result)
