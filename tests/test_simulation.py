"""`sdfstent simulate`: meshes and files for svMultiPhysics, and what is read of its results.

No solver runs here: a script stands in for it, and fields that are exact solutions for its
results.
"""

import json
import math
import os
import re
import shutil
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from mesh_files import read_vtk
from tube_files import write_line, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

from benchmarks.phantoms import stenosed_tube, straight_tube
from SDFStentLib.certificate import check_surface, smallest_angles
from SDFStentLib.cli import flow as commands
from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, read_volume
from SDFStentLib.files.formats import decode_vtu, encode_vtu
from SDFStentLib.flow import Wave
from SDFStentLib.geometry import Surface, SurfaceIndex, signed_volume
from SDFStentLib.report import mesh_sentences
from SDFStentLib.simulation import Conditions, Cycle, End, prepare
from SDFStentLib.simulation.ends import extended
from SDFStentLib.simulation.mmg import MeditMesh, _program
from SDFStentLib.simulation.prepared import Filled, well_filled
from SDFStentLib.simulation.remesh import TOLERANCE, Wishes, axis_of, edges_around, mended, remeshed
from SDFStentLib.simulation.solver_file import solver_files, time_steps
from SDFStentLib.simulation.tetrahedra import dihedral_angles, filled
from SDFStentLib.treatment import Vessel, extract_segment
from SDFStentLib.validation import DeploymentError, InputError

RADIUS, LENGTH, FLOW = 3.0, 40.0, 20.0
MU = 0.04
MMHG = 1333.22
KNOWN = ["--mean-flow", f"{FLOW}mL/s", "--inlet-pressure", "25", "--wedge", "8"]


def radius_after(z):
    """Of the tube after its stent, mm."""
    return RADIUS * (1 + 0.2 * np.clip(1 - ((z - 20) / 5) ** 2, 0, None) ** 2)


def write_vessel(folder):
    """A tube, the same with its middle widened, and its centerline, in mm."""
    tube = straight_tube(RADIUS, LENGTH, edge_length=1.2)
    points, triangles = tube.surface.points, tube.surface.triangles
    wider = points * np.column_stack(
        [*2 * [radius_after(points[:, 2]) / RADIUS], 1 + 0 * points[:, 2]]
    )
    for name, one in (("before", points), ("after", wider)):
        write_wall(folder / f"{name}.vtp", one, triangles)
    line = tube.centerline.points
    write_line(folder / "line.vtp", line)


