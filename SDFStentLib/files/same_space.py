"""Do a surface and a centerline belong together: unit, frame, and size."""

from __future__ import annotations

from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from ..cautions import Caution
from ..geometry import Surface, as_surface, signed_volume
from ..units import flipped
from ..validation import InputError, Points, as_points
from .polydata import polydata_from_polygons

UNIT_FACTORS = (10.0, 0.1, 1000.0, 0.001)
"""What separates millimetres from centimetres and metres, both ways."""

_SAMPLES = 150  # centerline points that are tested
_RAYS = 9  # odd, so that there is a majority
_ENOUGH_INSIDE = 0.5
# Part of the surface's extent that a line in a larger unit has at least once it is shrunk. A line
# shrunk to a spot fits into every vessel that passes near the origin, and says nothing.
_SMALLEST_PART = 0.2
_SMALLEST_EXTENT, _LARGEST_EXTENT = 20.0, 2000.0  # mm, of a vessel model
_SMALLEST_LUMEN, _LARGEST_LUMEN = 2.0, 100.0  # mm, diameter; an aorta in cm has 1.7


class _Fit(NamedTuple):
    factor: float
    is_flipped: bool
    inside_fraction: float


def check_same_space(
    surface: Surface,
    centerline_points: ArrayLike,
    *,
    surface_name: str = "surface",
    centerline_name: str = "centerline",
) -> tuple[Caution, ...]:
    """Check that a centerline or an axis lies inside a surface, open or closed.

    A point is inside when most of nine rays from it cross the surface an odd number of times,
    which needs neither a closed nor an oriented surface; of one that is known to be closed one ray
    is enough to tell that it is inside. Ends that stick out of a cut-open
    inlet are tolerated: half of the points must be inside. When fewer are, other units and the
    other patient frame (x and y negated) are tried, to say what is wrong.

    Parameters
    ----------
    surface : Surface
    centerline_points : array_like, shape (k, 3)
        Points of the centerline in any order, mm; about 150 of them are tested.
    surface_name, centerline_name : str
        What to call them in messages: files or nodes.

    Returns
    -------
    tuple of Caution
        One when a part of the centerline is outside, otherwise empty.

    Raises
    ------
    InputError
        Less than half of the centerline is inside; says whether units or frame explain it.
    """
    centers = as_points(centerline_points, centerline_name, minimum=1)
    count = min(len(centers), _SAMPLES)
    centers = centers[np.linspace(0, len(centers) - 1, count).round().astype(int)]
    test = InsideTest(as_surface(surface))

    inside = float(test.is_inside(centers).mean())
    if inside >= _ENOUGH_INSIDE:
        # Ends on a cap or a rim fall on either side; they are not worth a sentence.
        if inside >= 0.95:
            return ()
        numbers: dict[str, float | str] = {"outside_percent": 100 * (1 - inside)}
        numbers["surface"] = surface_name
        return (Caution("partly-outside", numbers, label=f"{centerline_name}: "),)
    found = f"{centerline_name}: expected it inside {surface_name}, got {100 * inside:.0f} % inside"
    raise _explained(_best_fit(test, centers)).labeled(f"{found}; ")


def check_joined(surface: Surface, name: str) -> None:
    """`InputError` for triangles of which no two share a point: they bound no vessel."""
    parts, triangles = surface.topology.component_count, len(surface.triangles)
    if 1 < triangles == parts:
        raise InputError(
            f"{name}: expected triangles that share their points, got {triangles} that share none, "
            "so they bound no vessel; merge equal points first (in Slicer: Surface Toolbox, Clean)."
        )


def size_warnings(surface: Surface, name: str, units: str = "mm") -> tuple[Caution, ...]:
    """Whether a surface has not the size of a vessel in millimetres.

    The extent is the longest side of its box; the lumen of a closed surface is measured by
    four times volume over area, the diameter of a long tube.
    """
    points, triangles = surface.points, surface.triangles
    is_used = np.zeros(len(points), dtype=bool)
    is_used[triangles] = True
    extent = float(np.ptp(points.compress(is_used, axis=0), axis=0).max())
    lumen = None
    if surface.topology.is_closed:
        area = float(surface.face_areas.sum())
        lumen = 4 * abs(signed_volume(points, triangles)) / area if area > 0 else 0.0
    is_odd = not _SMALLEST_EXTENT <= extent <= _LARGEST_EXTENT
    if lumen is not None:
        is_odd = is_odd or not _SMALLEST_LUMEN <= lumen <= _LARGEST_LUMEN
    if not is_odd:
        return ()
    numbers: dict[str, float | str] = {"unit": units, "extent_mm": extent}
    if lumen is None:
        return (Caution("unusual-extent", numbers, label=f"{name}: "),)
    return (Caution("unusual-size", {**numbers, "lumen_mm": lumen}, label=f"{name}: "),)


