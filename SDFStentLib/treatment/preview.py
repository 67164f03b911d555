"""What a plan's stents do to the vessel, while they are dragged: on a proxy, at any size of mesh.

>>> preview = Preview(surface, centerline)                          # doctest: +SKIP
>>> while dragging:
...     seen = preview.of(stents)
...     show(seen.indices, seen.coordinates)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..centerline import Centerline
from ..deformation import DeploymentSettings, Proxy, ProxyState
from ..geometry import Surface
from ..lumen import VesselInside, rough_radii
from ..stent import Stent
from ..validation import Indices, Points, as_number, read_only
from .straightening import AxisChange, axis_in_vessel
from .surroundings import PROFILE_SPACING
from .value import PlacedStent, label_of, labeled, resolved, switched_on
from .warnings import check_width

MOST_STATIONS = 24
"""At which the lumen of a preview is measured, about."""


@dataclass(frozen=True)
class PreviewedStent(PlacedStent):
    """One stent of a preview.

    Attributes
    ----------
    state : ProxyState
        The wall after it, before the stents after it.
    """

    state: ProxyState

    def minimum_lumen(self) -> float:
        """About the smallest inscribed diameter along the stent once it is finished, mm.

        Measured among the points of the proxy, before later stents. NaN where the proxy is too
        coarse for the lumen.
        """
        spacing = max(PROFILE_SPACING, self.axis.deployed_length / MOST_STATIONS)
        state, stations = self.state, self.axis.line.resampled(spacing).points
        smallest = 2 * float(rough_radii(state.points, stations, state.normals).min())
        return smallest if smallest > state.spacing else float("nan")


@dataclass(frozen=True)
class PreviewState:
    """The vessel as a preview shows it.

    Attributes
    ----------
    indices : (k,) array
        Points that have moved.
    coordinates : (k, 3) array
        Where they are, mm.
    stents : tuple of PreviewedStent
        Those that are switched on, in order.
    """

    indices: Indices
    coordinates: Points
    stents: tuple[PreviewedStent, ...]


class Preview:
    """A vessel on which plans are tried out, see `Proxy`.

    Parameters
    ----------
    surface : Surface
        Of the vessel.
    centerline : Centerline, optional
        Needed for every placement but along an axis.
    """

    def __init__(self, surface: Surface, centerline: Centerline | None = None) -> None:
        self.surface, self.centerline = surface, centerline
        self._proxy = Proxy(surface, None if centerline is None else centerline.points)
        self._points, self._lumen = surface.points.copy(), VesselInside(surface)

    def prepare(self) -> None:
        """Make now what the first preview needs and what is the same wherever it will be."""
        if self.centerline is not None:
            self._proxy.probes(self.centerline.points)

    def of(
        self,
        stents: Sequence[Stent],
        settings: DeploymentSettings | None = None,
        *,
        straightening_fraction: float = 0.0,
    ) -> PreviewState:
        """The vessel after some stents; parameters and errors as for `Treatment`."""
        fraction = as_number(straightening_fraction, "straightening", minimum=0, maximum=1)
        settings = settings or DeploymentSettings.preview()
        centerline, enabled = self.centerline, switched_on(stents)
        previewed: list[PreviewedStent] = []
        try:
            for number, planned in enabled:
                is_last = len(previewed) == len(enabled) - 1
                tree = None if is_last else centerline
                with labeled(label_of(stents, number)):
                    stent, lies_on = resolved(planned, {one.number: one for one in previewed})
                    change = AxisChange.of(fraction, settings)
                    axis = axis_in_vessel(stent, centerline, self._lumen, change, lies_on=lies_on)
                    probes = self._proxy.probes(axis.points)
                    check_width(stent.widest_diameter, axis, self.surface, probes)
                    state = self._proxy.deployed(
                        settings.chain(axis.line, axis.profile),
                        stent.widest_diameter / 2,
                        settings,
                        points=self._points if previewed else None,
                        companions=() if tree is None else tree.points,
                    )
                previewed.append(PreviewedStent(number, stent, axis, state))
                if len(enabled) > 1:
                    self._points[state.state.indices] = state.state.coordinates
                centerline = tree and tree.with_points(state.state.companions)
            moved, coordinates = self._moved(previewed)
            return PreviewState(read_only(moved), read_only(coordinates), tuple(previewed))
        finally:
            if len(enabled) > 1:
                for one in previewed:
                    indices = one.state.state.indices
                    self._points[indices] = self.surface.points[indices]

    def _moved(self, previewed: Sequence[PreviewedStent]) -> tuple[Indices, Points]:
        """Points that some stents have moved, and where they are, mm."""
        if len(previewed) == 1:
            return previewed[0].state.state.indices, previewed[0].state.state.coordinates
        moved = np.unique(np.concatenate([one.state.state.indices for one in previewed]))
        return moved, self._points[moved]
