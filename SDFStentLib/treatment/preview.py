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
from ..geometry import Surface, resampled
from ..measure import rough_radii
from ..stent import Stent, StentAxis, stent_axis
from ..validation import DeploymentError, Indices, InputError, Points, as_number, read_only
from .straightening import axis_in_vessel
from .treatment import PROFILE_SPACING
from .value import label_of, switched_on
from .warnings import check_width

MOST_STATIONS = 24
"""At which the lumen of a preview is measured, about."""


@dataclass(frozen=True)
class PreviewedStent:
    """One stent of a preview.

    Attributes
    ----------
    number : int
        In the plan, from 1.
    stent : Stent
    axis : StentAxis
        Where it lies.
    state : ProxyState
        The wall after it, before the stents after it.
    """

    number: int
    stent: Stent
    axis: StentAxis
    state: ProxyState

    def minimum_lumen(self) -> float:
        """About the smallest inscribed diameter along the stent once it is finished, mm.

        Measured among the points of the proxy, before later stents. NaN where the proxy is too
        coarse for the lumen.
        """
        spacing = max(PROFILE_SPACING, self.axis.deployed_length / MOST_STATIONS)
        state, stations = self.state, resampled(self.axis.points, spacing)
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
        self._points = surface.points.copy()

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
        """The vessel after some stents; parameters and errors as for `Treatment`.

        Whether the points of a placement lie in the lumen is left to the full deployment.
        """
        fraction = as_number(straightening_fraction, "straightening", minimum=0, maximum=1)
        settings = settings or DeploymentSettings.preview()
        centerline, enabled = self.centerline, switched_on(stents)
        previewed: list[PreviewedStent] = []
        try:
            for number, stent in enabled:
                label = label_of(stents, number)
                axis = self._axis(stent, centerline, fraction, label)
                is_last = len(previewed) == len(enabled) - 1
                tree = None if is_last else centerline
                state = self._deployed(axis, stent, settings, tree, label)
                previewed.append(PreviewedStent(number, stent, axis, state))
                self._points[state.state.indices] = state.state.coordinates
                centerline = tree and tree.with_points(state.state.companions)
            moved = _united([one.state.state.indices for one in previewed])
            return PreviewState(read_only(moved), read_only(self._points[moved]), tuple(previewed))
        finally:
            for one in previewed:
                indices = one.state.state.indices
                self._points[indices] = self.surface.points[indices]

    def _axis(
        self, stent: Stent, centerline: Centerline | None, fraction: float, label: str
    ) -> StentAxis:
        try:
            if fraction:
                axis = axis_in_vessel(stent, centerline, self.surface, fraction)
            else:
                axis = stent_axis(stent, centerline)
            check_width(stent.diameter, axis, self._proxy.probes(axis.points))
            return axis
        except InputError as error:
            raise error.labeled(label) from error

    def _deployed(
        self,
        axis: StentAxis,
        stent: Stent,
        settings: DeploymentSettings,
        tree: Centerline | None,
        label: str,
    ) -> ProxyState:
        chain = settings.chain(axis.points)
        try:
            return self._proxy.deployed(
                chain,
                stent.radius,
                settings,
                points=self._points,
                companions=() if tree is None else tree.points,
            )
        except DeploymentError as error:
            raise DeploymentError(f"{label}{error}") from error


def _united(parts: Sequence[Indices]) -> Indices:
    return parts[0] if len(parts) == 1 else np.unique(np.concatenate(parts))
