"""A picture for the heart-team meeting: the vessel before and after, rendered off-screen."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...files import check_writable, write_bytes
from ...geometry import arc_lengths, length, point_at
from ...validation import (
    DeploymentError,
    Floats,
    InputError,
    Points,
    Triangles,
    as_number,
    as_points,
    as_triangles,
)
from .geometry import diameter_colors, section_ring, stent_lattice, wall_colors
from .view import View, best_view, label_side

SIZE = (1200, 700)
"""Width and height of the picture, pixels."""

PANEL_ASPECT = 600 / 497
"""Width over height of one panel; `picture_scene` leaves the rest for words and scales."""

LABEL_SIZE = np.array([0.34, 0.11])
"""Width and height of the label with a diameter, in half heights of a panel."""

PATIENCE = 600
"""Seconds after which the renderer counts as stuck."""

PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
"""Debian packages with which VTK renders in software, without a screen."""


def render_before_after(
    path: str | os.PathLike[str],
    points_before: ArrayLike,
    points_after: ArrayLike,
    triangles: ArrayLike,
    axis_points: ArrayLike,
    stent_diameter: ArrayLike,
    *,
    arc_length: ArrayLike | None = None,
    diameter_before: ArrayLike | None = None,
    diameter_after: ArrayLike | None = None,
    title: str = "",
    anterior: tuple[float, float, float] = (0.0, 1.0, 0.0),
) -> Path:
    """Write a PNG with two panels, before and after, seen by the same camera.

    The stented wall is coloured by the local lumen diameter, the rest is drawn like glass in a
    tissue colour; the stent is a lattice of diamonds; a ring marks the narrowest section. The
    picture is drawn by a process of its own: without a usable graphics library VTK does not
    raise an error but ends the process.

    Parameters
    ----------
    path : path
        The file to write, replaced only when the picture is done.
    points_before, points_after : (n, 3) arrays
        The surface's points, mm.
    triangles : (m, 3) array
    axis_points : (k, 3) array
        Stent axis, mm, proximal end first.
    stent_diameter : float or (k,) array
        Diameter of the stent, mm, along the axis.
    arc_length, diameter_before, diameter_after : (p,) arrays, optional
        Lumen diameters, mm, at arc lengths along the stent axis; NaN where unknown. By default
        twice the distance from the axis to the nearest surface point.
    title : str
        A line on top, such as the patient's pseudonym.
    anterior : (3,) floats
        Where the patient's front is: +y in RAS, -y in LPS. The view is from there if it can be.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        Arrays that do not fit together, a path that cannot be written.
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    target = check_writable(path)
    case = _checked(points_before, points_after, triangles, axis_points, stent_diameter)
    case = _with_lumen(case, arc_length, diameter_before, diameter_after)
    view = best_view(case.axis, float(case.stent.max()) / 2, case.clouds, PANEL_ASPECT, anterior)
    write_bytes(target, _rendered(_arrays(case, view), _words(case, view, title)))
    return target


class _Case(NamedTuple):
    """What is drawn: surface before and after, stent, lumen diameters at stations, mm."""

    clouds: tuple[Points, Points]
    triangles: Triangles
    axis: Points
    stent: Floats
    stations: Floats
    lumen: tuple[Floats, Floats]

    @property
    def narrowest(self) -> int:
        """Number of the station with the smallest lumen before."""
        return int(np.argmin(self.lumen[0]))

    @property
    def limits(self) -> tuple[float, float]:
        """Diameters at the ends of the colour scale: half millimetres around all there are."""
        widest = max(self.stent.max(), *(values.max() for values in self.lumen))
        # What is printed as 6.0 mm does not push the scale to 6.5.
        lower = np.floor(2 * min(values.min() for values in self.lumen) + 0.1) / 2
        return float(lower), float(max(np.ceil(2 * widest - 0.1) / 2, lower + 0.5))


def _checked(
    points_before: ArrayLike,
    points_after: ArrayLike,
    triangles: ArrayLike,
    axis_points: ArrayLike,
    stent_diameter: ArrayLike,
) -> _Case:
    before = as_points(points_before, "points_before", minimum=3)
    after = as_points(points_after, "points_after", minimum=3)
    if len(before) != len(after):
        raise InputError(
            f"points_after: expected the {len(before)} points of points_before, "
            f"got {len(after)}; the surfaces before and after must have the same points."
        )
    faces = as_triangles(triangles, len(before))
    axis = as_points(axis_points, "axis_points", minimum=2)
    if length(axis) <= 0:
        raise InputError("axis_points: expected a line of some length, got equal points.")
    stent = np.asarray(stent_diameter, dtype=float)
    if stent.ndim == 0:
        stent = np.full(len(axis), as_number(stent_diameter, "stent_diameter", unit="mm", above=0))
    if stent.shape != (len(axis),) or not np.isfinite(stent).all() or stent.min() <= 0:
        raise InputError(
            f"stent_diameter: expected one number above 0 or {len(axis)} of them, one per axis "
            f"point, got shape {stent.shape}."
        )
    stations = arc_lengths(axis)
    return _Case((before, after), faces, axis, stent, stations, (stations, stations))


