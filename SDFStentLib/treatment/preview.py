"""Preview of a plan's stents in the vessel while they are dragged: on a proxy, at any size of mesh.

>>> preview = Preview(surface, centerline)                          # doctest: +SKIP
>>> while dragging:
...     seen = preview.of(stents)
...     show(seen.indices, seen.coordinates)
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..deformation import DeploymentSettings, Proxy, ProxyState
from ..geometry import Surface
from ..lumen import VesselInside, rough_radii
from ..stent import Stent
from ..validation import Floats, Indices, Points, as_number, read_only
from ..vessel import Lesion, lesions_within, tightest
from .branches import covered_where_moved
from .placer import InterimVessel, Placer
from .straightening import AxisChange
from .surroundings import PROFILE_SPACING
from .value import PlacedStent, TreatedStent, labeled, switched_on

NEAR = 6.0
"""Wall so far beyond a stent still follows it, mm; the usual influence distance is 6.5."""

MOST_STATIONS = 24
"""The most stations at which the lumen of a preview is measured, about."""


class PreviewedNumbers(NamedTuple):
    """Approximate numbers of one stent of a preview."""

    lumen: float
    """Smallest inscribed diameter along it, mm; NaN where the proxy is too coarse."""
    lesion: Lesion | None
    """Worst lesion that it covers, as it was; None where it covers none, or none is known."""
    left: float
    """Worst residual stenosis in the vessels in which stents cover a lesion, percent by diameter;
    NaN where that is not known, negative where it is wider than the reference."""
    covered: tuple[int, int] | None = None
    """Numbers of branches beside it that stents covered when it was measured, and do now; None
    where that is not known."""


@dataclass(frozen=True)
class PreviewedStent(PlacedStent):
    """A stent of a preview.

    Attributes
    ----------
    state : ProxyState
        The wall after it, before the stents after it.
    """

    state: ProxyState

    def minimum_lumen(self) -> float:
        """The approximate smallest inscribed diameter along the stent once it is finished, mm.

        NaN where the proxy is too coarse for the lumen.
        """
        spacing = max(PROFILE_SPACING, self.axis.deployed_length / MOST_STATIONS)
        return float(self.diameters(self.axis.line.resampled(spacing).points).min())

    def diameters(self, places: Points) -> Floats:
        """Approximate diameters at two places or more along the vessel (n, 3), before later stents.

        Measured among the points of the proxy, which lie near the stent.
        """
        found = 2 * rough_radii(self.state.points, places, self.state.normals)
        return np.where(found > self.state.spacing, found, np.nan)


@dataclass(frozen=True)
class PreviewState:
    """The vessel as a preview shows it.

    Attributes
    ----------
    indices : (k,) array
        Points that have moved.
    coordinates : (k, 3) array
        Places of these points, mm.
    stents : tuple of PreviewedStent
        Stents that are switched on, in order.
    """

    indices: Indices
    coordinates: Points
    stents: tuple[PreviewedStent, ...]

    def numbers(
        self, lesions: Sequence[Lesion] = (), measured: Sequence[TreatedStent] = ()
    ) -> tuple[PreviewedNumbers, ...]:
        """Approximate numbers of each of the stents, and what they leave of the vessel's lesions.

        `measured` are stents of the last treatment of this vessel, from which they were moved.
        """
        covered = [lesions_within(lesions, one.axis.line) for one in self.stents]
        treated = {lesion.vessel for some in covered for lesion in some}
        left = [self._left(lesion) for lesion in lesions if lesion.vessel in treated]
        worst = float(np.max(left)) if left else float("nan")
        found = [
            PreviewedNumbers(
                one.minimum_lumen(),
                max(some, key=lambda lesion: lesion.percent_diameter, default=None),
                worst,
            )
            for one, some in zip(self.stents, covered, strict=True)
        ]
        return self.with_covered(found, measured)

    def with_covered(
        self, numbers: Sequence[PreviewedNumbers], measured: Sequence[TreatedStent]
    ) -> tuple[PreviewedNumbers, ...]:
        """The `numbers` of all stents with the branches that they cover, by what was `measured`."""
        return tuple(
            some._replace(covered=self._covered(one, measured))
            for one, some in zip(self.stents, numbers, strict=True)
        )

    def _covered(
        self, placed: PreviewedStent, measured: Sequence[TreatedStent]
    ) -> tuple[int, int] | None:
        """Branches beside a stent that were covered, and that are."""
        touching = [one for one in self.stents if len(one.state.state.indices)]
        for treated in measured:
            if treated.number == placed.number:
                return covered_where_moved(treated, placed, touching)
        return None

    def _left(self, lesion: Lesion) -> float:
        """Residual stenosis anywhere in a lesion, percent; far from the stents it is as it was."""
        diameters = lesion.diameters.copy()
        for one in self.stents:
            away = one.axis.line.nearest(lesion.line.points).distances
            # The wall round these is among the points near the stent.
            near = away + lesion.healthy / 2 < one.stent.widest_diameter / 2 + NEAR
            if near.sum() > 1:
                found = one.diameters(lesion.line.points[near])
                if np.isnan(found).any():
                    return float("nan")
                diameters[near] = np.fmax(found, diameters[near])
        narrowest = tightest(diameters, lesion.healthy)
        return float(100 * (1 - diameters[narrowest] / lesion.healthy[narrowest]))


class Preview:
    """A vessel on which plans are tried out, see `Proxy`.

    Parameters
    ----------
    surface : Surface
        Surface of the vessel.
    centerline : Centerline, optional
        Needed for every placement but along an axis.
    """

    def __init__(self, surface: Surface, centerline: Centerline | None = None) -> None:
        self.surface, self.centerline = surface, centerline
        self._proxy = Proxy(surface, None if centerline is None else centerline.points)
        self._points, self._lumen = surface.points.copy(), VesselInside(surface)

    def prepare(self) -> None:
        """Prepare the first preview: what is the same wherever it will be."""
        if self.centerline is not None:
            self._proxy.probes(self.centerline.points)

    def of(
        self,
        stents: Sequence[Stent],
        settings: DeploymentSettings | None = None,
        *,
        straightening_fraction: float = 0.0,
        rows: Sequence[int] = (),
    ) -> PreviewState:
        """The vessel after some stents; parameters and errors as for `Treatment`."""
        fraction = as_number(straightening_fraction, "straightening", minimum=0, maximum=1)
        settings = settings or DeploymentSettings.preview()
        numbers = [number for number, _stent in switched_on(stents)]
        change = AxisChange.of(fraction, settings)
        placer = Placer(self.surface, stents, change, rows, self._proxy.probes)
        grown: list[PreviewedStent] = []

        def grow(
            placed: PlacedStent, course: InterimVessel
        ) -> Generator[None, None, InterimVessel]:
            is_last = placed.number == numbers[-1]
            points = self._points if grown else None
            with labeled(placer.label(placed.number)):
                # Nobody asks where the last one drags the centerline.
                dragged = () if is_last else course.dragged
                grown.append(self._grown(placed, settings, points, dragged))
            state = grown[-1].state.state
            if len(numbers) > 1:
                self._points[state.indices] = state.coordinates
            yield from ()
            return course if is_last else course.after(self._lumen, state.companions)

        try:
            deque(placer.in_turn(numbers, InterimVessel(self._lumen, self.centerline), grow))
            moved, coordinates = self._moved(grown)
            return PreviewState(read_only(moved), read_only(coordinates), tuple(grown))
        finally:
            for one in grown if len(numbers) > 1 else ():
                indices = one.state.state.indices
                self._points[indices] = self.surface.points[indices]

    def _grown(
        self,
        placed: PlacedStent,
        settings: DeploymentSettings,
        points: Points | None,
        dragged: ArrayLike,
    ) -> PreviewedStent:
        """A stent that has grown in the sample of the wall."""
        stent, axis = placed.stent, placed.axis
        chain = settings.chain(axis.line, axis.profile)
        state = self._proxy.deployed(
            chain, stent.widest_diameter / 2, settings, points=points, companions=dragged
        )
        return PreviewedStent(placed.number, stent, axis, state, row=placed.row)

    def _moved(self, previewed: Sequence[PreviewedStent]) -> tuple[Indices, Points]:
        """Points that some stents have moved, and where they are, mm."""
        if len(previewed) == 1:
            return previewed[0].state.state.indices, previewed[0].state.state.coordinates
        moved = np.unique(np.concatenate([one.state.state.indices for one in previewed]))
        return moved, self._points[moved]
