"""The connection of both caval veins with both pulmonary arteries: two inlets, two outlets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from SDFStentLib.validation import Floats, as_number, read_only

from .axis import narrowing, planar_axis
from .field import TubeField, TubeUnion
from .junction import branching_tube
from .value import Phantom, TrueOpening, TrueVessel, assembled

THROAT = 26.0
"""Distance of the conduit's throat from its lower end, mm."""

HALF_LENGTH = 16.0
"""Half the length of the conduit's narrowing, mm."""


def cavopulmonary_connection(
    edge_length: float = 1.0, *, conduit_radius: float = 9.0, throat_radius: float = 5.25
) -> Phantom:
    """A Fontan circulation: an extracardiac conduit and the superior caval vein into the arteries.

    The conduit, from the inferior caval vein, is narrowed by a raised cosine 32 mm long; diameters
    of 18 and 10.5 mm are the medians after and before stents in Hagler et al., Congenit Heart Dis
    2019;14:571. It turns into the right pulmonary artery; the left one, and the superior caval vein
    8 mm farther on, come to it. These three are 12 mm wide.

    Raises
    ------
    InputError
        Sizes out of their range: a throat wider than the conduit, or that wider than 20 mm.
    """
    as_number(edge_length, "edge_length", unit="mm", above=0, maximum=1.5)
    as_number(conduit_radius, "conduit_radius", unit="mm", minimum=6, maximum=10)
    as_number(throat_radius, "throat_radius", unit="mm", minimum=3, maximum=conduit_radius)
    bend = 20.0
    conduit = planar_axis(
        [(48.0, 0.0), (bend * np.pi / 2, 1 / bend), (30.0, 0.0)], toward=(1.0, 0.0, 0.0)
    )
    left = planar_axis(
        [(42.0, 0.0)], start=conduit.point(58.0)[0], heading=(-1.0, 0.0, 0.35), toward=(0, 0, 1)
    )
    vein = planar_axis(
        [(45.0, 0.0)], start=conduit.point(70.0)[0], heading=(0.1, 0.0, 1.0), toward=(1, 0, 0)
    )

    def conduit_and_right(arc_length: Floats) -> Floats:
        share = np.clip((arc_length - 50.0) / 30.0, 0.0, 1.0)
        taper = conduit_radius + (6.0 - conduit_radius) * (1 - np.cos(np.pi * share)) / 2
        depth = 1 - throat_radius / conduit_radius
        return np.asarray(taper * narrowing(arc_length, THROAT, HALF_LENGTH, depth))

    def even(arc_length: Floats) -> Floats:
        return np.full(np.shape(arc_length), 6.0)

    vessels = (
        TrueVessel("conduit and right pulmonary artery", conduit, conduit_and_right),
        TrueVessel("left pulmonary artery", left, even, joint=58.0),
        TrueVessel("superior caval vein", vein, even, joint=70.0),
    )
    tubes = [TubeField(vessel.axis, vessel.radius) for vessel in vessels]
    union = TubeUnion(tubes, blend_width=2.0, beyond=4 * edge_length)
    patch = branching_tube(union, edge_length)
    names = (
        "inferior caval vein inlet",
        "right pulmonary artery outlet",
        "left pulmonary artery outlet",
        "superior caval vein inlet",
    )
    openings = [
        TrueOpening(name, number + 2, read_only(rim.center), read_only(rim.outward), rim.radius)
        for number, (name, rim) in enumerate(zip(names, union.rims(), strict=True))
    ]
    made = assembled("cavopulmonary connection", patch, vessels, openings, THROAT)
    wall = patch.points[np.unique(patch.triangles[patch.face_ids == 1])]
    radii = union.inscribed_radii(made.centerline.points, wall)
    return replace(made, centerline=replace(made.centerline, inscribed_radius=radii))