class InsideTest:
    """Counts crossings of rays; the same rays for every query, so that results repeat."""

    def __init__(self, surface: Surface) -> None:
        self._surface, points = surface, surface.points
        self._low, self._high = points.min(axis=0), points.max(axis=0)
        directions = np.random.default_rng(1).normal(size=(_RAYS, 3))
        reach = 1.01 * float(np.linalg.norm(self._high - self._low)) + 1e-9
        self._rays = reach * directions / np.linalg.norm(directions, axis=1, keepdims=True)

    @property
    def extent(self) -> float:
        """The longest side of the surface's box, mm."""
        return float((self._high - self._low).max())

    @cached_property
    def _locator(self) -> vtkStaticCellLocator:
        surface = self._surface
        offsets = 3 * np.arange(len(surface.triangles) + 1)
        locator = vtkStaticCellLocator()
        locator.SetDataSet(
            polydata_from_polygons(surface.points, offsets, surface.triangles.ravel())
        )
        locator.BuildLocator()
        return locator

    def is_inside(self, queries: Points) -> NDArray[np.bool_]:
        """Which points (n, 3) are inside of the surface."""
        inside = ((queries >= self._low) & (queries <= self._high)).all(axis=1)
        doubtful, known = np.flatnonzero(inside), self._surface.known_topology
        if known is not None and known.is_closed:
            # Quickly told. A point on the surface may come out either way: the rays decide.
            doubtful = doubtful[~self._surface.contains(queries[doubtful])]
        for index in doubtful:
            inside[index] = self._is_inside(queries[index])
        return inside

    def _is_inside(self, query: Points) -> bool:
        """What most rays say; no further ones are sent when these are known."""
        said = {True: 0, False: 0}
        for ray in self._rays:
            is_odd = self._crossings(query, ray) % 2 == 1
            said[is_odd] += 1
            if said[is_odd] > _RAYS // 2:
                break
        return said[True] > said[False]

    def _crossings(self, start: Points, ray: Points) -> int:
        crossed = vtkIdList()
        self._locator.IntersectWithLine(start.tolist(), (start + ray).tolist(), 0.0, None, crossed)
        return int(crossed.GetNumberOfIds())


def _best_fit(test: InsideTest, centers: Points) -> _Fit | None:
    fits = []
    for factor, is_flipped in product((1.0, *UNIT_FACTORS), (False, True)):
        if factor == 1.0 and not is_flipped:
            continue
        if factor < 1.0 and factor * np.ptp(centers, axis=0).max() < _SMALLEST_PART * test.extent:
            continue
        moved = flipped(factor * centers) if is_flipped else factor * centers
        fits.append(_Fit(factor, is_flipped, float(test.is_inside(moved).mean())))
    # The first of equals: one change rather than two.
    best = max(fits, key=lambda fit: (fit.inside_fraction, fit.factor == 1.0, not fit.is_flipped))
    return best if best.inside_fraction >= _ENOUGH_INSIDE else None


def _explained(best: _Fit | None) -> InputError:
    if best is None:
        return InputError(
            "it lies elsewhere, and neither other units nor the other frame (RAS, LPS) explain "
            "that; check that the two belong together."
        )
    units = (
        f"the two are in different units (it would fit {best.factor:g} times as large): save "
        "both in one unit and name that"
    )
    frame = (
        "one is in RAS and the other in LPS (it would fit with x and y negated): save both in "
        "one frame, or with the SPACE tag that Slicer writes"
    )
    if best.factor == 1.0:
        return InputError(f"{frame}.")
    return InputError(units, "one_unit", end=f"; also, {frame}." if best.is_flipped else ".")
