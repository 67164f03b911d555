"""The vessel and the centerline of a parameter node for the library, converted only when the nodes have changed."""

from typing import Any, NamedTuple

import numpy as np

from SDFStentLib import treatment
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import faces_of_polydata, surface_from_polydata, triangulated_polydata

from . import Conversion
from .Lesions import LesionSearch
from .PointNormals import cornersOf
from .Portions import inPortions, untilDone
from .Previewing import PreviewedVessel


class Vessel(NamedTuple):
    """A vessel's wall in world coordinates: the library's `Surface`, polydata, its named faces or None, its `Corners` where it is large.

    The polydata is shared: copy it before changing it.
    """

    surface: Any
    polyData: Any
    faces: Any
    corners: Any


class Inputs:
    """Remembers the last conversion of each kind."""

    def __init__(self):
        self._vessel = self._centerline = self._lesions = self._preview = (None, None)

    def vessel(self, parameterNode):
        """The `Vessel`."""
        return untilDone(self.vesselInPortions(parameterNode))

    def vesselInPortions(self, parameterNode):
        """The same in portions of some 15 ms at 550,000 triangles: a generator that yields None and returns the `Vessel`."""
        node, segmentID = parameterNode.vessel, Conversion.segmentOf(parameterNode)
        stamp = (Conversion.changeStamp(node), segmentID)
        if node is None or stamp != self._vessel[0]:
            given = Conversion.vesselPolyData(node, segmentID)
            name = f"Vessel {node.GetName()}"
            yield None
            polyData = yield from inPortions(lambda: triangulated_polydata(given, name).polydata)
            surface = yield from inPortions(lambda: surface_from_polydata(polyData, name))
            corners = yield from inPortions(lambda: cornersOf(polyData))
            self._vessel = (stamp, Vessel(surface, polyData, faces_of_polydata(polyData), corners))
        return self._vessel[1]

    def centerline(self, parameterNode):
        """The library's centerline."""
        return untilDone(self.centerlineInPortions(parameterNode))

    def centerlineInPortions(self, parameterNode):
        """The same in portions: a generator that yields None and returns the centerline."""
        node = parameterNode.centerline
        stamp = Conversion.changeStamp(node)
        if node is None or stamp != self._centerline[0]:
            lines = Conversion.centerlineLines(node)
            centerline = yield from inPortions(lambda: Centerline.from_lines(*lines))
            self._centerline = (stamp, centerline)
        return self._centerline[1]

    def lesions(self, parameterNode):
        """The `LesionSearch` of vessel and centerline, the same object until one of them changes."""
        stamp = self._stamp(parameterNode)
        if stamp != self._lesions[0]:
            self._lesions = (stamp, LesionSearch(lambda: self._bothInPortions(parameterNode)))
        return self._lesions[1]

    def _bothInPortions(self, parameterNode):
        vessel = yield from self.vesselInPortions(parameterNode)
        centerline = yield from self.centerlineInPortions(parameterNode)
        return vessel.surface, centerline, vessel.faces

    def nativeLumenInPortions(self, parameterNode, stent):
        """Smallest inscribed diameter where a stent of the library lies, before it, mm; a generator as those above."""
        vessel = yield from self.vesselInPortions(parameterNode)
        centerline = None
        if parameterNode.centerline is not None:
            centerline = yield from self.centerlineInPortions(parameterNode)
        native = treatment.Vessel(vessel.surface, centerline)
        return (yield from inPortions(lambda: native.native_lumen(stent)))

    def preview(self, parameterNode):
        """The `PreviewedVessel` of vessel and centerline, the same object until one of them changes."""
        stamp = self._stamp(parameterNode)
        if stamp != self._preview[0]:
            node = parameterNode.centerline
            centerline = None if node is None else self.centerline(parameterNode)
            vessel = self.vessel(parameterNode)
            self._preview = (stamp, PreviewedVessel(vessel.surface, centerline))
        return self._preview[1]

    def sizeLimits(self, parameterNode):
        """Largest sensible diameter and length of a stent for this vessel, mm; for any, until its centerline is converted."""
        node, (stamp, centerline) = parameterNode.centerline, self._centerline
        if node is None or stamp != Conversion.changeStamp(node):
            return 40.0, 120.0
        radius = centerline.inscribed_radius[np.isfinite(centerline.inscribed_radius)]
        diameter = float(np.ceil(4 * np.max(radius))) if len(radius) else 40.0
        return min(60.0, diameter), min(300.0, float(np.ceil(np.max(centerline.arc_length))))

    def suggestedDiameter(self, parameterNode):
        """A diameter that fits the vessel where a new stent is put, mm; 8 where the radius is unknown."""
        radius = self.centerline(parameterNode).inscribed_radius
        known = radius[np.isfinite(radius)]
        return float(round(2 * np.median(known), 1)) if len(known) else 8.0

    @staticmethod
    def _stamp(parameterNode):
        """A value that changes whenever vessel or centerline do."""
        return (
            Conversion.changeStamp(parameterNode.vessel),
            Conversion.segmentOf(parameterNode),
            Conversion.changeStamp(parameterNode.centerline),
        )
