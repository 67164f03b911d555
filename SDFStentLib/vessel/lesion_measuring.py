"""Lesions on a surface: their narrowest places against references that are known already.

Sections are cut when somebody asks for areas (`lesion_sections`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..geometry import Surface, norm
from ..lumen import (
    ALIKE,
    FARTHEST,
    NEARLY,
    InscribedSpheres,
    LocalSurface,
    MovedWall,
    StationSearch,
    Until,
    with_own_spheres,
    with_passing,
)
from ..validation import Flags, Floats, Points, as_place
from .caliber import runs_of
from .lesion_sections import between_neighbors, cut_at, on_line, tightest
from .lesion_value import Lesion


def measured(lesions: Sequence[Lesion], surface: Surface, wall: LocalSurface) -> list[Lesion]:
    """The lesions with all that depends on the surface, against their references.

    Parameters
    ----------
    lesions : sequence of Lesion
        Their diameters are those on this surface.
    surface : Surface
    wall : LocalSurface
        Wall of the surface.
    """
    fine = [_round_narrowest(lesion) for lesion in lesions]
    spheres = _spheres(wall, [(places, ways) for _, places, ways in fine])
    return [
        _with_sphere(replace(one, surface=surface), along, with_passing(wall, places, found, along))
        for one, (along, places, _), found in zip(lesions, fine, spheres, strict=True)
    ]


def lesions_after(
    lesions: Sequence[Lesion], surface: Surface, moved: MovedWall | None = None
) -> list[Lesion]:
    """Lesions after treatment, at the same parts of the vessel against the same references.

    Parameters
    ----------
    lesions : sequence of Lesion
        Lesions as found before it.
    surface : Surface
        Surface after it.
    moved : MovedWall, optional
        Wall moved from then to now: what it comes nowhere near is not measured again, and a lesion
        that it does not touch at all stays what it is.

    Returns
    -------
    list of Lesion
        Minima and percentages are NaN where a wall was moved past a lesion's line.
    """
    limbs = [limb for one in lesions for limb in one.limbs]
    every = _after([*lesions, *limbs], surface, moved)
    return with_limbs(every, [len(one.limbs) for one in lesions])


def is_touched(lesion: Lesion, moved: MovedWall) -> bool:
    """Whether a moved wall may have changed anything of a lesion."""
    return _changed(lesion, moved) is not None


def with_limbs(every: Sequence[Lesion], counts: Sequence[int]) -> list[Lesion]:
    """Lesions with so many limbs each; these stand behind all of them, in order."""
    ends = np.cumsum([len(counts), *counts]).tolist()
    found = []
    for one, first, last in zip(every, ends, ends[1:], strict=False):
        limbs = tuple(every[first:last])
        found.append(one if one.limbs == limbs else replace(one, limbs=limbs))
    return found


def _after(lesions: Sequence[Lesion], surface: Surface, moved: MovedWall | None) -> list[Lesion]:
    """`lesions_after` without regard to limbs."""
    changed = {
        number: which
        for number, lesion in enumerate(lesions)
        if (which := _changed(lesion, moved)) is not None
    }
    if not changed:
        return list(lesions)
    lines = [(lesions[number].line, which) for number, which in changed.items()]
    places = np.concatenate([line.points for line, _ in lines])
    wall = LocalSurface(surface.points, surface.triangles, places)
    pieces = [(line.points[which], line.directions[which]) for line, which in lines]
    begun = []
    # A wall that was moved past a place leaves it in tissue, or in another vessel.
    spheres = _spheres(wall, pieces, surface)
    for (number, which), found in zip(changed.items(), spheres, strict=True):
        diameters = lesions[number].diameters.copy()
        diameters[which] = 2 * found.radii
        begun.append(replace(lesions[number], diameters=diameters))
    after = dict(zip(changed, measured(begun, surface, wall), strict=True))
    for number, lesion in after.items():
        if (np.isnan(lesion.diameters) & np.isfinite(lesions[number].diameters)).any():
            # Where nothing can be measured it may be narrower than elsewhere.
            after[number] = _with_no_sphere(lesion)
    return [after.get(number, lesion) for number, lesion in enumerate(lesions)]


def _changed(lesion: Lesion, moved: MovedWall | None) -> Flags | None:
    """Whether the sphere may have changed at points (k,) of a lesion's line.

    None where neither a sphere nor a section of the lesion can have changed.
    """
    if moved is None:
        return np.ones(len(lesion.line), dtype=bool)
    near = moved.within(lesion.line.points, FARTHEST / 2 * float(lesion.healthy.max()))
    # A sphere holds its place: no wall that it touches is farther from there than its diameter.
    unknown = np.isnan(lesion.diameters)
    reach = np.where(unknown, lesion.reference_diameter, lesion.diameters)
    changed = near.comes_near(lesion.line.points, ALIKE * reach)
    if not changed.any() and not near.crosses(*on_line(lesion.line, cut_at(lesion.line))).any():
        return None
    return np.asarray(changed | unknown)


def _spheres(
    wall: LocalSurface, lines: Sequence[tuple[Points, Points]], after: Surface | None = None
) -> list[InscribedSpheres]:
    """Spheres at the points of some lines with their directions, all searched together.

    NaN at points that are outside of the surface after a treatment, where that is given.
    """
    if not lines:
        return []
    places, ways = (np.concatenate(column) for column in zip(*lines, strict=True))
    ways /= norm(ways)[:, None]
    search = StationSearch(wall, places, ways, Until())
    ends = np.cumsum([len(line) for line, _ in lines])[:-1]
    parts = np.split(np.arange(len(places)), ends)
    found = with_own_spheres(wall, places, ways, search.exact(), parts)
    if after is not None:
        found.radii[~after.contains(places)] = np.nan
    return [found.at(part) for part in parts]


def _with_no_sphere(lesion: Lesion) -> Lesion:
    """The lesion with nothing known of its narrowest place, and so of its sections."""
    return replace(lesion, minimum_diameter=float("nan"), percent_diameter=float("nan"))


def _with_sphere(lesion: Lesion, along: Floats, spheres: InscribedSpheres) -> Lesion:
    """The lesion with the smallest of the spheres at some arc lengths from its start."""
    if not np.isfinite(spheres.radii).any():
        return _with_no_sphere(lesion)
    references = np.interp(along, lesion.line.arc_lengths, lesion.healthy)
    narrowest = tightest(spheres.radii, references)
    minimum, at = 2 * float(spheres.radii[narrowest]), float(along[narrowest])
    reference = float(references[narrowest])
    branch_start = lesion.arc_length - lesion.branch_arc_length
    return replace(
        lesion,
        arc_length=lesion.start + at,
        branch_arc_length=max(0.0, lesion.start + at - branch_start),
        point=as_place(spheres.centers[narrowest]),
        minimum_diameter=minimum,
        reference_diameter=reference,
        percent_diameter=100 * (1 - minimum / reference),
    )


def _round_narrowest(lesion: Lesion) -> tuple[Floats, Points, Points]:
    """Arc lengths, points and directions round the narrowest stations of a lesion's line."""
    middle = len(lesion.line) // 2
    runs = [(middle, middle)]
    if np.isfinite(lesion.diameters).any():
        narrow = lesion.diameters <= NEARLY * np.nanmin(lesion.diameters)
        runs = runs_of(narrow).tolist()
    along = lesion.line.arc_lengths
    fine = np.unique(np.concatenate([between_neighbors(along, *run) for run in runs]))
    return (fine, *on_line(lesion.line, fine))
