"""300,000 triangles through the command line in less than 500 MB."""

import shutil

import numpy as np
import pytest
from child_processes import measured
from deployment_cases import ANATOMIES, anatomy, leaf_path
from vtkmodules.vtkFiltersModeling import vtkLinearSubdivisionFilter

from benchmarks.phantoms import straight_tube
from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
)
from SDFStentLib.geometry import Line

pytest.importorskip("resource", reason="memory is not measured on this system")

LIMIT_MB = 500


def write_subdivided(data, path):
    """Write a surface with 16 triangles for each."""
    split = vtkLinearSubdivisionFilter()
    split.SetInputData(data)
    split.SetNumberOfSubdivisions(2)
    split.Update()
    count = split.GetOutput().GetNumberOfPolys()
    # 300,000 within 2 %, so that the limit is tried and nothing else.
    assert count == pytest.approx(300_000, rel=0.02)
    path.write_bytes(encode_vtp(split.GetOutput()))


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
    center = Line(path.points).at(60.0) / 10
    return ["--center", *center, "--diameter", 2.5 * np.nanmax(path.inscribed_radius)]


def a_tube(folder):
    made = straight_tube(radius=8.0, length=80.0, edge_length=0.74)
    data = polydata_from_arrays(
        (made.points / 10).astype(np.float32),
        made.triangles,
        cell_arrays={"ModelFaceID": made.face_ids},
    )
    write_subdivided(data, folder / "surface.vtp")
    tree = made.centerline
    line = polydata_from_lines(tree.points / 10, [np.arange(len(tree.points))])
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius / 10}, {})
    (folder / "line.vtp").write_bytes(encode_vtp(line))
    return ["--center", 0, 0, 4, "--diameter", 20]


SURFACE = ["surface.vtp", "--units", "cm"]
LINE = ["--centerline", "line.vtp"]


def test_a_stent_is_deployed_certified_and_written_within_the_limit(a_vessel):
    folder, stent = a_vessel
    done = measured(
        "deploy", *SURFACE, *LINE, *stent, "--length", 30, "-o", "out.vtp", "--arrays",
        "--report", "r.json", "--output-centerline", "moved.vtp", folder=folder,
    )  # fmt: skip
    assert done.code == 0, done.said
    assert "Surface certified for meshing" in done.said
    assert done.peak_mb < LIMIT_MB


@pytest.mark.bench
@pytest.mark.parametrize(
    "arguments", [["check", *SURFACE], ["measure", *SURFACE, *LINE, "--spacing", 30]]
)
def test_a_surface_is_checked_and_measured_within_the_limit(a_vessel, arguments):
    done = measured(*arguments, folder=a_vessel[0])
    assert done.code == 0, done.said
    assert done.peak_mb < LIMIT_MB
