"""Triangles that lost their height, one-sided surfaces and narrow lumens, as the command tells."""

import json

import numpy as np
import pytest
from mesh_files import octahedron, open_tube
from tube_files import write_line, write_wall

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.files import read_surface

ALONG_CAPS = ["--diameter", "8.6", "--tissue-gap", "0", "--capsule", "20"]
"""A straight capsule pushes points of a cap out along rays, some of them to one place."""


def heights(surface):
    """Height (m,) of every triangle and its longest edge, one after the other, mm."""
    found = []
    for a, b, c in surface.points[surface.triangles]:
        longest = max(np.linalg.norm(a - b), np.linalg.norm(b - c), np.linalg.norm(c - a))
        found.append((np.linalg.norm(np.cross(b - a, c - a)) / longest, longest))
    return np.array(found).T


def write(path, points, triangles):
    write_wall(path, np.asarray(points, np.float32), np.asarray(triangles))


def strip(turns, count=24):
    """A strip round a circle: 0 half turns are a ring, 1 a Moebius strip."""
    angle = 2 * np.pi * np.arange(count) / count
    across = np.array([-1.0, 1.0])[:, None] * np.cos(turns * angle / 2)
    along = 9 + across
    z = np.array([-1.0, 1.0])[:, None] * np.sin(turns * angle / 2)
    if not turns:
        along, z = np.full((2, count), 9.0), np.repeat([[-1.0], [1.0]], count, axis=1)
    points = np.stack([along * np.cos(angle), along * np.sin(angle), z], axis=-1).reshape(-1, 3)
    i = np.arange(count)
    j = (i + 1) % count
    if turns % 2:
        low, high = np.where(j == 0, count, j), np.where(j == 0, 0, j + count)
    else:
        low, high = j, j + count
    return points, np.r_[np.c_[i, low, high], np.c_[i, high, i + count]]


@pytest.fixture(scope="module")
def coarse_tube(tmp_path_factory):
    folder = tmp_path_factory.mktemp("coarse")
    vessel = stenosed_tube(edge_length=1.5)
    write(folder / "tube.vtp", vessel.points, vessel.triangles)
    line = vessel.centerline.points
    write_line(folder / "axis.vtp", line)
    return folder


@pytest.mark.parametrize("more", [[], ["--length", "20"], ["--rule", "published"]])
def test_no_certified_surface_has_a_triangle_that_lost_its_height(shell, coarse_tube, more):
    run = shell(
        "deploy", "tube.vtp", "--axis", "axis.vtp", *ALONG_CAPS, *more,
        "-o", "out.vtp", "--report", "out.json", folder=coarse_tube,
    )  # fmt: skip
    found = json.loads((coarse_tube / "out.json").read_text(encoding="utf-8"))["certificate"]
    height, longest = heights(read_surface(coarse_tube / "out.vtp").surface)
    without = np.flatnonzero(height <= 1e-4 * longest)
    assert run.returncode == (3 if len(without) else 0), run.stderr
    assert found["degenerate_triangles"] == without.tolist()
    if len(without):
        assert f"{len(without)} triangle" in run.stdout
        assert "newly without height" in run.stdout
        assert "mm" in found["sentence"]