def simulate(*more, out="sim", after="after.vtp", known=KNOWN):
    words = ["simulate", "before.vtp", "--after", after, "--centerline", "line.vtp", "-o", out]
    return main([*words, *known, "--coarser", "4", *more])


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder with the tube and its cases, and the meshes that were made for these."""
    folder = tmp_path_factory.mktemp("simulate")
    write_vessel(folder)
    made = []
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(commands, "prepare", lambda *a, **k: made.append(prepare(*a, **k)) or made[0])
        assert simulate("--no-run", "--quiet") == 0
    return folder, made[0]


@pytest.fixture
def folder(prepared, tmp_path, monkeypatch):
    """A copy of its own for each test, to be in."""
    shutil.copytree(prepared[0], tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def narrowed_segment():
    tube = stenosed_tube()
    line = tube.centerline.points
    found = extract_segment(Vessel(tube.surface, tube.centerline), line[4], line[-5])
    segment = found.before
    is_wall = np.isin(segment.face_ids, [*segment.walls])
    return tube, segment, axis_of(segment.surface, is_wall, tube.centerline.points)


@pytest.fixture(scope="module")
def meshed():
    tube, segment, axis = narrowed_segment()
    return tube, segment, next(remeshed(segment, axis, Wishes()))


@pytest.fixture(scope="module")
def coarsely_meshed():
    _, segment, axis = narrowed_segment()
    return segment, next(remeshed(segment, axis, Wishes(coarser=2)))


def test_a_new_surface_lies_on_the_wall_with_enough_edges_round_the_throat(meshed):
    tube, segment, made = meshed
    assert made.deviation <= TOLERANCE
    surface = made.surface
    assert check_surface(surface).passed
    assert surface.topology.is_watertight
    is_wall = np.isin(made.face_ids, [*segment.walls])
    points = surface.points[np.unique(surface.triangles[is_wall])]
    true = tube.vessels[0].radius(points[:, 2])
    # The old triangles have chords of 0.027 mm; the new points lie on the wall that they stand for.
    assert np.abs(np.hypot(*points[:, :2].T) - true).max() < TOLERANCE / 4
    middles = surface.points[surface.triangles[is_wall]].mean(axis=1)
    off = np.hypot(*middles[:, :2].T) - tube.vessels[0].radius(middles[:, 2])
    assert np.abs(off).max() < TOLERANCE
    assert edges_around(surface, np.array([0, 0, 20.1]), np.array([0, 0, 1.0])) >= 20


def test_a_triangle_that_is_turned_over_is_mended_along_the_wall(meshed):
    _, segment, made = meshed
    surface, wall = made.surface, [*segment.walls]
    rng = np.random.default_rng(5)
    points, triangles = surface.points.copy(), surface.triangles
    inner = np.setdiff1d(triangles, triangles[~np.isin(made.face_ids, wall)])
    for corner in rng.choice(inner, 3, replace=False):
        # Beyond the far side of one of its triangles.
        one = triangles[(triangles == corner).any(axis=1)][0]
        points[corner] += 1.3 * (points[one[one != corner]].mean(axis=0) - points[corner])
    none = np.zeros((0, 4), np.int64)
    broken = MeditMesh(points, triangles, made.face_ids, none)
    assert not check_surface(Surface(points, triangles)).passed
    found = mended(broken)
    assert check_surface(found).passed
    assert np.abs(found.points - surface.points).max() < 0.3
    assert SurfaceIndex(found.points, triangles).distances(points).distance.max() < 2 * TOLERANCE
    np.testing.assert_array_equal(
        mended(broken._replace(points=surface.points)).points, surface.points
    )


def test_slim_triangles_and_flat_tetrahedra_are_not_left(coarsely_meshed, monkeypatch):
    """On slim triangles tetrahedra are flat: they are spread out, what stays flat is refused."""
    segment, made = coarsely_meshed
    points, triangles = made.surface.points.copy(), made.surface.triangles
    inner = np.setdiff1d(triangles, triangles[~np.isin(made.face_ids, [*segment.walls])])
    for corner in np.random.default_rng(3).choice(inner, 3, replace=False):
        one = triangles[(triangles == corner).any(axis=1)][0]
        points[corner] += 0.97 * (points[one[one != corner]].mean(axis=0) - points[corner])
    assert smallest_angles(points, triangles).min() < 3
    none = np.zeros((0, 4), np.int64)
    found = mended(MeditMesh(points, triangles, made.face_ids, none))
    assert smallest_angles(found.points, triangles).min() > 10
    assert check_surface(found).passed
    assert well_filled([made]).quality.smallest_angle > 1
    monkeypatch.setattr("SDFStentLib.simulation.prepared.FLAT_DEG", 60.0)
    with pytest.raises(DeploymentError, match="at least 60 degree"):
        well_filled([made])


def test_slim_triangles_are_spread_along_the_wall(coarsely_meshed):
    """A mean of neighbors lies inside of a bent wall."""
    segment, made = coarsely_meshed
    radius_at = stenosed_tube().vessels[0].radius
    points, triangles = made.surface.points.copy(), made.surface.triangles
    inner = np.setdiff1d(triangles, triangles[~np.isin(made.face_ids, [*segment.walls])])
    for corner in np.random.default_rng(3).choice(inner, 3, replace=False):
        one = triangles[(triangles == corner).any(axis=1)][0]
        points[corner] += 0.97 * (points[one[one != corner]].mean(axis=0) - points[corner])
        points[corner, :2] *= radius_at(points[corner, 2]) / np.hypot(*points[corner, :2])
    found = mended(MeditMesh(points, triangles, made.face_ids, np.zeros((0, 4), np.int64)))
    x, y, z = found.points[(found.points != points).any(axis=1)].T
    assert len(z) > 3
    assert np.abs(np.hypot(x, y) - radius_at(z)).max() < TOLERANCE / 2


def test_tetrahedra_fill_the_surface_and_have_no_flat_ones(coarsely_meshed):
    _, made = coarsely_meshed
    volume = filled(made)
    count = len(made.surface.points)
    np.testing.assert_array_equal(volume.points[:count], made.surface.points)
    corners = volume.points[volume.tetrahedra]
    sizes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
    assert np.abs(sizes).sum() == pytest.approx(
        signed_volume(made.surface.points, made.surface.triangles), rel=1e-9
    )
    angles = dihedral_angles(volume.points, volume.tetrahedra)
    assert angles.min() > 8
    assert angles.max() < 165
    np.testing.assert_allclose(
        dihedral_angles(np.eye(4, 3) * 1.0, np.array([[0, 1, 2, 3]])).max(), 90, atol=1e-9
    )


def test_an_end_is_drawn_out_where_there_is_room():
    _, segment, _ = narrowed_segment()
    longer = extended(segment, "outlet", 7.0)
    (face,) = (one for one in segment.faces if one.name == "outlet")
    (moved,) = (one for one in longer.faces if one.name == "outlet")
    assert longer.volume == pytest.approx(segment.volume + 7.0 * face.area, rel=1e-9)
    np.testing.assert_allclose(moved.center - face.center, [0, 0, 7.0], atol=1e-9)
    assert longer.surface.topology.is_watertight
    assert longer.faces[-1].kind == "wall"


def test_a_folder_has_all_that_the_solver_asks_for(folder):
    document = json.loads(Path("sim/simulation.json").read_text(encoding="utf-8"))
    for case in ("before", "after", "coarse/before", "coarse/after"):
        root = ElementTree.parse(folder / "sim" / case / "solver.xml").getroot()
        assert root.tag == "svMultiPhysicsFile"
        mesh = read_vtk(folder / "sim" / case / root.findtext("Add_mesh/Mesh_file_path"))
        elements = mesh.GetNumberOfCells()
        names = [face.get("name") for face in root.findall("Add_mesh/Add_face")]
        assert names == ["inlet", "outlet", "wall"]
        for face in root.findall("Add_mesh/Add_face"):
            data = read_vtk(folder / "sim" / case / face.findtext("Face_file_path"))
            nodes = vtk_to_numpy(data.GetPointData().GetArray("GlobalNodeID")) - 1
            own = vtk_to_numpy(data.GetPoints().GetData())
            np.testing.assert_array_equal(own, vtk_to_numpy(mesh.GetPoints().GetData())[nodes])
            behind = vtk_to_numpy(data.GetCellData().GetArray("GlobalElementID"))
            assert behind.min() >= 1
            assert behind.max() <= elements
        assert [bc.get("name") for bc in root.findall("Add_equation/Add_BC")] == names
        assert root.findtext("Add_equation/LS/Linear_algebra/Preconditioner") == "fsils"
        rows = Path("sim", case, "inlet.flow").read_text(encoding="utf-8").splitlines()
        assert rows[0] == "2 1"
        assert float(rows[2].split()[1]) == pytest.approx(-FLOW)
        kind = root.find("Add_equation/Add_BC[@name='outlet']")
        assert kind.findtext("Time_dependence") == "Resistance"
        # Before, what lies beyond the outlet and the segment itself take 25 - 8 mmHg.
        drop = document["network_mmhg"]["before"]["recovered"][0] * MMHG
        assert float(kind.findtext("Value")) * FLOW + drop == pytest.approx(17 * MMHG, rel=0.2)
    fine, coarse = (document["states"]["before"]["meshes"][name] for name in ("fine", "coarse"))
    assert fine["tetrahedra"] > 2 * coarse["tetrahedra"]
    assert set(document["extensions_mm"]) == {"outlet"}


def test_a_wave_is_solved_over_cycles_and_flows_may_be_set_at_outlets():
    time = np.linspace(0, 0.8, 21)
    shape = 1 + 0.5 * np.sin(2 * math.pi * time / 0.8)
    shape[-1] = shape[0]
    ends = (
        End("inlet", "flow", -FLOW, -FLOW),
        End("main", "pressure", 0.0, 15.0),
        End("branch", "flow", 5.0, 5.0),
        End("lung", "resistance", 1000.0, 2.0),
    )
    cycle = Cycle(time, np.outer([one.flow for one in ends], shape), 100)
    conditions = Conditions(ends, cycle, wedge=8 * MMHG)
    texts = solver_files(conditions, time_steps(conditions, 0.3, 1.5, 1000.0))
    assert "<!--" not in texts["solver.xml"]
    root = ElementTree.fromstring(texts["solver.xml"])
    general = root.find("GeneralSimulationParameters")
    length, count, every, start = (
        float(general.findtext(name))
        for name in (
            "Time_step_size",
            "Number_of_time_steps",
            "Increment_in_saving_VTK_files",
            "Start_saving_after_time_step",
        )
    )
    assert length * count == pytest.approx(3 * 0.8)
    assert (count - start + 1) / every == pytest.approx(20)
    outlet = root.find("Add_equation/Add_BC[@name='main']")
    assert (outlet.findtext("Time_dependence"), outlet.findtext("Value")) == ("Steady", "0.0")
    lung = root.find("Add_equation/Add_BC[@name='lung']")
    assert lung.findtext("Time_dependence") == "RCR"
    proximal, compliance, distal, start = (
        float(lung.findtext(f"RCR_values/{name}"))
        for name in ("Proximal_resistance", "Capacitance", "Distal_resistance", "Initial_pressure")
    )
    assert (proximal, proximal + distal) == pytest.approx((100.0, 1000.0))
    assert (proximal + distal) * compliance == pytest.approx(0.75)
    # It begins as full as it is in the mean, above the wedge pressure.
    assert float(lung.findtext("RCR_values/Distal_pressure")) == pytest.approx(8 * MMHG)
    assert start == pytest.approx(8 * MMHG + 2.0 * distal)
    tables = {
        name: np.array([row.split() for row in texts[f"{name}.flow"].splitlines()[1:]], float)
        for name in ("inlet", "branch")
    }
    assert tables["inlet"][:, 1].min() == pytest.approx(-1.5 * FLOW, rel=1e-2)
    assert tables["inlet"][0, 1] == tables["inlet"][-1, 1]
    np.testing.assert_allclose(tables["branch"][:, 1], -tables["inlet"][:, 1] / 4)


def series(text):
    """What the solver makes of a file of flow at its rows: so many harmonics of the line."""
    (rows, modes), *table = (row.split() for row in text.splitlines())
    time, flow = np.array(table, float).T
    assert len(time) == int(rows)
    at = np.linspace(0, time[-1], 40_001)
    line = np.interp(at, time, flow)
    found = np.full(len(time), np.trapezoid(line, at) / time[-1])
    for n in range(1, int(modes)):
        turn = np.exp(-2j * np.pi * n * at / time[-1])
        part = np.trapezoid(line * turn, at) / time[-1]
        found += 2 * np.real(part * np.exp(2j * np.pi * n * time / time[-1]))
    return found, flow


@pytest.mark.parametrize("rest", [0.0, 10.0])
def test_a_spike_reaches_the_solver_as_high_as_it_is(rest):
    """Sixteen harmonics had a seventh of it."""
    wave = Wave((0, 0.1, 0.105, 0.11, 0.8), (rest, rest, 150, rest, rest))
    ends = (
        End("inlet", "flow", -wave.mean, -wave.mean),
        End("outlet", "resistance", 1000.0, wave.mean),
    )
    cycle = Cycle(np.array(wave.time), np.outer([-1, 1], wave.flow), wave.steps)
    conditions = Conditions(ends, cycle)
    steps = time_steps(conditions, 3.0, 6.0, 1000.0)
    assert steps.number >= 3 * wave.steps
    found, flow = series(solver_files(conditions, steps)["inlet.flow"])
    assert found == pytest.approx(flow, abs=0.0101 * np.ptp(flow))
    assert flow.min() == pytest.approx(-150)


def test_too_many_steps_are_refused_before_anything_is_meshed(folder, capsys, monkeypatch):
    def no_mesh(*_):
        raise AssertionError

    monkeypatch.setattr("SDFStentLib.simulation.prepared.remeshed", no_mesh)
    rows = ["s,mL/s", *(f"{t},{q}" for t, q in ((0, 1), (5, 30), (9, 3), (400, 1)))]
    Path("wave.csv").write_text("\n".join(rows), encoding="utf-8")
    known = ["--wave", "wave.csv", "--unusual-flow"]
    assert simulate("--no-run", out="many", known=known) == 2
    said = capsys.readouterr().err
    count = int(
        re.search(r"at most 200,000 steps of time, got ([\d,]+), each", said)[1].replace(",", "")
    )
    assert count > 200_000
    assert not Path("many").exists()


def test_pressures_are_above_a_wedge_that_the_solver_does_not_know(folder, capsys, prepared):
    """Its issue 486: a resistance has no distal pressure."""
    text = Path("sim/before/solver.xml").read_text(encoding="utf-8")
    words = "all pressures are above the wedge pressure of 10665.8 dyn/cm2"
    assert words in text
    assert ElementTree.fromstring(text).find("Add_equation") is not None
    said = " ".join(mesh_sentences(prepared[1]))
    assert "above the wedge pressure of 8 mmHg" in said
    write_results(folder / "sim")
    assert main(["simulate", "--read", "sim", "--json", "out.json"]) == 0
    assert "above the wedge pressure of 8 mmHg" in capsys.readouterr().out


def tube_flow(points, radius):
    """Poiseuille's flow with the local radius (mm) at points in cm: velocity and pressure."""
    x, y, z = points.T
    local = radius(10 * z) / 10
    speed = 2 * FLOW / (math.pi * local**2) * (1 - (x**2 + y**2) / local**2)
    fine = np.linspace(z.min(), z.max(), 4001)
    slope = 8 * MU * FLOW / (math.pi * (radius(10 * fine) / 10) ** 4)
    lost = np.concatenate([[0], np.cumsum((slope[1:] + slope[:-1]) / 2 * np.diff(fine))])
    return np.column_stack([0 * z, 0 * z, speed]), lost[-1] - np.interp(z, fine, lost)


