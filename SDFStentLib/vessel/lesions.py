"""Lesions of a vessel tree: where it is narrower than the healthy vessel beside it.

A lesion is a property of the vessel. No stent takes part in what it measures.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import (
    Line,
    NamedFaces,
    Surface,
    as_line,
    as_surface,
    checked_faces,
    places_in_plane,
)
from ..lumen import ASKEW, CENTERED
from ..validation import Floats, as_place
from .branch_lumen import tree_lumen
from .branch_names import named_branches, size_words
from .caliber import EDGE_DEGREE, healthy_caliber
from .found_narrowings import FoundNarrowing, found_narrowings, measured_runs
from .lesion_measuring import lesions_after, measured, with_limbs
from .lesion_sections import healthy_area
from .lesion_value import HealthyPlace, Lesion, reference_words
from .narrowings import SMALLEST_DEGREE, Plateau
from .runs import VesselRun, is_main

SMALL_VESSEL = 3.0
"""Healthy diameter below which lesions come last, mm: pulmonary artery stents in the device table
begin at 4 mm, and rows of a balloon at 2."""


def find_lesions(
    surface: Surface,
    centerline: Centerline,
    faces: NamedFaces | None = None,
    given: Sequence[str | None] = (),
) -> tuple[Lesion, ...]:
    """Lesions of a vessel tree: of the main vessels first, then the tightest first.

    Those in vessels below `SMALL_VESSEL` come last.

    Parameters
    ----------
    surface : Surface
        Surface before any stent; open or closed.
    centerline : Centerline
        Vessels begin at its root.
    faces : NamedFaces, optional
        Faces of the surface; they name the branches.
    given : sequence of str or None
        `given_names`, which come before those.

    Returns
    -------
    tuple of Lesion
        Each once. What is not wider again beyond by `narrowings.SMALLEST_DEGREE` on both sides, or
        at an ostium or before an end that cuts it off by `narrowings.SMALLEST_ONE_SIDED` on one, is
        none, nor is what lies within a radius of an in- or outlet. Where no healthy vessel is in
        reach, the degree is that against the widest part.

    Raises
    ------
    InputError
        No surface, or a centerline outside of it.
    """
    return TreeLesions(surface, centerline, faces, given).every


class TreeLesions:
    """Lesions of a vessel tree, measured when somebody asks: those near the root before the others.

    Parameters and errors as of `find_lesions`.
    """

    def __init__(
        self,
        surface: Surface,
        centerline: Centerline,
        faces: NamedFaces | None = None,
        given: Sequence[str | None] = (),
    ) -> None:
        self._surface = surface = as_surface(surface)
        runs, asked = measured_runs(surface, centerline)
        found = found_narrowings(runs, asked)
        faces = checked_faces(faces, len(surface.triangles))
        named = named_branches(surface, centerline, faces, given)
        self._main = [is_main(run, runs) for run in runs]
        starts = centerline.arc_length[[branch[0] for branch in centerline.branches]]
        every = [*found, *(limb for one in found for limb in one.limbs)]
        begun = []
        for one, healthy in zip(every, _healthy_places(surface, every), strict=True):
            otherwise = vessel_name(runs[one.vessel], self._main[one.vessel])
            names = [name or otherwise for name in named]
            begun.append(_begun(one, healthy, names, starts, surface))
        self._wall = tree_lumen(surface, centerline).spheres.surface
        # No main vessel has more than one before it: what begins later takes none of its lesions.
        self._early, self._late = list[Lesion](), list[Lesion]()
        for lesion in with_limbs(begun, [len(one.limbs) for one in found]):
            first = min(one.generation for one in (lesion, *lesion.limbs))
            (self._early if first <= 1 else self._late).append(lesion)

    @cached_property
    def first(self) -> tuple[Lesion, ...]:
        """Those of `every` that come before the others, however narrow these are: of main vessels
        that are not small."""
        return tuple(one for one in self._in_order(self._near_root) if self._is_first(one))

    @cached_property
    def every(self) -> tuple[Lesion, ...]:
        """All of them, as of `find_lesions`."""
        return self._in_order([*self._near_root, *self._measured(self._late)])

    @property
    def others(self) -> Iterator[Lesion]:
        """What may be among the others, limbs as well, and may not be measured: their reference is
        the widest."""
        early = (one for one in self._in_order(self._near_root) if not self._is_first(one))
        for whole in (*early, *self._late):
            for one in (whole, *whole.limbs):
                yield replace(one, reference_diameter=float(one.healthy.max()))

    @cached_property
    def _near_root(self) -> list[Lesion]:
        return self._measured(self._early)

    def _measured(self, begun: Sequence[Lesion]) -> list[Lesion]:
        every = [*begun, *(limb for one in begun for limb in one.limbs)]
        found = measured(every, self._surface, self._wall)
        return with_limbs(found, [len(one.limbs) for one in begun])

    def _in_order(self, lesions: Sequence[Lesion]) -> tuple[Lesion, ...]:
        return tuple(sorted(_told(lesions), key=self._rank))

    def _is_first(self, lesion: Lesion) -> bool:
        return not any(self._rank(lesion)[:2])

    def _rank(self, lesion: Lesion) -> tuple[bool, bool, float]:
        is_small = lesion.reference_diameter < SMALL_VESSEL
        return is_small, not self._main[lesion.vessel], -lesion.percent_diameter


def _told(lesions: Sequence[Lesion]) -> list[Lesion]:
    """The lesions, and limbs, that are as deep as measured, each once.

    A limb of what is measured to be none is a lesion itself.
    """
    least, told = 100 * SMALLEST_DEGREE, list[Lesion]()
    for lesion in lesions:
        limbs = [limb for limb in lesion.limbs if limb.percent_diameter >= least]
        if lesion.percent_diameter < least:
            told += limbs
        else:
            told += with_limbs([lesion, *(own := _each_once(limbs, [lesion]))], [len(own)])
    return _each_once(told)


def _each_once(lesions: Sequence[Lesion], known: Sequence[Lesion] = ()) -> list[Lesion]:
    """The lesions without those of branches whose narrowest sphere is that of their vessel, or of
    a known one; one that is narrower by more than an edge is not."""
    kept = [*known]
    for one in sorted(lesions, key=lambda one: (one.generation, -one.percent_diameter)):
        if not any(_is_same(one, other) for other in kept):
            kept.append(one)
    return kept[len(known) :]


def _is_same(one: Lesion, other: Lesion) -> bool:
    away = float(np.linalg.norm(np.subtract(one.point, other.point)))
    is_narrower = one.minimum_diameter < (1 - EDGE_DEGREE) * other.minimum_diameter
    return away < other.minimum_diameter / 2 and not is_narrower


def vessel_name(run: VesselRun, is_main: bool) -> str:
    """Name of a vessel that the user has not named: size, place and the ends it leads to."""
    ends = f"{run.outlets} outlets" if run.outlets > 1 else "1 outlet"
    if run.generation == 0:
        return f"main vessel ({ends})"
    caliber = healthy_caliber(run)
    if is_main:
        return f"main branch {f'of {caliber:.1f} mm ' if caliber else ''}({ends})"
    known = np.flatnonzero(np.isfinite(run.diameter))
    start = run.along[known[0] if len(known) else 0]
    return f"branch {size_words(caliber, float(start), run.outlets)}"


def lesion_after(lesion: Lesion, surface: Surface) -> Lesion:
    """Lesion on another surface, at the same part of the vessel against the same reference.

    Parameters
    ----------
    lesion : Lesion
        Lesion as found before treatment.
    surface : Surface
        Surface after it.

    Returns
    -------
    Lesion
        With the residual stenosis; negative percentages where it is wider than the reference.

    Raises
    ------
    InputError
        No surface.
    """
    return lesions_after([lesion], as_surface(surface))[0]


def lesions_within(
    lesions: Sequence[Lesion], axis: Line | ArrayLike, beyond: float = 1.0
) -> tuple[Lesion, ...]:
    """The lesions that a stent along an axis would treat: it reaches the narrowest place.

    Parameters
    ----------
    lesions : sequence of Lesion
    axis : Line or array_like, shape (n, 3)
        Axis of the stent from end to end, mm.
    beyond : float
        Radii of the sphere at the narrowest place by which that may lie beyond an end: a stent that
        begins at a throat, or ends there, treats it. 0: it is covered.
    """
    line = as_line(axis, "axis")
    return tuple(lesion for lesion in lesions if _passes(line, lesion, beyond))


def _passes(axis: Line, lesion: Lesion, beyond: float) -> bool:
    """Whether an axis goes through a lesion's narrowest place, along its vessel.

    It runs inside the sphere there, or in the inner half of the healthy lumen, and crosses the
    section. At a junction an axis into another branch may run inside the sphere as well.
    """
    radius, at = lesion.minimum_diameter / 2, lesion.arc_length - lesion.start
    # In a throat of coarse or rough wall a sphere lies beside the line, and smoothing moves that by
    # half a millimeter.
    reach = max(radius, CENTERED * lesion.reference_diameter / 2)
    before, after = lesion.line.at([at - reach, at + reach])
    first, last = beyond * radius * axis.directions[[0, -1]]
    line = np.vstack([axis.points[0] - first, axis.points, axis.points[-1] + last])
    places = places_in_plane(line[:-1], line[1:], np.array(lesion.point), after - before)
    offsets = np.linalg.norm(places - lesion.point, axis=1)
    nearest = axis.nearest(np.array([lesion.point])).distances[0]
    # One that goes aslant meets the section farther from its middle than it passes that.
    return bool(nearest <= reach and (offsets <= reach / ASKEW).any())


def _begun(
    found: FoundNarrowing,
    healthy: Sequence[HealthyPlace | None],
    names: Sequence[str],
    starts: Floats,
    surface: Surface,
) -> Lesion:
    """A narrowing with its reference, and diameters along its line.

    Arc lengths become those of the centerline, on whose branches with `names` and `starts` (n,) it
    lies.
    """
    run, narrow = found.run, found.narrow
    known = np.isfinite(run.diameter)
    first, start = int(np.argmax(known)), narrow.start
    if narrow.narrowest <= run.along[first] and first:
        # At an ostium it may be narrower before the first station that is known.
        start = float(run.along[first - 1])
    inner = (run.along > start) & (run.along < narrow.end)
    along = np.r_[start, run.along[inner], narrow.end]
    line = np.vstack([_at(run, start), run.points[inner], _at(run, narrow.end)])
    ends = np.interp([start, narrow.end], run.along[known], run.diameter[known], left=np.nan)
    at = int(np.abs(run.along - narrow.narrowest).argmin())
    unknown = float("nan")
    shift = float(starts[run.branch[at]] + run.branch_along[at] - run.along[at])
    # What another vessel's way passes before that begins is called after that vessel.
    own = int(np.flatnonzero(run.along >= found.way.begin_of(found.vessel))[:2].max())
    sides = [
        None if side is None else replace(side, arc_length=side.arc_length + shift)
        for side in healthy
    ]
    return Lesion(
        branch=int(run.branch[at]),
        branch_name=names[run.branch[max(at, own)]],
        branch_arc_length=float(run.branch_along[at]),
        arc_length=float(run.along[at]) + shift,
        start=float(start) + shift,
        end=float(narrow.end) + shift,
        point=as_place(run.points[at]),
        minimum_diameter=unknown,
        reference_diameter=unknown,
        percent_diameter=unknown,
        proximal=sides[0],
        distal=sides[1],
        reference=reference_words(
            sides, narrow.reference.widest, narrow.reference.beyond(narrow.narrowest)
        ),
        line=Line(line),
        healthy=narrow.reference.at(along),
        diameters=np.r_[ends[0], run.diameter[inner], ends[1]],
        surface=surface,
        vessel=found.vessel,
        generation=found.run.generation,
    )


def _healthy_places(
    surface: Surface, found: Sequence[FoundNarrowing]
) -> list[tuple[HealthyPlace | None, HealthyPlace | None]]:
    """The healthy places of all narrowings, with areas where sections are those of their vessel."""

    def place(run: VesselRun, side: Plateau | None) -> HealthyPlace | None:
        if side is None:
            return None
        point, area = _at(run, side.arc_length), partial(healthy_area, surface, run, side)
        return HealthyPlace(as_place(point), side.arc_length, side.diameter, area)

    return [(place(one.run, one.sides[0]), place(one.run, one.sides[1])) for one in found]


def _at(run: VesselRun, along: float) -> Floats:
    return np.array([np.interp(along, run.along, column) for column in run.points.T])
