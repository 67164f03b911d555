"""A synthetic vessel as a value: its surface, exact axes, radii, openings and centerline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import NamedFaces, Surface
from SDFStentLib.validation import Floats, Points, Triangles, read_only

from .axis import TrueAxis, inscribed_radii
from .mesh import FacedMesh

CENTERLINE_SPACING = 0.5
"""Spacing of the centerline points, mm."""


@dataclass(frozen=True, eq=False)
class TrueVessel:
    """One tube of a phantom: its axis and the radius of its cross section by arc length.

    `joint` is the arc length of the first vessel, mm, at which it leaves that, or None.
    """

    name: str
    axis: TrueAxis
    radius: Callable[[Floats], Floats]
    joint: float | None = None


@dataclass(frozen=True, eq=False)
class TrueOpening:
    """A flat cap: name, face id, center (3,) mm, unit normal (3,) out of the lumen, radius mm."""

    name: str
    face_id: int
    center: Floats
    outward: Floats
    radius: float


@dataclass(frozen=True, eq=False)
class TrueThroat:
    """The narrowest place: vessel number, arc length mm, point (3,) mm, diameters mm."""

    vessel: int
    arc_length: float
    point: Floats
    diameter: float
    reference_diameter: float


@dataclass(frozen=True, eq=False)
class Phantom:
    """A synthetic patient.

    Attributes
    ----------
    name : str
    surface : Surface
    face_ids : (m,) array
        The id of every triangle's face.
    centerline : Centerline
        Points on the exact axes from inlet to outlets. Its inscribed radius is that of the
        largest sphere inside the exact wall; caps are not counted as wall.
    vessels : tuple of TrueVessel
        The exact axes and section radii.
    openings : tuple of TrueOpening
        The openings, in order of their face ids.
    throat : TrueThroat or None
        The place where a stent belongs.
    """

    name: str
    surface: Surface
    face_ids: NDArray[np.int64]
    centerline: Centerline
    vessels: tuple[TrueVessel, ...]
    openings: tuple[TrueOpening, ...]
    throat: TrueThroat | None = None

    @property
    def points(self) -> Points:
        """Points (n, 3) of the surface, mm."""
        return self.surface.points

    @property
    def triangles(self) -> Triangles:
        """Triangles (m, 3) of the surface."""
        return self.surface.triangles

    @property
    def faces(self) -> NamedFaces:
        """The face ids with names: a cap has the name of the vessel that it closes."""
        names = {
            opening.face_id: opening.name.removesuffix(" inlet").removesuffix(" outlet")
            for opening in self.openings
        }
        return NamedFaces(self.face_ids, names)

    def axis_at(self, arc_length: ArrayLike) -> Points:
        """Exact axis points (n, 3), mm, at arc lengths (n,) from the start of the first vessel."""
        return self.vessels[0].axis.point(arc_length)


def assembled(
    name: str,
    patch: FacedMesh,
    vessels: tuple[TrueVessel, ...],
    openings: Sequence[TrueOpening],
    throat: float | None = None,
) -> Phantom:
    """A phantom with its throat and with its centerline, whose radii are those of swept tubes.

    Parameters
    ----------
    patch : FacedMesh
        The closed surface.
    throat : float, optional
        Arc length at which the first vessel is narrowest, mm.
    """
    return Phantom(
        name=name,
        surface=Surface(patch.points, patch.triangles),
        face_ids=read_only(patch.face_ids),
        centerline=_centerline(vessels),
        vessels=vessels,
        openings=tuple(openings),
        throat=None if throat is None else _throat(vessels[0], throat),
    )


def ends_of(vessel: TrueVessel, first_face_id: int, prefix: str = "") -> list[TrueOpening]:
    """The two openings of a tube; the face ids begin with the given one."""
    stations = np.array([0.0, vessel.axis.length])
    centers, tangents = vessel.axis.point(stations), vessel.axis.tangent(stations)
    radii = vessel.radius(stations)
    return [
        TrueOpening(
            prefix + ("inlet", "outlet")[end],
            first_face_id + end,
            read_only(centers[end]),
            read_only((-1, 1)[end] * tangents[end]),
            float(radii[end]),
        )
        for end in (0, 1)
    ]


def _throat(vessel: TrueVessel, arc_length: float) -> TrueThroat:
    ends = vessel.radius(np.array([0.0, vessel.axis.length]))
    return TrueThroat(
        vessel=0,
        arc_length=arc_length,
        point=read_only(vessel.axis.point(arc_length)[0]),
        diameter=2 * float(vessel.radius(np.array([arc_length]))[0]),
        reference_diameter=2 * float(ends[1]),
    )


def _centerline(vessels: Sequence[TrueVessel]) -> Centerline:
    """The centerline along the exact axes; a side vessel begins at the point where it leaves."""
    joints = {vessel.joint for vessel in vessels if vessel.joint is not None}
    stops = sorted({0.0, vessels[0].axis.length, *joints})
    stations = [_stations(stops)]
    parents = [np.arange(len(stations[0])) - 1]
    count = len(stations[0])
    for vessel in vessels[1:]:
        at = _stations([0.0, vessel.axis.length])
        root = -1
        if vessel.joint is not None:
            at, root = at[1:], int(np.argmin(np.abs(stations[0] - vessel.joint)))
        parents.append(np.r_[root, count + np.arange(len(at) - 1)])
        stations.append(at)
        count += len(at)
    pairs = list(zip(vessels, stations, strict=True))
    return Centerline(
        points=np.vstack([vessel.axis.point(at) for vessel, at in pairs]),
        inscribed_radius=np.concatenate(
            [inscribed_radii(vessel.axis, vessel.radius, at) for vessel, at in pairs]
        ),
        parent=np.concatenate(parents),
    )


def _stations(stops: Sequence[float]) -> Floats:
    """Arc lengths from stop to stop, `CENTERLINE_SPACING` or a little less apart."""
    parts = [np.array([stops[0]])]
    for start, end in pairwise(stops):
        count = int(np.ceil((end - start) / CENTERLINE_SPACING - 1e-9))
        parts.append(np.linspace(start, end, count + 1)[1:])
    return np.concatenate(parts)