def write_result(case, radius, *, step=10, shuffled=False, factor=1.0, flow=1.0):
    """A result as the solver writes it, here an exact solution, of so many times the flow."""
    volume, _ = read_volume(case / "mesh" / "mesh-complete.mesh.vtu")
    points = volume.points / 10
    velocity, pressure = tube_flow(points, radius)
    order = (
        np.random.default_rng(0).permutation(len(points)) if shuffled else np.arange(len(points))
    )
    corners = np.argsort(order)[volume.tetrahedra]
    arrays = {"Velocity": flow * velocity[order], "Pressure": factor * flow * pressure[order]}
    (case / "results").mkdir(exist_ok=True)
    path = case / "results" / f"result_{step:03d}.vtu"
    path.write_bytes(encode_vtu(points[order], corners, arrays, {}))


def straight(z):
    return RADIUS + 0 * z


def write_results(folder, **more):
    for name in ("before", "coarse/before"):
        write_result(folder / name, straight, **more)
    for name in ("after", "coarse/after"):
        write_result(folder / name, radius_after, **more)


@pytest.mark.parametrize("shuffled", [False, True])
def test_an_exact_solution_is_read_with_its_drop_flow_and_wall_shear(folder, capsys, shuffled):
    """Poiseuille's flow on the nodes: pressure is linear, so exact; speed is interpolated."""
    write_results(folder / "sim", shuffled=shuffled)
    assert main(["simulate", "--read", "sim", "--json", "out.json", "--report", "out.html"]) == 0
    document = json.loads(Path("out.json").read_text(encoding="utf-8"))
    before = document["before"]["mean"]
    volume, _ = read_volume("sim/before/mesh/mesh-complete.mesh.vtu")
    length = np.ptp(volume.points[:, 2]) / 10
    drop = 8 * MU * FLOW * length / (math.pi * (RADIUS / 10) ** 4) / MMHG
    assert before["static_drop_mmhg"]["value"] == pytest.approx(drop, rel=1e-6)
    assert before["static_drop_mmhg"]["error"] == pytest.approx(0, abs=1e-6)
    # A parabola between nodes is low by some (edge / radius)^2.
    edges = document["meshes"]["before"]["fine"]["edges_round_throat"]
    edge = 2 * math.pi / edges
    assert before["inflow_ml_s"] == pytest.approx(FLOW, rel=edge**2)
    # The slope over a tetrahedron at the wall is low by half its height over the radius.
    shear = 0.1 * 4 * MU * FLOW / (math.pi * (RADIUS / 10) ** 3)
    assert shear * (1 - edge / 2) < before["shear_mean_pa"]["value"] < shear
    assert before["shear_mean_pa"]["value"] + before["shear_mean_pa"]["error"] > 0.95 * shear
    assert before["inlet_mmhg"]["static"] == pytest.approx(8 + drop, rel=1e-6)
    assert document["after"]["mean"]["static_drop_mmhg"]["value"] < 0.95 * drop
    along = np.array(before["static_along_mmhg"], float)
    inner = np.isfinite(along)
    slope = np.polyfit(np.array(document["along_mm"])[inner], along[inner], 1)[0]
    assert slope == pytest.approx(-drop / (10 * length), rel=0.02)
    said = capsys.readouterr().out
    assert "drop of static pressure to outlet: " in said
    assert "[network " in said
    page = Path("out.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 2
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")


def test_a_wave_is_told_by_the_mean_of_its_last_cycle_and_by_its_peak(
    folder, prepared, monkeypatch, capsys
):
    filled_before = iter(
        Filled(*mesh[:3]) for state in prepared[1].states.values() for mesh in state.meshes.values()
    )
    monkeypatch.setattr(
        "SDFStentLib.simulation.prepared.well_filled", lambda _: next(filled_before)
    )
    waves = 1 + 0.5 * np.sin(2 * math.pi * np.arange(21) / 20)
    rows = [f"{0.04 * k},{FLOW * one}" for k, one in enumerate(waves)]
    Path("wave.csv").write_text("\n".join(["s,mL/s", *rows]), encoding="utf-8")
    known = ["--wave", "wave.csv", *KNOWN[2:]]
    assert simulate("--no-run", "--quiet", out="wave", known=known) == 0
    solver = ElementTree.parse("wave/before/solver.xml").getroot()
    outlet = solver.find("Add_equation/Add_BC[@name='outlet']")
    assert outlet.findtext("Time_dependence") == "RCR"
    # Its resistance and the tube take the pressures that are known, in the mean over the wave.
    lung = sum(
        float(outlet.findtext(f"RCR_values/{part}_resistance")) for part in ("Proximal", "Distal")
    )
    told = json.loads(Path("wave/simulation.json").read_text(encoding="utf-8"))
    drop = told["network_mmhg"]["before"]["recovered"][0] * MMHG
    moving = 1.06 / 2 * np.mean((FLOW * waves[:20] / (math.pi * (RADIUS / 10) ** 2)) ** 2)
    assert lung * FLOW + drop + moving == pytest.approx(17 * MMHG, rel=0.01)
    distal = float(outlet.findtext("RCR_values/Distal_pressure"))
    assert distal == pytest.approx(8 * MMHG, rel=1e-4)
    assert told["level_mmhg"] == 0
    # Five frames of the cycle before it, which do not count, and the last one's.
    for k, one in enumerate([3.0] * 5 + waves[:20].tolist()):
        write_results(folder / "wave", step=10 * k + 10, flow=one)
    assert main(["simulate", "--read", "wave", "--json", "out.json"]) == 0
    before = json.loads(Path("out.json").read_text(encoding="utf-8"))["before"]
    drops = [before[moment]["static_drop_mmhg"]["value"] for moment in ("mean", "peak")]
    volume, _ = read_volume("wave/before/mesh/mesh-complete.mesh.vtu")
    length = np.ptp(volume.points[:, 2]) / 10
    drop = 8 * MU * FLOW * length / (math.pi * (RADIUS / 10) ** 4) / MMHG
    assert drops == pytest.approx([drop, 1.5 * drop], rel=1e-6)
    flows = [before[moment]["inflow_ml_s"] for moment in ("mean", "peak")]
    assert flows[1] == pytest.approx(1.5 * flows[0])
    said = capsys.readouterr().out
    assert "peak" in said
    assert "did not become steady" not in said


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("simulation.json", None, "expected a folder of `sdfstent simulate`"),
        (
            "simulation.json",
            '{"schema": "sdfstent-simulation"}',
            "expected a whole simulation.json",
        ),
        ("before/results/result_010.vtu", None, "expected the results of a solver"),
        ("before/results/result_010.vtu", "cut short", "expected a VTU file"),
    ],
)
def test_a_folder_that_is_not_whole_is_a_sentence(folder, capsys, name, text, said):
    write_results(folder / "sim")
    path = folder / "sim" / name
    path.unlink()
    if text is not None:
        path.write_text(text, encoding="utf-8")
    assert main(["simulate", "--read", "sim", "--json", "out.json"]) == 2
    assert said in capsys.readouterr().err
    assert not Path("out.json").exists()


