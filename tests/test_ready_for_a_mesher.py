"""What was never fit for a mesher is not certified, whatever a stent leaves as it was."""

import json
import re

import numpy as np
import pytest
from cohort_cases import document as sweep_document
from tube_files import plan_of, write_tube, write_wall

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.certificate import (
    CERTIFIED,
    CERTIFIED_OPEN,
    NOT_CERTIFIED,
    NOT_READY,
    certify,
    check_surface,
)
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.report import measured_lines, result_tiles
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment


@pytest.fixture(scope="module")
def vessel():
    return stenosed_tube(edge_length=1.2)


def twice(points, triangles, random):
    some = random.integers(len(triangles), size=3)
    return points, np.vstack([triangles, triangles[some]])


def fin(points, triangles, random):
    """A triangle more at an edge that has two."""
    first, second, _ = triangles[random.integers(len(triangles))]
    out = points[[first, second]].mean(axis=0) * [1.6, 1.6, 1.0]
    return np.vstack([points, out]), np.vstack([triangles, [first, second, len(points)]])


def turned(points, triangles, random):
    triangles = triangles.copy()
    some = random.permutation(len(triangles))[: random.integers(1, len(triangles) // 3)]
    triangles[some] = triangles[some, ::-1]
    return points, triangles


def pierced(points, triangles, random):
    """A needle through the wall, closed in itself."""
    center = points[triangles[random.integers(len(triangles))]].mean(axis=0)
    out = center * [1.0, 1.0, 0.0]
    corners = np.array([out * 0.15, -out * 0.15, [0.1, 0, 0], [0, 0, 0.13]]) + center
    needle = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    return np.vstack([points, corners]), np.vstack([triangles, needle + len(points)])


def flat(points, triangles, random):
    """A triangle cut by a corner on its side: one of the two has no height."""
    face = random.integers(len(triangles))
    first, second, third = triangles[face]
    middle = points[[first, second]].mean(axis=0)
    number = len(points)
    two = [[first, number, third], [number, second, third], [first, second, number]]
    return np.vstack([points, middle]), np.vstack([np.delete(triangles, face, axis=0), two])


FAULTS = {
    "manifold": (twice, fin),
    "wound one way": (turned,),
    "free of self-intersections": (twice, pierced),
    "free of triangles without height": (flat,),
}
"""By what is missing then."""


class AtAnEnd:
    """Draws faces far from the stent, which a stent does not mend by moving them."""

    def __init__(self, seed, vessel):
        self._random = np.random.default_rng(seed)
        height = vessel.surface.points[vessel.surface.triangles].mean(axis=1)[:, 2]
        self._faces = np.flatnonzero(np.abs(height - 20) > 16)

    def integers(self, low, high=None, size=None):
        if high is not None:
            return self._random.integers(low, high)
        return self._random.choice(self._faces, size)

    def permutation(self, count):
        return self._random.permutation(count)


def stented(points, triangles, vessel, diameter=8.0):
    chain = DeploymentSettings().chain(Line(vessel.centerline.points).cut(14, 26))
    return Deployment(Surface(points, triangles), chain, diameter / 2).result


@pytest.mark.parametrize(
    ("missing", "spoil"), [(name, one) for name, some in FAULTS.items() for one in some]
)
@pytest.mark.parametrize("seed", [501, 502])
def test_a_fault_of_the_input_is_not_certified_wherever_it_is(vessel, missing, spoil, seed):
    random = AtAnEnd(seed, vessel)
    points, triangles = spoil(vessel.surface.points, vessel.surface.triangles, random)
    certificate = stented(points, triangles, vessel).certificate
    assert certificate.is_no_worse
    assert not certificate.passed
    assert certificate.word == NOT_READY
    assert missing in certificate.fitness.missing
    assert certificate.sentence().startswith(f"Surface {NOT_READY}: it is ")
    assert "certified" not in certificate.sentence()
    told = certificate.as_dict()
    assert (told["passed"], told["no_worse_than_before"], told["ready_for_meshing"]) == (
        False, True, False,
    )  # fmt: skip
    assert missing in told["missing_for_meshing"]


@pytest.mark.parametrize("seed", range(510, 516))
def test_what_is_certified_is_what_the_whole_of_the_result_shows(vessel, seed):
    """By a look at all faces of the result, which knows of no input."""
    random = np.random.default_rng(seed)
    points, triangles = vessel.surface.points, vessel.surface.triangles
    for spoil in random.permutation([one for some in FAULTS.values() for one in some])[:2]:
        if random.random() < 0.6:
            points, triangles = spoil(points, triangles, random)
    result = stented(points, triangles, vessel, random.uniform(6, 9))
    check = check_surface(result.surface)
    fitness = result.certificate.fitness
    for name in ("self_intersecting_triangles", "degenerate_triangles", "flipped_triangles"):
        found = fitness.flipped_triangles if "flipped" in name else None
        found = fitness.faults.intersecting if "self" in name else found
        found = fitness.faults.degenerate if "degenerate" in name else found
        np.testing.assert_array_equal(found, getattr(check, name))
    assert result.certificate.passed == (check.passed and result.certificate.is_no_worse)


def test_openings_are_no_fault_but_have_to_be_closed(vessel):
    middle = vessel.surface.points[:, 2]
    is_wall = np.ptp(middle[vessel.surface.triangles], axis=1) > 1e-9
    certificate = stented(
        vessel.surface.points, vessel.surface.triangles[is_wall], vessel
    ).certificate
    assert certificate.passed
    assert certificate.word == CERTIFIED_OPEN
    assert re.match(rf"Surface {CERTIFIED_OPEN}: it is open \(\d+ b", certificate.sentence())
    assert certificate.fitness.missing == ["closed"]


def test_a_surface_that_looks_inward_can_be_meshed_and_is_told_of(vessel):
    surface = Surface(vessel.surface.points, vessel.surface.triangles[:, ::-1])
    certificate = certify(surface, surface.points * [1.01, 1.01, 1])
    assert certificate.word == CERTIFIED
    assert "its triangles face inward, as they did" in certificate.sentence()
    assert certificate.as_dict()["ready_for_meshing"]


def test_a_new_fault_is_told_first_and_what_was_not_manifold_too(vessel):
    points, triangles = twice(
        vessel.surface.points, vessel.surface.triangles, np.random.default_rng(520)
    )
    after = points.copy()
    after[points[:, 2] > points[:, 2].mean()] *= [-1, -1, 1]
    certificate = certify(Surface(points, triangles), after)
    assert certificate.word == NOT_CERTIFIED
    assert re.search(r"newly .*; it is not manifold.*, as before", certificate.sentence())


@pytest.fixture
def a_spoiled_folder(tmp_path, monkeypatch):
    """The tube of the shell's tests with three triangles twice, far from the stent."""
    write_tube(tmp_path)
    monkeypatch.chdir(tmp_path)
    surface = read_surface("tube.vtp", "cm").surface
    triangles = np.vstack([surface.triangles, surface.triangles[:3]])
    write_wall(tmp_path / "tube.vtp", np.asarray(surface.points / 10, np.float32), triangles)
    return tmp_path


def test_every_door_says_the_same_and_ends_with_3(a_spoiled_folder, shell):
    folder = a_spoiled_folder
    plan = plan_of({"diameter": 6, "length": 10, "placement": {"center": [0, 0, 2]}})
    for name in ("one", "two"):
        (folder / f"{name}.json").write_text(json.dumps(plan), encoding="utf-8")
    (folder / "sweep.json").write_text(
        json.dumps(sweep_document(axes={"diameter": [6], "branch": 1, "distance": [18]})), "utf-8"
    )
    deploy = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", "--center"]
    deploy += [0, 0, 2, "--length", 10, "--diameter", 6, "-o", "out.vtp"]
    reports = ["--report", "r.json", "--report", "r.html"]
    runs = [
        shell(*deploy, *reports, folder=folder),
        shell(*deploy, "--verbose", folder=folder),
        shell("run", "one.json", "-o", "done", folder=folder),
        shell("compare", "one.json", "two.json", "-o", "both", folder=folder),
        shell("sweep", "sweep.json", "-o", "swept", "--workers", 1, folder=folder),
    ]
    assert [run.returncode for run in runs] == [3] * len(runs)
    for run in runs[:3]:
        assert f"Surface {NOT_READY}: it is not manifold" in run.stdout
    files = ["r.html", "r.json", "done/report.html", "done/report.json"]
    files += [str(one.relative_to(folder)) for one in folder.glob("both/*.html")]
    files += [str(one.relative_to(folder)) for one in folder.glob("swept/manifest.csv")]
    assert len(files) == 6
    for name in files:
        text = (folder / name).read_text(encoding="utf-8")
        assert NOT_READY in text, name
        assert "Surface certified" not in text


def test_the_panel_tells_it_beside_the_stent_and_in_its_tile(vessel):
    points, triangles = twice(
        vessel.surface.points, vessel.surface.triangles, np.random.default_rng(521)
    )
    place = AtCenter(vessel.centerline.points.mean(axis=0))
    stent = Stent(diameter=8.0, length=20.0, placement=place)
    result = Treatment(Surface(points, triangles), [stent], vessel.centerline).result
    lines = measured_lines(result.stents[0], result.stents, None, result.certificate)
    assert lines[-1] == NOT_READY
    tile = {one.name: one for one in result_tiles(result.stents, None, result.certificate)}[
        "Surface"
    ]
    assert (tile.value, tile.beneath) == ("not ready for a mesher", "no worse than before")
    assert tile.is_caution
