"""Synthetic vessels with exact centerlines and closed-form radii.

Every phantom is closed, two-manifold, oriented outward and free of self-intersections at any
edge length; face ids are those SimVascular would give: 1 wall, 2 inlet cap, then outlet caps.
Frame: RAS, so z points to the head and x to the patient's right. Nothing in here is random.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from SDFStentLib.validation import Floats, InputError, as_number, read_only

from .axis import TrueAxis, helical_axis, narrowing, planar_axis
from .field import TubeField, TubeUnion
from .junction import branching_tube
from .mesh import FacedMesh, swept_tube
from .value import Phantom, TrueOpening, TrueVessel, assembled, ends_of


def straight_tube(radius: float = 3.0, length: float = 40.0, edge_length: float = 0.8) -> Phantom:
    """A cylinder along z; here and in all phantoms `InputError` for sizes that make no tube."""
    axis = planar_axis([(_size(length, "length"), 0.0)])
    return _single("straight tube", axis, _constant(radius), edge_length)


def stenosed_tube(
    radius: float = 3.0,
    throat_radius: float = 1.8,
    length: float = 40.0,
    edge_length: float = 0.8,
    *,
    stenosis_length: float = 16.0,
) -> Phantom:
    """A cylinder along z, narrowed halfway: a raised cosine `stenosis_length` long (`narrowing`).

    Raises
    ------
    InputError
        Also when the throat is wider than the tube or the stenosis longer.
    """
    as_number(length, "length", unit="mm", minimum=_size(stenosis_length, "stenosis_length"))
    depth = 1 - as_number(throat_radius, "throat_radius", above=0, maximum=radius) / radius
    axis = planar_axis([(length, 0.0)])
    profile = _narrowed(radius, length / 2, stenosis_length / 2, depth)
    return _single("stenosed tube", axis, profile, edge_length, throat=length / 2)


def bent_tube(
    radius: float = 3.0,
    bend_radius: float = 15.0,
    angle_deg: float = 90.0,
    edge_length: float = 0.8,
    *,
    leg_length: float = 10.0,
) -> Phantom:
    """A circular bend between two straight legs; it bends toward x."""
    turn = np.radians(as_number(angle_deg, "angle_deg", above=0, maximum=180))
    as_number(bend_radius, "bend_radius", unit="mm", above=1.2 * _size(radius, "radius"))
    leg = (_size(leg_length, "leg_length"), 0.0)
    axis = planar_axis([leg, (bend_radius * turn, 1 / bend_radius), leg])
    return _single("bent tube", axis, _constant(radius), edge_length)


def helix_tube(
    radius: float = 2.5,
    coil_radius: float = 8.0,
    pitch: float = 14.0,
    turns: float = 1.5,
    edge_length: float = 0.8,
) -> Phantom:
    """A tube along a helix about the z axis.

    Raises
    ------
    InputError
        Also when neighboring turns would touch or the coil is too tight.
    """
    as_number(coil_radius, "coil_radius", unit="mm", above=1.2 * _size(radius, "radius"))
    as_number(turns, "turns", above=0)
    # Seen along the tube, neighboring turns are the pitch times the cosine of the slope apart.
    slope = np.arctan(_size(pitch, "pitch") / (2 * np.pi * coil_radius))
    if turns > 0.5 and pitch * np.cos(slope) <= 2.1 * radius:
        raise InputError(
            f"pitch: turns {pitch:g} mm apart touch in a tube of radius {radius:g} mm; "
            f"choose more than {2.1 * radius / np.cos(slope):.1f} mm."
        )
    axis = helical_axis(coil_radius, pitch, turns)
    return _single("helix tube", axis, _constant(radius), edge_length)


def hairpin_tube(
    radius: float = 3.0,
    gap: float = 2.0,
    leg_length: float = 25.0,
    edge_length: float = 0.8,
    *,
    bend_radius: float | None = None,
) -> Phantom:
    """A tube that turns back and runs beside itself, `gap` mm from wall to wall.

    The turn is a keyhole when the bend (twice the tube's radius by default) is wider than the
    legs are apart.
    """
    apart = 2 * _size(radius, "radius") + _size(gap, "gap")
    bend = max(2 * radius, apart / 2) if bend_radius is None else bend_radius
    as_number(bend, "bend_radius", unit="mm", minimum=max(apart / 2, 1.2 * radius))
    leg = (_size(leg_length, "leg_length"), 0.0)
    # First away from the other leg, so far that the wide arc comes back exactly to it.
    away = float(np.arccos(min((apart / 2 + bend) / (2 * bend), 1.0)))
    arcs = [(bend * away, -1 / bend), (bend * (np.pi + 2 * away), 1 / bend)]
    pieces = [leg, *arcs, arcs[0], leg] if away > 0 else [leg, arcs[1], leg]
    return _single("hairpin tube", planar_axis(pieces), _constant(radius), edge_length)


ASCENDING_LENGTH = 30.0
"""Length of the ascending part of the arch, mm."""


def arch_with_coarctation(
    radius: float = 7.0,
    throat_radius: float = 3.2,
    edge_length: float = 1.0,
    *,
    arch_radius: float = 18.0,
    descending_length: float = 70.0,
) -> Phantom:
    """The aorta of a child as a candy cane, with a coarctation just after the arch.

    The default diameters are 14 and 6.4 mm: the coarctation has 0.46 of the descending aorta's
    diameter, the mean of 105 patients in Ringel et al., Catheter Cardiovasc Interv 2013;82:503.
    The stenosis is a raised cosine 20 mm long whose throat is 14 mm below the arch.
    """
    depth = 1 - as_number(throat_radius, "throat_radius", above=0, maximum=radius) / radius
    as_number(arch_radius, "arch_radius", unit="mm", above=1.2 * _size(radius, "radius"))
    as_number(descending_length, "descending_length", unit="mm", minimum=24)
    arch = np.pi * arch_radius
    throat = ASCENDING_LENGTH + arch + 14
    axis = planar_axis(
        [(ASCENDING_LENGTH, 0.0), (arch, 1 / arch_radius), (descending_length, 0.0)],
        toward=(-0.5, -1.0, 0.0),
    )
    profile = _narrowed(radius, throat, 10.0, depth)
    return _single("arch with coarctation", axis, profile, edge_length, throat=throat)


def branching_pulmonary_artery(edge_length: float = 0.9) -> Phantom:
    """Main pulmonary artery of a child, left branch stenosed by 40 % at its origin, right branch.

    The left branch continues the main artery, as in the body; the right one leaves nearly at a
    right angle. Diameters: main 10 mm, branches 7 mm. The stenosis, a raised cosine 22 mm long
    with its throat 4 mm behind the junction, begins in the main artery and crosses the junction
    into the left branch. Stented pulmonary arteries of children had 6.9 (3.8 to 13.5) mm in Duke
    et al., Heart 2003;89:905.

    The wall is the smooth union of the two tubes (`TubeUnion`) with a blend of 2 mm. The caps lie
    in coordinate planes: some judges of self-intersection err in tilted planes.

    Raises
    ------
    InputError
        Edge length not above 0, or too long for the throat: more than 1.2 mm.
    """
    as_number(edge_length, "edge_length", unit="mm", above=0, maximum=1.2)
    junction = 24.0
    quarter = np.pi / 2
    main = planar_axis([(18.0, 0.0), (18.0 * quarter, 1 / 18.0), (10.0, 0.0)], toward=(-1, 0, 0))
    heading = np.array([1.0, -0.4, 0.5])
    turn = np.arccos(heading[0] / np.linalg.norm(heading))
    side = planar_axis(
        [(8.0, 0.0), (25.0 * turn, 1 / 25.0), (9.0, 0.0)],
        start=main.point(junction)[0],
        heading=heading,
        toward=(1, 0, 0),
    )

    def main_and_left(arc_length: Floats) -> Floats:
        return _between(5.0, 3.5, arc_length, 12.0, 27.0) * narrowing(
            arc_length, junction + 4.0, 11.0, 0.4
        )

    def right(arc_length: Floats) -> Floats:
        return _between(2.6, 3.5, arc_length, 0.0, 8.0)

    vessels = (
        TrueVessel("main and left pulmonary artery", main, main_and_left),
        TrueVessel("right pulmonary artery", side, right, joint=junction),
    )
    tubes = [TubeField(vessel.axis, vessel.radius) for vessel in vessels]
    union = TubeUnion(tubes, blend_width=2.0, beyond=4 * edge_length)
    patch = branching_tube(union, edge_length)
    names = (
        "main pulmonary artery inlet",
        "left pulmonary artery outlet",
        "right pulmonary artery outlet",
    )
    openings = [
        TrueOpening(name, number + 2, read_only(rim.center), read_only(rim.outward), rim.radius)
        for number, (name, rim) in enumerate(zip(names, union.rims(), strict=True))
    ]
    wall = patch.points[np.unique(patch.triangles[patch.face_ids == 1])]
    made = assembled("branching pulmonary artery", patch, vessels, openings, junction + 4.0)
    # The blend about the junction is wider than its tubes.
    radii = union.inscribed_radii(made.centerline.points, wall)
    return replace(made, centerline=replace(made.centerline, inscribed_radius=radii))


def tube_with_neighbor(
    radius: float = 3.0, length: float = 40.0, edge_length: float = 0.8, *, gap: float = 2.0
) -> Phantom:
    """A stenosed tube along z and a second vessel of its own beside it, one surface.

    The neighbor, of the same radius, stands `gap` mm from wall to wall in x. Its face ids go
    on: 4 wall, 5 and 6 caps. The stenosis, 40 % and 16 mm long, is halfway; the centerline has
    a root for each vessel.
    """
    apart = 2 * _size(radius, "radius") + _size(gap, "gap")
    as_number(length, "length", unit="mm", minimum=16)
    _check_edge_length(edge_length, 0.6 * radius)
    vessels = (
        TrueVessel(
            "treated", planar_axis([(length, 0.0)]), _narrowed(radius, length / 2, 8.0, 0.4)
        ),
        TrueVessel(
            "neighbor", planar_axis([(length, 0.0)], start=(apart, 0, 0)), _constant(radius)
        ),
    )
    first, second = (
        swept_tube(vessel.axis, vessel.radius, edge_length, 3 * number + 1)
        for number, vessel in enumerate(vessels)
    )
    patch = FacedMesh(
        np.vstack([first.points, second.points]),
        np.vstack([first.triangles, second.triangles + len(first.points)]),
        np.r_[first.face_ids, second.face_ids],
    )
    openings = [*ends_of(vessels[0], 2), *ends_of(vessels[1], 5, "neighbor ")]
    return assembled("tube with neighbor", patch, vessels, openings, length / 2)


def _single(
    name: str,
    axis: TrueAxis,
    radius: Callable[[Floats], Floats],
    edge_length: float,
    throat: float | None = None,
) -> Phantom:
    """A phantom made of one swept tube."""
    vessel = TrueVessel(name, axis, radius)
    _check_edge_length(edge_length, float(radius(axis.sampled(0.1)).min()))
    patch = swept_tube(axis, radius, edge_length)
    return assembled(name, patch, (vessel,), ends_of(vessel, 2), throat)


def _check_edge_length(edge_length: float, smallest_radius: float) -> None:
    as_number(edge_length, "edge_length", unit="mm", above=0, maximum=smallest_radius)


def _size(value: float, name: str) -> float:
    return as_number(value, name, unit="mm", above=0)


def _constant(radius: float) -> Callable[[Floats], Floats]:
    size = _size(radius, "radius")
    return lambda arc_length: np.full(np.shape(arc_length), size)


def _narrowed(
    radius: float, center: float, half_length: float, depth: float
) -> Callable[[Floats], Floats]:
    size = _size(radius, "radius")
    return lambda arc_length: size * narrowing(arc_length, center, half_length, depth)


def _between(first: float, last: float, arc_length: Floats, start: float, end: float) -> Floats:
    """A smooth step from one radius to another, `3 x^2 - 2 x^3`."""
    x = np.clip((np.asarray(arc_length) - start) / (end - start), 0, 1)
    return np.asarray(first + (last - first) * x * x * (3 - 2 * x))