def test_results_that_are_no_numbers_or_of_another_mesh_are_a_sentence(folder, capsys):
    write_results(folder / "sim", factor=math.nan)
    assert main(["simulate", "--read", "sim"]) == 2
    assert "the solver did not converge" in capsys.readouterr().err
    write_results(folder / "sim")
    shutil.copy("sim/coarse/before/results/result_010.vtu", "sim/before/results/result_010.vtu")
    assert main(["simulate", "--read", "sim"]) == 2
    assert "expected the points of the mesh beside it" in capsys.readouterr().err


def test_flow_that_is_not_steady_and_a_missing_coarse_mesh_are_told(folder, capsys):
    write_results(folder / "sim")
    write_result(folder / "sim" / "before", straight, step=20, factor=1.2)
    shutil.rmtree("sim/coarse/before/results")
    shutil.rmtree("sim/coarse/after/results")
    assert main(["simulate", "--read", "sim"]) == 0
    said = capsys.readouterr().out
    assert "Before: the flow did not become steady" in said
    assert "The coarser mesh was not solved" in said
    assert "+- 0" not in said.split("Linear")[0]


SOLVER = """#!/bin/sh
# Stands in for the solver: pressures that settle, until it is told to stop.
echo "solving $1"
{begin}
mkdir results
step=0
while [ $step -lt 400 ]; do
  step=$((step + 10))
  k=$((step - 10))
  while [ $k -lt $step ]; do
    k=$((k + 1)); echo " $k   0.1  100.0 1.0 0.0" >> results/B_NS_Pressure_average.txt
  done
  [ -e STOP_SIM ] && break
  sleep 0.05
done
cp {results}/$(basename "$PWD")-$(basename "$(dirname "$PWD")").vtu results/result_400.vtu
echo "stopped at $step"
"""


