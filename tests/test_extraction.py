"""Centerlines by VMTK, against the axes of the phantoms and those that came with anatomies."""

import importlib.util
import os

import numpy as np
import pytest
from child_processes import PROJECT, installed
from scipy.spatial import cKDTree
from tube_files import write_tube

from benchmarks.against_vmtk import SURFACES, compared, finely
from benchmarks.phantoms import (
    arch_with_coarctation,
    branching_pulmonary_artery,
    helix_tube,
    straight_tube,
)
from SDFStentLib.files import extract_lines, read_centerline, read_lines, read_surface
from SDFStentLib.geometry import Surface, norm
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import line_seeds

HAS_VMTK = importlib.util.find_spec("vmtk") is not None
needs_vmtk = pytest.mark.skipif(
    not HAS_VMTK, reason="the package vmtk is made for Python 3.12 and later"
)


def command(*words, **environment):
    """The shell in a process of its own."""
    return installed(*words, folder=PROJECT, env={**os.environ, **environment})


def extracted(surface, *places):
    return extract_lines(*line_seeds(surface, *places))


def axis_and_radius(tree):
    """The axes of a centerline every 0.1 mm, and the inscribed radius there."""
    points = finely(tree)
    return points, tree.inscribed_radius[cKDTree(tree.points).query(points)[1]]


@needs_vmtk
@pytest.mark.parametrize(
    "phantom",
    [straight_tube(), helix_tube(), arch_with_coarctation(), branching_pulmonary_artery()],
    ids=lambda phantom: phantom.name,
)
def test_the_lines_of_a_phantom_follow_the_axes_it_was_made_of(phantom):
    found = extracted(phantom.surface)
    assert len(found.lines) == len(phantom.openings) - 1
    axis, radius = axis_and_radius(phantom.centerline)
    distance, nearest = cKDTree(axis).query(found.points)
    is_away = np.ones(len(distance), dtype=bool)
    for opening in phantom.openings:  # where the cap stops the spheres before the wall does
        is_away &= norm(found.points - opening.center) > 2 * opening.radius
    for vessel in phantom.vessels[1:]:  # at a junction the largest spheres lead across
        is_away &= norm(found.points - vessel.axis.point(0.0)) > 10.0
    assert np.count_nonzero(is_away) > 50
    # A polyhedron of 0.8 mm edges has its own middle.
    assert distance[is_away].max() < 0.1
    assert np.abs(found.inscribed_radius - radius[nearest])[is_away].max() < 0.15


@needs_vmtk
@pytest.mark.parametrize("name", ["pulmonary", "aorta_iliac"])
def test_the_lines_of_an_anatomy_agree_with_the_centerline_that_came_with_it(data_dir, name):
    surface = read_surface(data_dir / f"{name}_surface_cm.vtp", "cm").surface
    known = read_centerline(data_dir / f"{name}_centerline_cm.vtp", "cm")
    found = extracted(surface)
    assert len(found.lines) == 2
    away = cKDTree(finely(known)).query(found.points)[0]
    assert np.median(away) < 0.5
    assert np.quantile(away, 0.95) < 3.0


@needs_vmtk
@pytest.mark.parametrize("name", [name for name in SURFACES if "su0243" not in name])
def test_own_lines_of_an_anatomy_are_those_of_vmtk(data_dir, name):
    """Without any lesion of one that the other has not; the patient with 92 ends is benchmarked."""
    found = compared(name)
    reached, ends = found["ends"].split(" of ")
    assert reached == ends
    assert found["median"] < 0.1
    assert found["95 %"] < 0.2
    own, vmtk, same = found["lesions own, VMTK, the same"].split(", ")
    assert own == vmtk == same


@needs_vmtk
@pytest.mark.parametrize("suffix", ["vtp", "vtk"])
def test_the_command_writes_what_deploy_reads_in_the_unit_of_the_surface(tmp_path, suffix):
    assert command("demo", "-o", tmp_path / "demo").returncode == 0
    surface, lines = tmp_path / "demo" / "surface.vtp", tmp_path / f"lines.{suffix}"
    run = command("centerline", surface, "-o", lines)
    assert run.returncode == 0, run.stderr
    assert "2 lines" in run.stdout
    found = read_lines(lines)
    assert found.frame == read_surface(surface).frame == "RAS"
    assert len(found.lines) == 2
    assert np.isfinite(found.inscribed_radius).all()
    run = command("measure", surface, "--centerline", lines)
    assert run.returncode == 0, run.stderr
    assert "Lesion 1" in run.stdout


@needs_vmtk
def test_an_open_surface_is_not_given_to_vmtk():
    tube = straight_tube()
    wall = Surface(tube.points, tube.triangles[tube.face_ids == tube.face_ids.min()])
    with pytest.raises(InputError, match="expected a watertight one"):
        extract_lines(wall, 0, [5])


@needs_vmtk
def test_no_way_between_two_vessels_is_a_sentence():
    one = straight_tube()
    count = len(one.points)
    both = Surface(
        np.vstack([one.points, one.points + np.array([30.0, 0, 0])]),
        np.vstack([one.triangles, one.triangles + count]),
    )
    with pytest.raises(DeploymentError, match="no centerline found"):
        extract_lines(both, 0, [count + 5])


def pretended_vmtk(folder, body):
    """A package of that name which does something else."""
    (folder / "vmtk").mkdir()
    (folder / "vmtk" / "__init__.py").write_text(body, encoding="utf-8")
    return {"PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])}


@pytest.fixture
def tube(tmp_path):
    write_tube(tmp_path)
    return tmp_path / "tube.vtp"


def test_a_vmtk_that_ends_its_process_costs_a_sentence(tmp_path, tube):
    out, body = tmp_path / "lines.vtp", "import os; os.abort()"
    words = ("centerline", tube, "--units", "cm", "-o", out, "--method", "vmtk")
    run = command(*words, **pretended_vmtk(tmp_path, body))
    assert run.returncode == 2
    assert run.stderr.startswith("sdfstent centerline: no centerline found (VMTK ended with code")
    assert run.stderr.count("\n") == 1
    assert not out.exists()


@pytest.mark.skipif(HAS_VMTK, reason="VMTK is installed")
def test_without_vmtk_the_sentence_says_how_to_install_it(tmp_path, shell):
    run = shell("centerline", "none.vtp", "-o", "l.vtp", "--method", "vmtk", folder=tmp_path)
    assert run.returncode == 2
    assert 'pip install "vmtk>=1.5"' in run.stderr


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["-o", "lines.vtp", "--inlet", "nan", "0", "0"], "--inlet: expected three finite numbers"),
        (["-o", "lines.vtp", "--outlet", "nan", "0", "0"], "--outlet: expected three finite num"),
        *(
            (["-o", f"lines{end}"], "one of .vtp, .vtk to write")
            for end in (".mrk.json", ".stl", "")
        ),
    ],
)
def test_what_no_line_can_be_extracted_with_is_a_sentence(
    tmp_path, tube, shell, monkeypatch, more, words
):
    pretended_vmtk(tmp_path, "")
    monkeypatch.syspath_prepend(tmp_path)
    run = shell("centerline", tube, *more, folder=tmp_path)
    assert run.returncode == 2
    assert words in run.stderr
    assert run.stderr.count("\n") == 1
