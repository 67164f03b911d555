"""Centerlines of a bare surface: the widest ways through it, drawn onto inscribed spheres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..cautions import Caution
from ..centerline import (
    Centerline,
    ExtractedLines,
    InnerBalls,
    WidestWays,
    inner_balls,
    round_ends,
    touching_vessels,
    with_places,
)
from ..geometry import Line, Surface, as_surface, norm
from ..lumen import ALIKE, inscribed_spheres
from ..threads import ahead
from ..validation import (
    DeploymentError,
    Flags,
    Floats,
    Indices,
    InputError,
    Points,
    as_place,
    as_point,
    coordinates,
)
from ..vessel import ANEURYSM, KnownEnds, known_ends
from .blunt_ends import BluntEnd, blunt_ends

OPEN, BALLS, ENDS, DRAWN = 0.05, 0.43, 0.64, 0.69
"""Share of the time that has passed once the open ends, the balls, all ends and the ways between
them are known: of a patient's surface with 93 ends."""

STEP = 0.2
"""Distance of two points of a line, in radii of the lumen."""

SMOOTHED = 20
"""Number of times that a point goes half way to the middle between its neighbors: evens out what is
shorter than half a diameter or so."""

AGAIN = 1
"""Number of times for the centers of spheres, which are exact but for the triangles of the wall."""

ASIDE = 0.5
"""A sphere whose center is farther aside, in its radii, is that of another place."""


class Extraction(NamedTuple):
    """Centerlines of a bare surface, and cautions on them."""

    lines: ExtractedLines
    warnings: tuple[Caution, ...]

    @property
    def centerline(self) -> Centerline:
        """The lines as a tree whose root is the inlet."""
        points, lines, radii = self.lines
        return Centerline.from_lines(points, lines, radii, inlet=points[lines[0][0]])


def extract_centerline(
    surface: Surface,
    inlet: ArrayLike | None = None,
    outlets: Sequence[ArrayLike] = (),
    show: Callable[[float], None] = lambda _share: None,
) -> Extraction:
    """Centerlines from the inlet of a vessel to every other end, of nothing but its surface.

    The wall's points give the largest balls inside (`inner_balls`). The ways between them that cost
    least, by length over radius, are smoothed, and each of their points moves to the center of the
    largest sphere in its plane.

    Parameters
    ----------
    surface : Surface
        mm; its ends are open, closed by flat caps or cut flat with a round rim, or round and longer
        than they are wide.
    inlet : array_like, shape (3,), optional
        Names the proximal end, mm; by default the widest.
    outlets : sequence of array_like, shape (3,), optional
        Name the other ends; all that are found by default. A place away from every open end and
        flat cap stands for the point of the wall beside it, such as the tip of a rounded end.
    show : callable, optional
        Hears of the share that is done, again and again.

    Raises
    ------
    InputError
        There are not two ends, or one is named that is not there.
    DeploymentError
        The lumen does not lead from the inlet to an end that was named, or to none at all.
    """
    surface = as_surface(surface)
    start = None if inlet is None else as_point(inlet, "inlet")
    named = [as_point(outlet, "outlet") for outlet in outlets]
    seeds = known_ends(surface, start, named)
    show(OPEN)
    goals = _goals(seeds, bool(named), show)
    show(ENDS)
    ways = goals.ways
    reached = [end for end in goals.ends if ways.is_reached[end]]
    apart = [end for end in goals.ends if not ways.is_reached[end]]
    if apart and (named or not reached):
        raise DeploymentError(
            "no centerline found: the lumen does not lead to the end at "
            f"{coordinates(ways.balls.centers[apart[0]])} mm; look for holes and folds with "
            "sdfstent check."
        )
    # Of ends that are named, the one way is meant.
    meetings = ways.meetings if not named else np.empty((0, 2), dtype=np.int64)
    tree = ways.tree([*reached, *meetings.ravel().tolist()])
    drawn = _Drawing(tree, *ways.balls[:2])
    show(DRAWN)
    triangles = seeds.surface.wound_triangles
    # The middles of ends, the last points, are new; nothing shall limit the spheres there.
    count = len(seeds.surface.points) - seeds.end_count
    drawn.onto_spheres(seeds.surface.points, triangles[(triangles < count).all(axis=1)])
    lines = [drawn.line_to(end) for end in reached]
    for limb, other in meetings.tolist():
        last = drawn.line_to(limb)
        lines += [last, np.append(drawn.line_to(other), last[-1])]
    warnings = _cautions(goals, ways.parts_apart(apart), meetings, tree)
    for one in seeds.holes[:1]:  # the widest
        warnings.append(Caution("open-wall", {"diameter_mm": 2 * one.radius}, as_place(one.center)))
    return Extraction(ExtractedLines(drawn.points, tuple(lines), drawn.radii), tuple(warnings))