def solver_in(folder, monkeypatch, begin=":"):
    """A program of the solver's name on the PATH, which leaves exact solutions."""
    results = folder / "results"
    results.mkdir()
    for case, where in (("", "sim"), ("coarse", "coarse")):
        for name, radius in (("before", straight), ("after", radius_after)):
            write_result(folder / "sim" / case / name, radius)
            made = folder / "sim" / case / name / "results"
            shutil.move(made / "result_010.vtu", results / f"{name}-{where}.vtu")
            made.rmdir()
    path = folder / "bin" / "svmultiphysics"
    path.parent.mkdir()
    path.write_text(SOLVER.format(begin=begin, results=results), encoding="utf-8")
    path.chmod(0o755)
    monkeypatch.setenv("PATH", f"{path.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PAUSE", "0.05")


@pytest.mark.skipif(os.name == "nt", reason="the solver's script is one of a Unix shell")
def test_a_solver_on_the_path_is_run_stopped_when_steady_and_told(
    folder, prepared, monkeypatch, capsys
):
    solver_in(folder, monkeypatch)
    shutil.rmtree("sim")
    monkeypatch.setattr(commands, "prepare", lambda *_, **__: prepared[1])
    assert simulate("--processes", "1", "--report", "out.html") == 0
    said = capsys.readouterr().out
    assert "drop of total pressure to outlet" in said
    assert Path("out.html").is_file()
    for case in ("before", "coarse/after"):
        log = Path("sim", case, "solver.log").read_text(encoding="utf-8")
        assert log.startswith("solving solver.xml")
        assert int(log.split()[-1]) < 400
        assert int(Path("sim", case, "STOP_SIM").read_text(encoding="utf-8")) % 10 == 0
    # What took hours is not written over.
    assert simulate() == 2
    assert "which would be lost" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="the solver's script is one of a Unix shell")