def smallest_angles(surface):
    """Of every triangle, by the law of cosines, degrees."""
    corners = surface.points[surface.triangles]
    a, b, c = (np.linalg.norm(corners[:, k] - corners[:, k - 2], axis=1) for k in range(3))
    cosines = [(x**2 + y**2 - z**2) / (2 * x * y) for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
    return np.rad2deg(np.arccos(np.clip(cosines, -1, 1))).min(axis=0)


def test_triangles_that_became_slivers_are_counted_with_the_place_of_the_worst(shell, coarse_tube):
    run = shell(
        "deploy", "tube.vtp", "--axis", "axis.vtp", *ALONG_CAPS, "--verbose",
        "-o", "out.vtp", "--report", "out.json", folder=coarse_tube,
    )  # fmt: skip
    report = json.loads((coarse_tube / "out.json").read_text(encoding="utf-8"))
    named = report["certificate"]["new_slivers"]
    after = read_surface(coarse_tube / "out.vtp").surface
    angles = smallest_angles(after)
    was = smallest_angles(read_surface(coarse_tube / "tube.vtp").surface)
    new = np.flatnonzero((angles < 1) & (angles <= was / 2))
    assert named["triangle_ids"] == new.tolist()
    assert len(new) > 0
    worst = int(new[angles[new].argmin()])
    np.testing.assert_allclose(named["worst_deg"], angles[worst], rtol=1e-3)
    np.testing.assert_allclose(named["worst_before_deg"], was[worst], rtol=1e-3)
    place = after.points[after.triangles[worst]].mean(axis=0)
    np.testing.assert_allclose(named["worst_at_mm"], place, atol=1e-3)
    (told,) = [one for one in report["warnings"] if "became slivers" in one]
    assert f": {len(new)}, the worst from {was[worst]:.2g} to {angles[worst]:.2g} degrees" in told
    assert one_line(told) in one_line(run.stderr)


def one_line(text):
    return " ".join(text.split())


SOUND, WARNED, FAULTY = 0, 0, 3


@pytest.mark.parametrize(
    ("mesh", "code", "words", "silent"),
    [
        (strip(1), FAULTY, "one-sided", "wound against"),
        (strip(0), SOUND, "no self-intersection", "one-sided"),
        (strip(2), SOUND, "no self-intersection", "one-sided"),
        (strip(3), FAULTY, "one-sided", "wound against"),
    ],
    ids=["moebius", "ring", "twice", "thrice"],
)  # fmt: skip
def test_check_tells_whether_a_surface_has_two_sides(shell, tmp_path, mesh, code, words, silent):
    write(tmp_path / "mesh.vtp", *mesh)
    run = shell("check", "mesh.vtp", folder=tmp_path)
    assert run.returncode == code, run.stdout
    assert words in run.stdout
    assert silent not in run.stdout
    document = json.loads(shell("check", "mesh.vtp", "--json", folder=tmp_path).stdout)
    assert document["orientable"] == (words != "one-sided")
    assert document["passed"] == (code == 0)


def _with_apex_at(height):
    """A sphere with a triangle whose apex lies so far from the opposite side, over that."""
    points, triangles = octahedron(radius=9.0)
    a, b = points[triangles[0][:2]]
    inward = points[triangles[0][2]] - (a + b) / 2
    inward *= height * np.linalg.norm(b - a) / np.linalg.norm(inward)
    middle = len(points)
    first = triangles[0]
    # The first triangle is cut into three round a point that lies next to one of its sides.
    cut = [[first[k], first[(k + 1) % 3], middle] for k in range(3)]
    return np.vstack([points, (a + b) / 2 + inward]), np.vstack([triangles[1:], cut])


@pytest.mark.parametrize(
    ("height", "code", "words"),
    [
        (2e-5, FAULTY, "1 triangle without height"),
        (2e-3, WARNED, "warning: Triangles with an angle below 1 degree: 1, the worst 0."),
        (5e-2, SOUND, "no self-intersection"),
    ],
)
def test_check_tells_slivers_from_triangles_without_height(shell, tmp_path, height, code, words):
    write(tmp_path / "mesh.vtp", *_with_apex_at(height))
    run = shell("check", "mesh.vtp", folder=tmp_path)
    assert run.returncode == code, run.stdout
    assert words in one_line(run.stdout)
    document = json.loads(shell("check", "mesh.vtp", "--json", folder=tmp_path).stdout)
    assert document["passed"] == (code == 0)
    if code == 0:
        assert ("below 1 degree" in " ".join(document["warnings"])) == ("degree" in words)


NARROW = ["--center", "2.533416986465454", "3.3830726146698", "-9.024898529052734",
          "--diameter", "19.056", "--length", "25.27"]  # fmt: skip


@pytest.mark.parametrize(
    ("more", "is_told"),
    [
        ([], False),
        (["--tissue-gap", "0"], True),
        (["--capsule", "5", "--foreshortening", "0"], True),
    ],
)
def test_a_lumen_that_is_noticeably_too_narrow_is_told_with_its_place(
    shell, data_dir, tmp_path, more, is_told
):
    run = shell(
        "deploy", data_dir / "aorta_iliac_surface_cm.vtp", "--units", "cm",
        "--centerline", data_dir / "aorta_iliac_centerline_cm.vtp", *NARROW, *more, "--verbose",
        "-o", "out.vtp", "--report", "out.json", folder=tmp_path,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    report = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    told = [w for w in report["warnings"] if "narrower than prescribed" in w]
    (lumen,) = report["certificate"]["lumen"]
    short = max(
        1 - lumen["narrowest_mm"] / lumen["prescribed_mm"],
        lumen["wall"]["inside_mm"] / lumen["wall"]["prescribed_radius_mm"],
    )
    assert (short > 0.015) == is_told
    assert len(told) == is_told
    as_prescribed = "its lumen is nowhere more than 1.5 % narrower than prescribed"
    assert (as_prescribed in report["certificate"]["sentence"]) != is_told
    if is_told:
        assert f"{100 * short:.1f} %" in told[0]
        assert f"{100 * short:.1f} % narrower" in report["certificate"]["sentence"]
        assert "narrower than prescribed" in one_line(run.stderr)


@pytest.mark.parametrize("kind", ["moebius", "turned"])
def test_a_certificate_tells_of_winding_that_the_input_had(shell, tmp_path, kind):
    points, triangles = open_tube(radius=4.0, length=40.0)
    if kind == "turned":
        triangles = triangles.copy()
        triangles[5] = triangles[5][::-1]
        words = "1 of its triangles is wound against their neighbors, as before"
    else:
        strip_points, strip_triangles = strip(1)
        triangles = np.vstack([triangles, strip_triangles + len(points)])
        points = np.vstack([points, strip_points * 2 + [0, 0, 20]])
        words = "one-sided"
    write(tmp_path / "tube.vtp", points, triangles)
    write_line(tmp_path / "axis.vtp", [[0, 0, 10], [0, 0, 30]])
    run = shell(
        "deploy", "tube.vtp", "--axis", "axis.vtp", "--diameter", "9", "-o", "out.vtp",
        "--report", "out.json", folder=tmp_path,
    )  # fmt: skip
    assert run.returncode == 3, run.stderr
    assert words in run.stdout
    found = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))["certificate"]
    assert words in found["sentence"]
    assert found["orientable"] == (kind == "turned")
    assert not found["consistently_wound"]
