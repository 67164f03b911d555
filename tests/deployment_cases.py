"""Vessels and stents that the tests of the engine share."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from benchmarks import phantoms
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Line, Surface

ANATOMIES = {
    "aorta_iliac": ("aorta_iliac_surface_cm.vtp", "aorta_iliac_centerline_cm.vtp", "cm"),
    "pulmonary": ("pulmonary_surface_cm.vtp", "pulmonary_centerline_cm.vtp", "cm"),
    "vmtk_aorta": ("vmtk_aorta_surface_mm.vtp", "vmtk_aorta_centerline_mm.vtp", "mm"),
}


class Vessel(NamedTuple):
    surface: Surface
    centerline: Centerline

    @property
    def points(self):
        return self.surface.points

    @property
    def triangles(self):
        return self.surface.triangles


class Case(NamedTuple):
    """A stent in a vessel."""

    points: np.ndarray
    triangles: np.ndarray
    axis: np.ndarray
    radius: float

    @property
    def surface(self):
        return Surface(self.points, self.triangles)


@cache
def anatomy(folder: Path, name: str) -> Vessel:
    surface_name, centerline_name, units = ANATOMIES[name]
    surface = read_surface(folder / surface_name, units=units)
    return Vessel(surface.surface, read_centerline(folder / centerline_name, units=units))


VESSELS = {
    "stenosis": phantoms.stenosed_tube,
    "hairpin": phantoms.hairpin_tube,
    "branches": phantoms.branching_pulmonary_artery,
}
ONE_ANATOMY = (
    "pulmonary",
    *(pytest.param(name, marks=pytest.mark.bench) for name in ("aorta_iliac", "vmtk_aorta")),
)


def vessel_named(request):
    """The phantom or anatomy that the parameter of a fixture names."""
    if request.param in VESSELS:
        return VESSELS[request.param]()
    return anatomy(request.getfixturevalue("data_dir"), request.param)


def leaf_path(vessel: Vessel, leaf: int = 0):
    """The path of the centerline from its root to one of its leaves, with points in this order."""
    line = vessel.centerline
    return line.path(line.points[line.roots[0]], line.points[np.sort(line.leaves)[leaf]])


def anatomy_case(folder, name, start, length, ratio=1.25, radius=None, leaf=0) -> Case:
    """A stent over a range of arc length of a path; its radius is by default `ratio` times that of
    the widest lumen."""

    vessel = anatomy(folder, name)
    path = leaf_path(vessel, leaf)
    at = Line(path.points).arc_lengths
    covered = (at >= start) & (at <= start + length)
    if radius is None:
        radius = ratio * float(np.nanmax(path.inscribed_radius[covered]))
    return Case(
        vessel.points, vessel.triangles, Line(path.points).cut(start, start + length).points, radius
    )


PHANTOM_STENTS = {
    "straight_tube": (10.0, 16.0, 3.6),
    "stenosed_tube": (10.0, 20.0, 3.0),
    "bent_tube": (12.0, 16.0, 3.6),
    "helix_tube": (10.0, 25.0, 3.0),
    "hairpin_tube": (15.0, 30.0, 3.5),
    "arch_with_coarctation": (90.0, 24.0, 6.0),
    "branching_pulmonary_artery": (17.0, 22.0, 3.5),
    "tube_with_neighbor": (10.0, 20.0, 3.2),
}
"""Phantom, then where its stent starts, the stent's length and radius."""

COARSE = {"arch_with_coarctation": 2.0, "branching_pulmonary_artery": 1.2}
"""Edge lengths at which the plain method stays quick; 1 mm for the other phantoms."""


@cache
def phantom(name: str, **sizes):
    return getattr(phantoms, name)(**sizes)


def phantom_case(name: str, **sizes) -> Case:
    made = phantom(name, **{"edge_length": COARSE.get(name, 1.0), **sizes})
    start, length, radius = PHANTOM_STENTS[name]
    axis = made.axis_at(np.linspace(start, start + length, 200))
    return Case(made.points, made.triangles, axis, radius)


def hairpin(apart=8.0, leg=20.0, count=60):
    """An axis that turns back beside itself, with legs `apart` mm from each other."""
    turn = np.linspace(0, np.pi, count)
    half = apart / 2
    bow = np.column_stack([half - half * np.cos(turn), 0 * turn, leg + half * np.sin(turn)])
    up = np.linspace([0, 0, 0], [0, 0, leg], count)[:-1]
    down = np.linspace([apart, 0, leg], [apart, 0, 0], count)[1:]
    return np.concatenate([up, bow, down])


def helix(coil=6.0, pitch=9.0, turns=2.5, count=400):
    angle = np.linspace(0, 2 * np.pi * turns, count)
    return np.column_stack(
        [coil * np.cos(angle), coil * np.sin(angle), pitch * angle / (2 * np.pi)]
    )


def arc(bend=12.0, angle_deg=120.0, count=200):
    angle = np.linspace(0, np.radians(angle_deg), count)
    return np.column_stack([bend * np.sin(angle), 0 * angle, bend - bend * np.cos(angle)])


def straight(length=20.0):
    return np.array([[0.0, 0, 0], [0, 0, length]])


AXES = {"straight": straight(), "bent": arc(), "hairpin": hairpin(), "helix": helix()}
