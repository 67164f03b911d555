"""Measuring in the plain way, station by station, as a reference for the fast way."""

import numpy as np
from scipy.ndimage import label
from scipy.optimize import linprog

from SDFStentLib.geometry import across
from SDFStentLib.lumen import in_caps, measured_at, profile_around
from SDFStentLib.lumen.spheres import own, passing

THINNED_ABOVE, THINNING = 8000, 8


def measured_around(surface, stations):
    """The profile of stations, measured without any known result."""
    caps = in_caps(surface)
    measured = measured_at(surface, stations.points, stations.directions, caps)
    return profile_around(surface, stations, measured, caps)


def nearest_points(query, corners):
    """The point of every triangle (m, 3, 3) that is nearest to the query."""
    a, b, c = np.moveaxis(corners, 1, 0)
    u, v = b - a, c - a
    normal = np.cross(u, v)
    area = np.maximum((normal**2).sum(axis=1), 1e-300)
    offset = query - a
    t = (np.cross(u, offset) * normal).sum(axis=1) / area
    s = (np.cross(offset, v) * normal).sum(axis=1) / area
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    found = [np.where(inside[:, None], a + s[:, None] * u + t[:, None] * v, np.inf)]
    for first, side in ((a, u), (b, c - b), (a, v)):
        length = np.maximum((side**2).sum(axis=1), 1e-300)
        share = np.clip(((query - first) * side).sum(axis=1) / length, 0, 1)
        found.append(first + share[:, None] * side)
    distances = [np.linalg.norm(point - query, axis=1) for point in found]
    return np.choose(np.argmin(distances, axis=0)[:, None], found)


def winding_numbers(queries, points, triangles):
    """How often a surface winds round each query point, a half for a point on it: the solid angle
    over 4 pi.

    Van Oosterom and Strackee 1983, doi 10.1109/TBME.1983.325207.
    """
    total = np.zeros(len(queries))
    for number, query in enumerate(queries):
        a, b, c = np.moveaxis(points[triangles] - query, 1, 0)
        la, lb, lc = (np.linalg.norm(arm, axis=1) for arm in (a, b, c))
        volume = (np.cross(a, b) * c).sum(axis=1)
        rest = (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
        angle = 2 * np.arctan2(volume, la * lb * lc + rest)
        # For a triangle whose plane contains the query, rounding would decide the side.
        angle[np.abs(volume) <= 1e-9 * (la * lb + lb * lc + lc * la)] = 0.0
        total[number] = angle.sum()
    return np.abs(total) / (4 * np.pi)


def climbed(corners, center, axes, box, tolerance):
    """Center and radius of the largest sphere that a climb in steps of linear models reaches."""
    half = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max()
    for _ in range(200):
        apart = np.linalg.norm(corners.mean(axis=1) - center, axis=1)
        near = corners[apart <= apart.min() * (1 + 3 * box) + 2 * half]
        offset = center - nearest_points(center, near)
        distance = np.linalg.norm(offset, axis=1)
        radius = distance.min()
        slope = offset @ axes.T / distance[:, None]
        rows = np.column_stack([-slope, np.ones(len(slope))])
        sides = [(-box * radius, box * radius)] * 2
        *step, height = linprog([0, 0, -1], rows, distance, bounds=[*sides, (None, None)]).x
        if height - radius <= tolerance:
            return center, radius
        center = center + np.array(step) @ axes
        is_held = np.abs(step).max() > 0.99 * box * radius
        box = 3 * box if is_held else 2 * np.linalg.norm(step) / radius
        box = np.clip(box, 0.005, 0.5)
    raise AssertionError("the climb has no end")


def plain_sphere(points, triangles, start, direction):
    """Center and radius of the largest sphere across the axis that a climb from `start` reaches."""
    levels = [triangles]
    while len(levels[-1]) >= THINNED_ABOVE:
        count = len(levels[-1])
        chosen = np.random.default_rng(0).integers(0, count, count // THINNING)
        levels.append(levels[-1][chosen])
    axes = across(direction[None])[0]
    center, box = start, 0.05
    for level in levels[::-1]:
        tolerance = 1e-6 if level is triangles else 1e-3
        center, radius = climbed(points[level], center, axes, box, tolerance)
        box = 0.005
    return center, radius


def widest_passing(wall, throat, radius, ends):
    """The widest sphere that passes, by the distances of all cells of the grid from the wall."""
    corners = np.vstack([throat, ends])
    low, high = corners.min(axis=0) - radius, corners.max(axis=0) + radius
    step = max(radius / passing._CELLS, float((high - low).max()) / passing._MOST)
    counts = np.maximum(np.ceil((high - low) / step).astype(int), 1) + 1
    grid = low + step * np.moveaxis(np.indices(counts), 0, -1)
    room = wall.distances(grid.reshape(-1, 3)).reshape(counts)
    begin, end = (passing._widest(room, np.linalg.norm(grid - one, axis=-1)) for one in ends)
    narrower = min(begin, end, key=room.__getitem__)
    levels = np.unique(room[room <= room[narrower]])
    passes = [level for level in levels if is_one(parts_of(room >= level), begin, end)][-1]
    if passes == room[narrower] > levels[0]:
        return np.r_[grid[narrower], passes]
    narrowest, parts = grid[room == passes][0], parts_of(room > passes)
    is_near = np.linalg.norm(grid - narrowest, axis=-1) < passing._NEAR * step
    sides = [grid[is_near & (parts == parts[one]) & (parts > 0)] for one in (begin, end)]
    if passes < step or is_one(parts, begin, end) or not all(map(len, sides)):
        return np.full(4, np.nan)
    way = sides[1].mean(axis=0) - sides[0].mean(axis=0)
    way /= np.linalg.norm(way)
    steps = passing._NEAR * step * np.linspace(-1.0, 1.0, passing._PLANES)
    axes = across(np.tile(way, (passing._PLANES, 1)))
    disks = np.full(passing._PLANES, passing._NEAR * step)
    centers, radii = largest_in_disks(wall, narrowest + steps[:, None] * way, axes, disks)
    return np.r_[centers[radii.argmin()], radii.min()]


def parts_of(inside):
    """Numbers of the connected parts of a grid's cells, 0 outside of them."""
    return label(inside, np.ones((3, 3, 3)))[0]


def is_one(parts, begin, end):
    """Whether two cells are in one part."""
    return parts[begin] == parts[end]


def largest_in_disks(wall, middles, axes, disks):
    """Centers and radii of the largest spheres in disks, by all of the places that are tried."""
    steps = np.linspace(-1.0, 1.0, own._TRIED)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    grid = grid[np.linalg.norm(grid, axis=1) <= 1.0]
    radii, best, size = wall.distances(middles), np.zeros((len(middles), 2)), disks
    while (size > own._FINEST).any():
        tried = best[:, None] + size[:, None, None] * grid
        tried /= np.maximum(np.linalg.norm(tried, axis=2) / disks[:, None], 1.0)[..., None]
        places = middles[:, None] + np.einsum("nki,nij->nkj", tried, axes)
        room = wall.distances(places.reshape(-1, 3)).reshape(len(middles), -1)
        for number, at in enumerate(room.argmax(axis=1)):
            if room[number, at] > radii[number]:
                best[number], radii[number] = tried[number, at], room[number, at]
        size = size / 2
    return middles + np.einsum("ni,nij->nj", best, axes), radii