def test_a_solver_that_dies_is_a_sentence_and_its_log_is_kept(
    folder, prepared, monkeypatch, capsys
):
    solver_in(folder, monkeypatch, begin="echo 'the linear solver gave up' >&2; exit 3")
    shutil.rmtree("sim")
    monkeypatch.setattr(commands, "prepare", lambda *_, **__: prepared[1])
    assert simulate("--processes", "1", "--json", "out.json") == 2
    said = capsys.readouterr().err
    assert "it said last: the linear solver gave up. Its log is" in said
    assert "gave up" in Path("sim/before/solver.log").read_text(encoding="utf-8")
    assert not Path("out.json").exists()
    assert not Path("sim/after/solver.log").exists()


def test_mmg_is_found_where_an_application_embeds_python(monkeypatch):
    monkeypatch.setattr(sys, "executable", "")
    monkeypatch.setenv("PATH", "")
    assert Path(_program("mmgs")).is_file()


def test_missing_meshers_are_named_before_anything_is_done(folder, monkeypatch, capsys):
    monkeypatch.setattr("SDFStentLib.simulation.mmg.shutil.which", lambda *_, **__: None)
    assert simulate("--no-run", out="new") == 2
    assert "expected MMG" in capsys.readouterr().err
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    monkeypatch.setattr("SDFStentLib.simulation.tetrahedra.find_spec", lambda _: None)
    assert simulate("--no-run", out="new") == 2
    assert "pip install 'sdfstent[mesh]'" in capsys.readouterr().err
    assert not Path("new").exists()


def test_a_damaged_volume_is_a_sentence():
    points = np.eye(4, 3)
    data = encode_vtu(points, np.array([[0, 1, 2, 3]]), {"Pressure": np.arange(4.0)}, {})
    found = decode_vtu(data, "mesh")
    np.testing.assert_array_equal(found.points, points)
    np.testing.assert_array_equal(found.tetrahedra, [[0, 1, 2, 3]])
    np.testing.assert_array_equal(found.arrays["Pressure"], np.arange(4.0))
    with pytest.raises(InputError, match="its end is missing"):
        decode_vtu(data[:-40], "mesh")
    with pytest.raises(InputError, match="expected tetrahedra, got other cells"):
        decode_vtu(data.replace(b'NumberOfCells="1"', b'NumberOfCells="2"'), "mesh")
    with pytest.raises(InputError, match="expected UnstructuredGrid"):
        decode_vtu(encode_vtp(polydata_from_arrays(points, [[0, 1, 2]])), "mesh")