def _cautions(goals: _Goals, apart: list[int], met: Indices, tree: list[Indices]) -> list[Caution]:
    """Cautions by balls of parts apart, those at which limbs meet, and the ways drawn."""
    centers, radii, *_ = goals.ways.balls
    numbers: dict[str, float | str] = {"count": len(apart)}
    found = [Caution("ends-apart", numbers, as_place(centers[one])) for one in apart[:1]]
    if len(met):
        place = as_place(centers[met[0, 0]])
        found.append(Caution("limbs-meet", {"count": len(met)}, place))
    for one in touching_vessels(goals.ways, tree):
        found.append(Caution("vessels-touch", {"opening_mm": one.diameter}, as_place(one.place)))
    widest = int(np.where(goals.ways.is_reached, radii, 0.0).argmax())
    if radii[widest] > ANEURYSM * goals.inlet_radius:
        # An end as short as it is wide, with a round rim, looks like an aneurysm.
        numbers = {"diameter_mm": 2 * float(radii[widest]), "inlet_mm": 2 * goals.inlet_radius}
        found.append(Caution("inlet-narrow", numbers, as_place(centers[widest])))
    return found


class _Goals(NamedTuple):
    """Ways through a lumen from its inlet, and the balls at its other ends."""

    ways: WidestWays
    ends: list[int]
    inlet_radius: float
    """Radius of the inlet, mm; infinite where a place names it."""


class _FoundEnds(NamedTuple):
    """Ends of a lumen that are neither open nor flat, the widest first."""

    balls: InnerBalls
    """The balls, behind them one at every blunt end."""
    ends: Indices
    radii: Floats


def _found_ends(
    closed: Surface, balls: InnerBalls, begin: int | None, known: Indices, wide: Sequence[float]
) -> _FoundEnds:
    """Round and blunt ends of a closed surface, besides the balls at those that are known, which
    are so wide.

    Blunt ends first: their places are in the middle of the vessel, a round end's may be in the rim.
    """
    blunt: list[BluntEnd] = []
    centers, widths = balls.centers[known], balls.radii[known]
    for end in blunt_ends(closed, balls.at_wall):
        if (norm(centers - end.place) > widths + end.radius).all():
            blunt.append(end)
            centers, widths = np.vstack([centers, end.place]), np.append(widths, end.radius)
    ends = len(balls.radii) + np.arange(len(blunt))
    if blunt:
        balls = with_places(balls, np.array([end.place for end in blunt]))
        begin = int(ends[0]) if begin is None else begin
    tips = round_ends(balls, begin, np.r_[known, ends], closed)
    # What lies within an end is a pocket in its rim.
    widths = np.r_[wide, [end.radius for end in blunt]]
    is_apart = [(norm(centers - balls.centers[tip]) > widths).all() for tip in tips.tolist()]
    tips = tips[np.array(is_apart, dtype=bool)]
    radii = np.r_[balls.radii[tips], [end.radius for end in blunt]]
    order = np.argsort(-radii, kind="stable")
    return _FoundEnds(balls, np.r_[tips, ends][order], radii[order])


def _goals(seeds: KnownEnds, are_named: bool, show: Callable[[float], None]) -> _Goals:
    """The ends of a surface, and round and blunt ones besides if they are not named."""
    given = [*([] if seeds.inlet is None else [seeds.inlet]), *seeds.outlets]
    # What is open and no end is a hole in the wall.
    closed = seeds.surface.closed
    balls = inner_balls(closed)
    show(BALLS)
    known = len(balls.radii) + np.arange(len(given))
    if given:
        balls = with_places(balls, seeds.surface.points[given])
    goals, radius = known, seeds.inlet_radius
    likely = WidestWays(balls, int(known[0])) if given else None
    if not are_named:
        # The ways, unless more is found than is known; looking for that takes longer.
        settle = ahead(lambda: likely and likely.meetings)
        begin = None if seeds.inlet is None else int(known[0])
        found = _found_ends(closed, balls, begin, known, seeds.radii)
        settle()
        balls = found.balls
        # A spot of two triangles that lie in one plane may pass for a flat end.
        is_wider = found.radii.max(initial=0.0) > ALIKE * radius
        radius = float(found.radii[0]) if is_wider else radius
        goals = np.r_[found.ends, known] if is_wider else np.r_[known, found.ends]
    if len(goals) < 2:
        raise InputError(
            "surface: expected two ends or more, open, flat, or round and longer than wide, found "
            f"{len(goals)}; cut the ends flat, or name the inlet and every outlet."
        )
    inlet, *ends = goals.tolist()
    ways = WidestWays(balls, inlet)
    if likely is not None and likely.balls is balls and likely.inlet == inlet:
        ways = likely
    return _Goals(ways, ends, radius or np.inf)


