"""300,000 triangles through the command line in less than 500 MB."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy, leaf_path
from vtkmodules.vtkFiltersModeling import vtkLinearSubdivisionFilter

from SDFStentLib.files import polydata
from SDFStentLib.files.formats import vtk_files as vtk_formats
from SDFStentLib.files.surface_files import read_surface
from SDFStentLib.geometry.polyline import point_at
from SDFStentLib.phantoms.phantoms import straight_tube

resource = pytest.importorskip("resource", reason="memory is not measured on this system")

PROJECT = Path(__file__).resolve().parents[1]
LIMIT_MB = 500

MEASURED = """
import json, resource, subprocess, sys
run = subprocess.run(sys.argv[1:], capture_output=True, text=True)
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
peak_mb = peak / (1e6 if sys.platform == "darwin" else 1e6 / 1024)
print(json.dumps([run.returncode, peak_mb, run.stdout + run.stderr]))
"""
"""A process between: a child starts with the peak of its parent, and that of the tests is high."""


def peak_of(folder, *arguments):
    """Exit code, peak of resident memory in MB, and what a command has said."""
    command = [sys.executable, "-m", "SDFStentLib", *map(str, arguments)]
    run = subprocess.run(
        [sys.executable, "-c", MEASURED, *command],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(run.stdout)


def write_subdivided(data, path):
    """Write a surface with 16 triangles for each."""
    split = vtkLinearSubdivisionFilter()
    split.SetInputData(data)
    split.SetNumberOfSubdivisions(2)
    split.Update()
    count = split.GetOutput().GetNumberOfPolys()
    # 300,000 within 2 %, so that the limit is tried and nothing else.
    assert count == pytest.approx(300_000, rel=0.02)
    path.write_bytes(vtk_formats.encode_vtp(split.GetOutput()))


@pytest.fixture(scope="module")
def a_vessel(request, tmp_path_factory):
    """A folder with 300,000 triangles in cm, float32, and a centerline; and a stent for them."""
    folder = tmp_path_factory.mktemp("vessel")
    try:
        return folder, an_aorta(request.getfixturevalue("data_dir"), folder)
    except pytest.skip.Exception:
        return folder, a_tube(folder)


def an_aorta(data_folder, folder):
    surface, line, units = ANATOMIES["aorta_iliac"]
    assert units == "cm"
    write_subdivided(read_surface(data_folder / surface, units).polydata(), folder / "surface.vtp")
    shutil.copyfile(data_folder / line, folder / "line.vtp")
    path = leaf_path(anatomy(data_folder, "aorta_iliac"))
    center = point_at(path.points, 60.0) / 10
    return ["--center", *center, "--diameter", 2.5 * np.nanmax(path.inscribed_radius)]


def a_tube(folder):
    made = straight_tube(radius=8.0, length=80.0, edge_length=0.74)
    data = polydata.polydata_from_arrays(
        (made.points / 10).astype(np.float32),
        made.triangles,
        cell_arrays={"ModelFaceID": made.face_ids},
    )
    write_subdivided(data, folder / "surface.vtp")
    tree = made.centerline
    line = polydata.polydata_from_lines(tree.points / 10, [np.arange(len(tree.points))])
    polydata.add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius / 10}, {})
    (folder / "line.vtp").write_bytes(vtk_formats.encode_vtp(line))
    return ["--center", 0, 0, 4, "--diameter", 20]


SURFACE = ["surface.vtp", "--units", "cm"]
LINE = ["--centerline", "line.vtp"]


def test_a_stent_is_deployed_certified_and_written_within_the_limit(a_vessel):
    folder, stent = a_vessel
    code, peak_mb, said = peak_of(
        folder, "deploy", *SURFACE, *LINE, *stent, "--length", 30, "-o", "out.vtp", "--arrays",
        "--report", "r.json", "--output-centerline", "moved.vtp",
    )  # fmt: skip
    assert code == 0, said
    assert "Surface certified for meshing" in said
    assert peak_mb < LIMIT_MB


@pytest.mark.parametrize(
    "arguments", [["check", *SURFACE], ["measure", *SURFACE, *LINE, "--spacing", 30]]
)
def test_a_surface_is_checked_and_measured_within_the_limit(a_vessel, arguments):
    code, peak_mb, said = peak_of(a_vessel[0], *arguments)
    assert code == 0, said
    assert peak_mb < LIMIT_MB
