"""The vessel and the centerline of a parameter node for the library, converted only when the nodes have changed."""

from typing import Any, NamedTuple

import numpy as np
from slicer.i18n import tr as _

from SDFStentLib.centerline import Centerline
from SDFStentLib.files import (
    check_joined,
    check_same_space,
    composition_warnings,
    faces_of_polydata,
    size_warnings,
    surface_from_polydata,
    triangulated_polydata,
)
from SDFStentLib.lumen import LineEnds, loop_cautions, with_ends_in_middle
from SDFStentLib.plan import vessel_of

from . import Conversion, Handles, Plans
from .Lesions import LesionSearch
from .ModelFaces import addFaces
from .ParameterNode import stentOf, stentsOf
from .PointNormals import cornersOf
from .Portions import Jointly, inPortions, untilDone
from .Previewing import PreviewedVessel

SPACING = 1.0
"""Spacing of the places at which a lumen is measured, mm."""


AS_WIDE_AS = 0.75
"""A new stent is as wide as this quantile of the vessel where it lies: no narrowing there makes it too small to touch the wall."""


class VesselInput(NamedTuple):
    """A vessel's wall in world coordinates: the library's `Surface`, polydata, its named faces or None, its `Corners` where it is large.

    The polydata is shared: copy it before changing it. `remark` is what to know of it, a sentence or "".
    """

    surface: Any
    polyData: Any
    faces: Any
    corners: Any
    remark: str


class Inputs:
    """Remembers the last conversion of each kind."""

    def __init__(self):
        self._vessel = self._centerline = self._lesions = self._preview = (None, None)
        self._patient = (None, None, "")
        self._beside, self._lineEnds = (), None
        self._making = Jointly()

    def vessel(self, parameterNode):
        """The `VesselInput`."""
        return untilDone(self.vesselInPortions(parameterNode))

    def vesselInPortions(self, parameterNode):
        """`VesselInput` in portions of some 15 ms at 550,000 triangles: a generator that yields None and returns it."""
        node, segmentID = parameterNode.vessel, Conversion.segmentOf(parameterNode)
        stamp = (Conversion.changeStamp(node), segmentID)
        if node is not None and stamp == self._vessel[0]:
            return self._vessel[1]
        return (
            yield from self._making.portions(
                "vessel", stamp, lambda: self._converted(node, segmentID, stamp)
            )
        )

    def _converted(self, node, segmentID, stamp):
        given = Conversion.vesselPolyData(node, segmentID)
        name = f"Vessel {node.GetName()}"
        yield None
        yield from inPortions(lambda: addFaces(node, given))
        polyData = yield from inPortions(lambda: triangulated_polydata(given, name).polydata)
        surface = yield from inPortions(lambda: surface_from_polydata(polyData, name))
        yield from inPortions(lambda: check_joined(surface, name))
        corners = yield from inPortions(lambda: cornersOf(polyData))
        size = yield from inPortions(lambda: _sizeRemark(surface, node.GetName()))
        known = [str(caution) for caution in composition_warnings(surface, node.GetName())]
        remark = "\n".join(filter(None, [size, *known]))
        faces = faces_of_polydata(polyData, surface)
        self._vessel = (stamp, VesselInput(surface, polyData, faces, corners, remark))
        return self._vessel[1]

    def centerline(self, parameterNode):
        """The library's centerline."""
        return untilDone(self.centerlineInPortions(parameterNode))

    def knownCenterline(self, parameterNode):
        """The centerline where it is converted already, else None."""
        stamp, centerline = self._centerline
        return centerline if stamp == _stampOf(parameterNode) else None

    def centerlineInPortions(self, parameterNode):
        """Centerline in portions: a generator that yields None and returns it.

        Raises `InputError` where it is not of the vessel: no number in there would be one of the patient.
        """
        stamp = _stampOf(parameterNode)
        if stamp == self._centerline[0]:
            return self._centerline[1]
        return (
            yield from self._making.portions(
                "centerline",
                _ofNode(parameterNode, stamp),
                lambda: self._tree(parameterNode, stamp),
            )
        )

    def _tree(self, parameterNode, stamp):
        inlet = Plans.marksOf(parameterNode).root
        lines, told = Conversion.centerlineLines(parameterNode.centerline), ()
        vessel = parameterNode.vessel
        if vessel is None:
            centerline = yield from inPortions(lambda: Centerline.from_lines(*lines, inlet=inlet))
        else:
            surface = (yield from self.vesselInPortions(parameterNode)).surface
            how = {"inlet": inlet, "wall": surface.points}
            names = vessel.GetName(), parameterNode.centerline.GetName()
            # First: far from their wall, lines seem to run in one wide lumen, and no tree is left.
            told = yield from inPortions(lambda: _misfits(surface, lines, *names))
            tree = yield from inPortions(
                lambda: Centerline.from_lines(*lines, widths=LineEnds(surface).widths, **how)
            )
            centerline, moved = yield from inPortions(lambda: with_ends_in_middle(surface, tree))
            told = (*told, *map(str, (*moved, *loop_cautions(centerline))))
        points, numbers, _radii = lines
        self._lineEnds = points[[[line[0], line[-1]] for line in numbers if len(line)]]
        self._centerline, self._beside = (stamp, centerline), told
        return centerline

    def lesions(self, parameterNode):
        """The `LesionSearch` of vessel and centerline, the same object until one of them changes."""
        stamp = _stampOf(parameterNode)
        if stamp != self._lesions[0]:
            chosen = parameterNode.vessel, Conversion.segmentOf(parameterNode)
            search = LesionSearch(
                lambda: self._bothInPortions(parameterNode), lambda: Conversion.halfVoxel(*chosen)
            )
            self._lesions = (stamp, search)
        return self._lesions[1]

    def _bothInPortions(self, parameterNode):
        vessel = yield from self.vesselInPortions(parameterNode)
        patient = yield from self.patientInPortions(parameterNode)
        remark = "\n".join(filter(None, (vessel.remark, *self._beside, self._patient[-1])))
        return remark, patient

    def patient(self, parameterNode):
        """The library's `Vessel` of wall, centerline and what the plan says of them; names that are of another vessel are left out."""
        return untilDone(self.patientInPortions(parameterNode))

    def patientInPortions(self, parameterNode):
        """`Vessel` of the library in portions: a generator that yields None and returns it, the same object until one of these changes."""
        stamp = _stampOf(parameterNode)
        if stamp == self._patient[0]:
            return self._patient[1]
        return (
            yield from self._making.portions(
                "patient", _ofNode(parameterNode, stamp), lambda: self._whole(parameterNode, stamp)
            )
        )

    def _whole(self, parameterNode, stamp):
        vessel = yield from self.vesselInPortions(parameterNode)
        hasTree, how = parameterNode.centerline is not None, {"faces": vessel.faces}
        tree, marks = None, Plans.marksOf(parameterNode)
        if hasTree:
            tree = yield from self.centerlineInPortions(parameterNode)
            how["lines"] = self._lineEnds
        made = yield from inPortions(lambda: vessel_of(vessel.surface, tree, marks, **how))
        self._patient = (stamp, *made)
        return made[0]

    def placedInPortions(self, parameterNode, case):
        """Let a `Case` of the library know where its stents lie; a generator as those above."""
        if any(one.placement.isOfVessel for one in stentsOf(parameterNode) if one.enabled):
            yield from self.lesions(parameterNode).portions()
            yield from inPortions(lambda: case.stents)

    def nativeLumenInPortions(self, parameterNode, stent):
        """Smallest inscribed diameter where a stent of the library lies, before it, mm; a generator as those above."""
        if stentOf(parameterNode).placement.isOfVessel:
            yield from self.lesions(parameterNode).portions()
        patient = yield from self.patientInPortions(parameterNode)
        return (yield from inPortions(lambda: patient.native_lumen(stent)))

    def previewInPortions(self, parameterNode):
        """`PreviewedVessel` of vessel and centerline, the same object until one of them changes; a generator as those above."""
        stamp = _stampOf(parameterNode)
        if stamp != self._preview[0]:
            patient = yield from self.patientInPortions(parameterNode)
            if stamp != self._preview[0]:  # nobody else has made it meanwhile
                self._preview = (stamp, PreviewedVessel(patient))
        return self._preview[1]

    def sizeLimits(self, parameterNode):
        """Largest sensible diameter and length of a stent for this vessel, mm; for any, until its centerline is converted."""
        centerline = self.knownCenterline(parameterNode)
        if centerline is None:
            return 40.0, 120.0
        radius = centerline.inscribed_radius[np.isfinite(centerline.inscribed_radius)]
        diameter = _endOfSlider(4 * np.max(radius)) if len(radius) else 40.0
        return min(60.0, diameter), min(300.0, _endOfSlider(np.max(centerline.arc_length)))

    def suggestedDiameter(self, parameterNode):
        """A diameter that fits the vessel where a new stent is put, mm, measured where the centerline knows no radii.

        8 where there is no vessel to measure.
        """
        tree = self.centerline(parameterNode)
        way = tree.path_around(Handles.middlePoint(tree), Handles.USUAL_LENGTH)
        diameters = 2 * way.inscribed_radius
        if np.isnan(diameters).all() and parameterNode.vessel is not None:
            found = self.patient(parameterNode).diameters(way.line, SPACING)
            diameters = found.inscribed_diameter
        known = diameters[np.isfinite(diameters)]
        return float(round(np.quantile(known, AS_WIDE_AS), 1)) if len(known) else 8.0