class _Drawing:
    """Stations along the ways of a tree: those of one way after those of another."""

    def __init__(self, tree: list[Indices], centers: Points, radii: Floats) -> None:
        self._station_of: dict[int, int] = {}
        self._ranges: list[tuple[int, int]] = []
        """First station of every way, and the one behind its last."""
        self._begins: list[int] = []
        """The station of another way at which each begins, -1 at the inlet."""
        points: list[Points] = []
        widths: list[Floats] = []
        for way in tree:
            start = sum(map(len, points))
            begin = self._station_of.get(int(way[0]), -1)
            own = way[_free_of_ends(centers[way], radii[way], begin < 0)]
            place, width, at = _evenly(centers[own], radii[own])
            stations = start + np.arange(len(place)) - (begin >= 0)
            if begin >= 0:
                place, width, stations[0] = place[1:], width[1:], begin
            points.append(place)
            widths.append(width)
            self._begins.append(begin)
            self._ranges.append((start, start + len(place)))
            for ball, number in zip(own.tolist(), at.tolist(), strict=True):
                self._station_of.setdefault(ball, int(stations[number]))
            # Those left out at the ends; another way leaves this one before its end.
            inner = own[int(begin < 0) : -1] if len(own) > 2 else own
            for ball in way.tolist():
                if ball not in self._station_of:
                    beside = inner[norm(centers[inner] - centers[ball]).argmin()]
                    self._station_of[ball] = self._station_of[int(beside)]
        self.points, self.radii = np.vstack(points), np.concatenate(widths)
        self._smooth(SMOOTHED)

    def line_to(self, ball: int) -> Indices:
        """The stations of the line to a ball, from the inlet on."""
        found: list[Indices] = []
        station = self._station_of[ball]
        # Ends: each way begins at one before it, the first at the inlet.
        while station >= 0:
            number = next(n for n, (_, stop) in enumerate(self._ranges) if station < stop)
            start = self._ranges[number][0]
            found.append(np.arange(start, station + 1))
            station = self._begins[number]
        return np.concatenate(found[::-1])

    def onto_spheres(self, points: Points, triangles: Indices) -> None:
        """Move the stations to the centers of the largest spheres in their planes."""
        is_end = self._at_ends()
        # Where a way is still in the lumen of the one that it has left, spheres are that lumen's.
        asked = np.flatnonzero(is_end | ~self._within_junctions())
        is_end, stations, radii = is_end[asked], self.points[asked], self.radii[asked]
        found = inscribed_spheres(points, triangles, stations, self._directions()[asked])
        is_own = (norm(found.centers - stations) < ASIDE * found.radii) & ~is_end
        is_own &= found.radii < 2 * radii
        self.points[asked[is_own]] = found.centers[is_own]
        known = is_own | (is_end & np.isfinite(found.radii))
        self.radii[asked[known]] = found.radii[known]
        self._smooth(AGAIN)

    def _smooth(self, times: int) -> None:
        for begin, (start, stop) in zip(self._begins, self._ranges, strict=True):
            line = self._line(begin, start, stop)
            for _ in range(times):
                line[1:-1] += (line[:-2] - 2 * line[1:-1] + line[2:]) / 4
            self.points[start:stop] = line[start - stop :]

    def _directions(self) -> Points:
        found = np.empty_like(self.points)
        for begin, (start, stop) in zip(self._begins, self._ranges, strict=True):
            found[start:stop] = Line(self._line(begin, start, stop)).directions[start - stop :]
        return found

    def _line(self, begin: int, start: int, stop: int) -> Points:
        """Places of a way, behind its departure from another one."""
        stations = np.arange(start, stop)
        return self.points[np.append(begin, stations) if begin >= 0 else stations]

    def _within_junctions(self) -> Flags:
        """Stations within the lumen of the way that theirs has left."""
        found = np.zeros(len(self.points), dtype=bool)
        for begin, (start, stop) in zip(self._begins, self._ranges, strict=True):
            if begin >= 0:
                away = norm(self.points[start:stop] - self.points[begin])
                is_beyond = away > self.radii[begin]
                count = int(is_beyond.argmax()) if is_beyond.any() else len(away)
                found[start : start + count] = True
        return found

    def _at_ends(self) -> Flags:
        found = np.zeros(len(self.points), dtype=bool)
        for begin, (start, stop) in zip(self._begins, self._ranges, strict=True):
            found[stop - 1] = True
            found[start] |= begin < 0
        return found


def _free_of_ends(centers: Points, radii: Floats, has_inlet: bool) -> Indices:
    """Balls of a way except those that touch the closing of its ends; these stay themselves."""
    touches = norm(centers - centers[-1]) < 1.05 * radii
    if has_inlet:
        touches |= norm(centers - centers[0]) < 1.05 * radii
    touches[[0, -1]] = False
    return np.flatnonzero(~touches)


def _evenly(centers: Points, radii: Floats) -> tuple[Points, Floats, Indices]:
    """Places `STEP` radii apart along a way, the radii there, and the place next to every ball."""
    pieces = norm(np.diff(centers, axis=0))
    along = np.concatenate([[0.0], np.cumsum(pieces * (1 / radii[:-1] + 1 / radii[1:]) / 2)])
    count = max(3, int(np.ceil(along[-1] / STEP)))
    at = np.linspace(0.0, along[-1], count + 1)
    places = np.column_stack([np.interp(at, along, one) for one in centers.T])
    nearest = np.rint(along / max(at[1], np.finfo(float).tiny)).astype(np.int64)
    return places, np.interp(at, along, radii), nearest
