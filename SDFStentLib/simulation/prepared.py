"""A segment before a stent and after it, meshed twice, with what flows through its ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..files import VolumeMesh
from ..flow import PASCAL_PER_MMHG, FlowModel, Moment, Part, Solve
from ..geometry import Line, norm, state_of
from ..segment import Segment, SegmentFace, with_inlets
from ..treatment import ExtractedSegment, SegmentWishes, Vessel, extract_segment
from ..validation import DeploymentError, Floats, InputError, Points, as_place
from ..vessel import vessel_parts
from .conditions import CGS_PRESSURE, Conditions, EndFlows, conditions_of, ends_of
from .ends import SPACING, FlowEnds, ends_beyond, extended
from .mmg import check_mmg
from .remesh import Axis, Remeshed, Wishes, axis_of, edge_sizes, edges_around, remeshed
from .solver_file import TimeSteps, time_steps
from .tetrahedra import Quality, check_meshers, filled, quality

COARSER = 1.5
"""Times the edges of the second mesh, whose difference is the error bar."""

FLAT_DEG = 1.0
"""Angle between two sides from which a tetrahedron is too flat: its weight in the equations goes
with the cotangent, and solvers fail on it."""

STATES = ("before", "after")


class Filled(NamedTuple):
    """A surface with tetrahedra in it."""

    made: Remeshed
    volume: VolumeMesh
    quality: Quality


class Mesh(NamedTuple):
    """The mesh of one state."""

    made: Remeshed
    volume: VolumeMesh
    quality: Quality
    edges_round: int
    """Edges round the vessel at the throat."""
    steps: TimeSteps


class Throat(NamedTuple):
    """The narrowest place along the segment."""

    place: Points
    """(3,) mm."""
    direction: Floats
    """(3,) of the vessel there."""
    radius: float
    """mm."""


class Lines(NamedTuple):
    """Points of the centerlines at even distances, mm."""

    tree: Points
    way: Points


class State(NamedTuple):
    """A state of the vessel."""

    segment: Segment
    conditions: Conditions
    meshes: dict[str, Mesh]
    """`fine` and `coarse`."""
    throat: Throat


class Prepared(NamedTuple):
    """Input of a solver, and the network to compare its results with."""

    states: dict[str, State]
    way: Points
    """(k, 3) of the centerline through the segment, mm."""
    main_outlet: str
    """The face at the end of the way."""
    network: Mapping[str, Mapping[str, tuple[float, float, float]]]
    """Pressures of the network by state: a value, and between what it lies, mmHg."""
    level: float | None
    """mmHg, to be added to the pressures of the solver; None where none is known."""
    extensions: dict[str, float]
    """mm, by face."""
    warnings: tuple[Caution, ...]


class Cut(NamedTuple):
    """Options of cutting the segment."""

    ends: tuple[Points, Points] | None = None
    """mm; None to take those that `ends_beyond` finds."""
    close_branches: bool = False
    units: str = "mm"


def prepare(
    vessels: tuple[Vessel, Vessel],
    model: FlowModel,
    cut: Cut,
    wishes: Wishes,
    tell: Callable[[float, str], None] = lambda _part, _words: None,
    *,
    solve: Solve | None = None,
) -> Prepared:
    """Cut, extend and mesh a vessel before a stent and after it.

    Parameters
    ----------
    vessels : pair of Vessel
        Vessel before, with a centerline, and after, with the same triangles.
    model : FlowModel
        Flow of the vessel before.
    cut : Cut
    wishes : Wishes
    tell : callable, optional
        Called with the part of the work that is done, and the next step.
    solve : callable, optional
        As of `FlowModel.answer`.

    Raises
    ------
    InputError
        No places for planes, other triangles after, or a mesher that is not installed.
    DeploymentError
        No sound segment, or a mesher that fails.
    """
    check_mmg()
    check_meshers()
    before, after = vessels
    tree = before.centerline
    assert tree is not None
    state_of(before.surface, after.surface, "treated vessel")
    ends = _ends(vessels, cut)
    tell(0.05, "the segment")
    channels = before.followed.after(tree, after.surface)
    found, way, main = _cut_out(vessels, model, cut, ends)
    assert found.after is not None
    segments, extensions, warnings = _with_extensions(found, ends)
    answer = model.answer(channels, [Part("the segment", way)], solve)
    moments = (answer.before, answer.after or {})
    told = {name: _known(one["mean"]) for name, one in zip(STATES, moments, strict=True)}
    conditions = conditions_of(answer, model.channels, found.before, found.after)
    lines = Lines(tree.resampled(SPACING).points, Line(way).resampled(SPACING).points)
    both = zip(segments, conditions, strict=True)
    # What takes too many steps is refused before anything is meshed.
    planned = [_planned(segment, own, lines, wishes) for segment, own in both]
    states = {}
    for number, (name, plan) in enumerate(zip(STATES, planned, strict=True)):
        tell(0.1 + 0.45 * number, f"meshes {name}")
        states[name] = _meshed(plan)
    offset = conditions[0].offset / (CGS_PRESSURE * PASCAL_PER_MMHG)
    level = offset if model.known.has_pressures else None
    return Prepared(states, way, main, told, level, extensions, (*found.warnings, *warnings))


def _cut_out(
    vessels: tuple[Vessel, Vessel], model: FlowModel, cut: Cut, ends: FlowEnds
) -> tuple[ExtractedSegment, Points, str]:
    """The segment in both states, the way of the blood through it, and its end, as `_along_flow`
    has them."""
    before, after = vessels
    tree = before.centerline
    assert tree is not None
    branches = SegmentWishes(cut.close_branches, not cut.close_branches, units=cut.units)
    found = extract_segment(before, ends.start, ends.end, branches, after=after)
    way = tree.path(*tree.ends_of_path(ends.start, ends.end)).points
    means = EndFlows(model.answer(), 0, model.channels).out_of(found.before)
    return _along_flow(found, tree, way, means)


def _ends(vessels: tuple[Vessel, Vessel], cut: Cut) -> FlowEnds:
    """The ends of a cut, or the ends beyond the wall that moved."""
    if cut.ends is not None:
        return FlowEnds(*cut.ends, (0.0, 0.0))
    before, after = vessels
    assert before.centerline is not None
    parts = vessel_parts(before.surface, before.centerline, before.faces, cut.units)
    is_wall = ~np.isin(parts.ids, [*parts.caps])
    line = before.centerline.resampled(SPACING).points
    return ends_beyond(before, after, axis_of(parts.surface, is_wall, line), cut.units)


def _known(moment: Moment) -> dict[str, tuple[float, float, float]]:
    """Pressures of the network over the segment, and at the inlet where they are known, mmHg."""
    (drop,) = moment.drops
    told = {"recovered": (*drop.recovered,), "maximal": (*drop.maximal,)}
    return told if moment.inlet is None else {**told, "inlet": (*moment.inlet,)}


def _along_flow(
    found: ExtractedSegment, tree: Centerline, way: Points, means: Mapping[str, float]
) -> tuple[ExtractedSegment, Points, str]:
    """Segment with the inlets of the blood, the way from the first of them, and its end.

    `means` flow out of the ends before treatment, mL/s. The way is that between the two ends; where
    blood does not come in at its begin and leave at its end, it is that from an inlet to an outlet
    which has the most in common with it.
    """
    coming, leaving = ([n for n in means if sign * means[n] > 0] for sign in (-1, 1))
    if not coming:
        raise InputError(
            "segment: expected blood to come in at one of its ends, got ends at which nothing "
            "flows; name other ends of the segment, or the inlets of the vessel."
        )
    places = {face.name: face.center for face in ends_of(found.before)}
    start, end = (_at(found.before, place).name for place in way[[0, -1]])
    places |= {start: way[0], end: way[-1]}

    def between(first: str, last: str) -> Points:
        return tree.path(*tree.ends_of_path(places[first], places[last])).points

    def merits(pair: tuple[str, str]) -> tuple[float, float]:
        own = set(map(tuple, between(*pair).tolist()))
        inside = np.array([tuple(point) in own for point in way.tolist()])
        shared = norm(np.diff(way, axis=0))[inside[1:] & inside[:-1]].sum()
        return round(float(shared), 6), means[pair[1]] - means[pair[0]]

    first, last = start, end
    if start not in coming or end not in leaving:
        first, last = max(((a, b) for a in coming for b in leaving), key=merits)
        way = between(first, last)
    inlets = sorted(coming, key=lambda name: name != first)
    before, after = (
        replace(one, faces=with_inlets(one.faces, inlets))
        for one in (found.before, found.after)
        if one is not None
    )
    return replace(found, before=before, after=after), way, _at(before, way[-1]).name


def _with_extensions(
    found: ExtractedSegment, ends: FlowEnds
) -> tuple[tuple[Segment, Segment], dict[str, float], list[Caution]]:
    """Both states, with as much tube at both ends as vessel is missing there."""
    assert found.after is not None
    segments, made, warnings = (found.before, found.after), dict[str, float](), []
    for place, by in zip((ends.start, ends.end), ends.missing, strict=True):
        face = _at(found.before, place)
        if by < np.sqrt(face.area / np.pi) / 2:
            continue
        longer = [extended(segment, face.name, by) for segment in segments]
        if longer[0] is None or longer[1] is None:
            numbers: dict[str, float | str] = {"name": face.name, "distance_mm": by}
            warnings.append(Caution("no-room-for-tube", numbers, as_place(face.center)))
            continue
        segments, made[face.name] = (longer[0], longer[1]), by
    return segments, made, warnings


def _at(segment: Segment, place: Points) -> SegmentFace:
    """End nearest to a place."""
    return min(ends_of(segment), key=lambda face: float(np.linalg.norm(face.center - place)))


class _Planned(NamedTuple):
    """A state of which nothing is meshed yet."""

    segment: Segment
    conditions: Conditions
    axis: Axis
    throat: Throat
    meshes: dict[str, tuple[Wishes, TimeSteps]]


def _planned(segment: Segment, conditions: Conditions, lines: Lines, wishes: Wishes) -> _Planned:
    is_wall = np.isin(segment.face_ids, [*segment.walls])
    axis = axis_of(segment.surface, is_wall, lines.tree)
    way = axis_of(segment.surface, is_wall, lines.way)
    throat = int(np.argmin(way.radius))
    at = Throat(way.points[throat], Line(way.points).directions[throat], float(way.radius[throat]))
    coarse = wishes._replace(coarser=COARSER * wishes.coarser)
    meshes = {}
    for name, one in (("fine", wishes), ("coarse", coarse)):
        edge = float(edge_sizes(at.place[None], axis, one)[0])
        meshes[name] = one, time_steps(conditions, edge, at.radius, segment.volume)
    return _Planned(segment, conditions, axis, at, meshes)


def _meshed(plan: _Planned) -> State:
    meshes = {name: _mesh(plan, *one) for name, one in plan.meshes.items()}
    return State(plan.segment, plan.conditions, meshes, plan.throat)


def _mesh(plan: _Planned, wishes: Wishes, steps: TimeSteps) -> Mesh:
    found = well_filled(remeshed(plan.segment, plan.axis, wishes))
    place, direction, _ = plan.throat
    return Mesh(*found, edges_around(found.made.surface, place, direction), steps)


def well_filled(surfaces: Iterable[Remeshed]) -> Filled:
    """First surface filled without flat tetrahedra, and these tetrahedra."""
    flattest = 0.0
    for made in surfaces:
        volume = filled(made)
        shape = quality(volume)
        flattest = min(shape.smallest_angle, 180 - shape.largest_angle)
        if flattest >= FLAT_DEG:
            return Filled(made, volume, shape)
    raise DeploymentError(
        f"mesh: expected tetrahedra with angles of at least {FLAT_DEG:g} degree between their "
        f"sides, got one of {flattest:.2g}; take more edges round the vessel, or choose other ends "
        "of the segment."
    )