def _stampOf(parameterNode):
    """A value that differs whenever vessel, centerline or what the plan says of them do."""
    return Conversion.inputStamp(parameterNode), str(parameterNode.get("inputs"))


def _ofNode(parameterNode, stamp):
    """A stamp of one parameter node: while its inputs are converted another one may change."""
    return parameterNode.parameterNode.GetID(), stamp


def _misfits(surface, lines, vesselName, name):
    """Sentences on a centerline's lines that lie in a vessel but for a part; `InputError` for those of another vessel."""
    points, numbers, _radii = lines
    names = {"surface_name": vesselName, "centerline_name": name}
    return [
        str(one)
        for one in check_same_space(surface, points[np.unique(np.concatenate(numbers))], **names)
    ]


def _endOfSlider(size):
    """Whole millimeters that hold a size."""
    return float(np.ceil(np.round(size, 3)))  # a transform leaves some digits more


def _sizeRemark(surface, name):
    """The remark that a vessel is much smaller or larger than vessels are in mm, as a sentence; "" where it is not."""
    for caution in size_warnings(surface, name):
        numbers = caution.numbers
        lumen = numbers.get("lumen_mm")
        width = "" if lumen is None else _(" and about {lumen:.2g} mm wide").format(lumen=lumen)
        return _(
            "{name} is {extent:.3g} mm long{width}, unusual for a vessel. If it is in another unit put it and its centerline "
            "below a transform that makes that mm: by 10 from cm, by 1000 from m."
        ).format(name=name, extent=numbers["extent_mm"], width=width)
    return ""