def _with_lumen(
    case: _Case,
    arc_length: ArrayLike | None,
    diameter_before: ArrayLike | None,
    diameter_after: ArrayLike | None,
) -> _Case:
    """The case with the lumen diameters given, or measured where none are given."""
    stations = case.stations
    if arc_length is not None:
        stations = np.atleast_1d(np.asarray(arc_length, dtype=float))
    elif diameter_before is not None or diameter_after is not None:
        raise InputError("arc_length: expected the positions of the diameters, got none.")
    inside = (stations >= -1e-6) & (stations <= length(case.axis) + 1e-6)
    if not inside.any() or (np.diff(stations) <= 0).any():
        raise InputError(
            f"arc_length: expected ascending positions on the stent axis of "
            f"{length(case.axis):.1f} mm, got {stations.min():g} to {stations.max():g}."
        )
    lumen = [
        _lumen(values, name, stations, cloud, case.axis)[inside]
        for values, name, cloud in (
            (diameter_before, "diameter_before", case.clouds[0]),
            (diameter_after, "diameter_after", case.clouds[1]),
        )
    ]
    return case._replace(stations=stations[inside], lumen=(lumen[0], lumen[1]))


def _lumen(
    values: ArrayLike | None, name: str, stations: Floats, cloud: Points, axis: Points
) -> Floats:
    """Lumen diameters at the stations, mm, gaps filled from their neighbours."""
    if values is None:
        # Late: scipy.spatial costs more to import than the rest of the library together.
        from scipy.spatial import KDTree

        return np.asarray(2 * KDTree(cloud).query(point_at(axis, stations))[0])
    numbers = np.atleast_1d(np.asarray(values, dtype=float))
    known = np.isfinite(numbers)
    if numbers.shape != stations.shape or not known.any():
        raise InputError(
            f"{name}: expected {len(stations)} diameters, one per entry of arc_length and not "
            f"all unknown, got {int(known.sum())} known ones in shape {numbers.shape}."
        )
    return np.interp(stations, stations[known], numbers[known])


def _arrays(case: _Case, view: View) -> dict[str, Any]:
    """Every array that is drawn."""
    arrays: dict[str, Any] = {
        "triangles": case.triangles,
        "colormap": diameter_colors(np.linspace(0, 1, 256)),
        "axis": case.axis,
        "lattice": stent_lattice(case.axis, case.stent / 2, 0.03 * float(case.stent.mean())),
    }
    reach = 1.15 * max(float(case.stent.max()), *(float(part.max()) for part in case.lumen)) / 2
    place = float(case.stations[case.narrowest])
    for name, cloud, lumen in zip(("before", "after"), case.clouds, case.lumen, strict=True):
        local = np.interp(arc_lengths(case.axis), case.stations, lumen)
        arrays[f"points_{name}"] = cloud
        arrays[f"colors_{name}"] = wall_colors(
            cloud, case.triangles, view, case.axis, local, reach, case.limits
        )
        arrays[f"ring_{name}"] = section_ring(case.axis, place, lumen[case.narrowest] / 2)
    return arrays


def _words(case: _Case, view: View, title: str) -> dict[str, Any]:
    """Camera, sizes and every word on the picture, ready for JSON."""
    sizes = sorted({f"{case.stent.min():.1f}", f"{case.stent.max():.1f}"}, key=float)
    minima = [f"{values.min():.1f} mm" for values in case.lumen]
    return {
        "focus": view.focus.tolist(),
        "toward_camera": view.toward_camera.tolist(),
        "up": view.up.tolist(),
        "half_height": view.half_height,
        "size": SIZE,
        "limits": case.limits,
        "strut": 0.016 * float(case.stent.mean()),
        "title": title,
        "headings": [f"Before: minimum lumen {minima[0]}", f"After: minimum lumen {minima[1]}"],
        "notes": [
            "with the planned stent axis",
            f"stent {' - '.join(sizes)} x {length(case.axis):.0f} mm",
        ],
        "marks": [f"{values[case.narrowest]:.1f} mm" for values in case.lumen],
        **_label(case, view),
        "scale_title": "Lumen diameter (mm)",
        "small_print": "Research use only. Not for clinical decisions.",
    }


def _label(case: _Case, view: View) -> dict[str, list[float]]:
    """The narrowest section, the label beside it and the end of its leader, mm right and up."""
    center = point_at(case.axis, case.stations[case.narrowest])
    size = view.half_height * LABEL_SIZE
    side = label_side(view, np.vstack(case.clouds), center, 0.7 * case.limits[1], size)
    marked = np.array([(center - view.focus) @ view.right, (center - view.focus) @ view.up])
    inward = np.min(size / 2 / np.maximum(np.abs(side), 1e-9))
    return {
        "marked": marked.tolist(),
        "label": (marked + side).tolist(),
        "leader": (marked + side * (1 - inward)).tolist(),
    }


def _rendered(arrays: dict[str, Any], words: dict[str, Any]) -> bytes:
    """The PNG that a process of its own draws."""
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        np.savez(Path(folder) / "scene.npz", words=json.dumps(words), **arrays)
        picture = Path(folder) / "picture.png"
        package_parent = str(Path(__file__).resolve().parents[1])
        program = (
            "import sys; sys.path.insert(0, sys.argv[1]); "
            "from SDFStentLib.report.picture.scene import draw; draw(sys.argv[2], sys.argv[3])"
        )
        command = [sys.executable, "-c", program, package_parent]
        try:
            done = subprocess.run(
                [*command, str(Path(folder) / "scene.npz"), str(picture)],
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise DeploymentError(f"The picture could not be rendered: {error}.") from error
        if done.returncode != 0 or not picture.is_file():
            raise DeploymentError(_no_renderer(done.returncode, done.stderr))
        return picture.read_bytes()


def _no_renderer(code: int, said: bytes) -> str:
    last = said.decode(errors="replace").strip().splitlines()[-1:]
    ending = f" (it said: {last[0]})" if last and code > 0 else ""
    return (
        f"The picture could not be rendered: VTK's process ended with code {code}{ending}; it "
        f"needs an OpenGL library, on Debian and Ubuntu: apt install {PACKAGES}, and VTK 9.4 or "
        "later where there is no screen. Everything else works without pictures."
    )
