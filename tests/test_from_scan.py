"""From a segmentation to a certified stent and its report, with what half a voxel makes of it."""

import json
import math

import pytest
from segmentations import named, voxels, write

from SDFStentLib.files import read_surface
from SDFStentLib.flow import known_flow
from SDFStentLib.plan import Plan, case_of, read_input_files, run_plan
from SDFStentLib.report import voxel_facts
from SDFStentLib.scan import Ranged, VoxelRange, treated_voxel_range, voxel_range
from SDFStentLib.stent import AtCenter, AtLesion, InputFile, Stent
from SDFStentLib.validation import InputError

SIDE = 0.6
"""Of the voxels, mm."""

NARROWED = [
    ((0, 0, 0), (0, 0, 26), 4, 4),
    ((0, 0, 26), (0, 0, 36), 4, 2),
    ((0, 0, 36), (0, 0, 46), 2, 4),
    ((0, 0, 46), (0, 0, 66), 4, 4),
    ((0, 0, 66), (11, 0, 90), 3, 3),
    ((0, 0, 66), (-11, 0, 90), 2.6, 2.6),
]
"""A trunk that is half as wide in one place, and parts in two, mm."""

FILES = ("made/surface.vtp", "--centerline", "made/centerline.vtp")


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    """A folder with a segmentation, from which the vessel was prepared."""
    from SDFStentLib.cli import main

    folder = tmp_path_factory.mktemp("scan")
    mask, low = voxels(NARROWED, SIDE)
    scan = write(folder / "scan.seg.nrrd", mask, low, SIDE, texts=named(artery=(1, 0)))
    assert main(["prepare", str(scan), "-o", str(folder / "made"), "--quiet"]) == 0
    return folder


def paths_of(folder):
    return [folder / "made" / name for name in ("surface.vtp", "centerline.vtp")]


def span_of(document, key, state):
    (low, high) = document["voxel_range"][key][0][state]
    return low, high


def test_a_segmentation_comes_to_a_certified_stent_and_a_report_by_commands(scanned, shell):
    sizes = ("--at-lesion", 1, "--diameter", 7.5, "--length", 24, "--mean-flow", "3L/min")
    outputs = ("-o", "out.vtp", "--report", "r.json", "--report", "r.html")
    done = shell("deploy", *FILES, *sizes, *outputs, "--voxel-range", folder=scanned)
    assert done.returncode == 0, done.stderr
    assert "Surface certified for meshing" in done.stdout
    assert "in or out, narrowest lumen: stent 1 " in done.stdout
    assert shell("check", "r.json", folder=scanned).returncode == 0
    assert "half a voxel (0.30 mm) in or out" in (scanned / "r.html").read_text(encoding="utf-8")
    document = json.loads((scanned / "r.json").read_text(encoding="utf-8"))
    # A throat of 4 mm in a vessel of 8: a wall that is moved by h makes it 2 h wider or narrower.
    low, high = span_of(document, "minimum_lumens_mm", "before")
    assert low < 4 < high
    assert high - low == pytest.approx(2 * SIDE, abs=0.1)
    narrowest = low, high
    # What the stent prescribes does not depend on where the wall was.
    assert span_of(document, "minimum_lumens_mm", "after") == pytest.approx((7.5, 7.5), abs=0.02)
    low, high = span_of(document, "diameter_stenoses_percent", "before")
    assert low < 50 < high
    # The reference is wider or narrower, too: by itself the throat would make a wider range.
    assert pytest.approx(100 - high, abs=1) == 100 * narrowest[0] / (8 - SIDE)
    assert pytest.approx(100 - low, abs=1) == 100 * narrowest[1] / (8 + SIDE)
    drops = document["voxel_range"]["pressure_drops_mmhg"]
    assert drops[0]["name"] == "stent 1"
    low, high = drops[0]["before"]
    assert 1.5 * low < high
    assert drops[0]["after"][1] < low


def test_ranges_are_those_of_the_lesions_that_are_listed():
    spans = [Ranged(f"lesion {number}", (number, number + 1.0)) for number in (1, 2, 3)]
    lumen = (Ranged("stent 1", (4.0, 5.0), (6.0, 6.0)),)
    found = VoxelRange(0.3, tuple(spans), tuple(spans), lumen).of_lesions([3, 1])
    assert found == VoxelRange(0.3, (spans[2], spans[0]), (spans[2], spans[0]), lumen)


def test_measure_tells_the_range_where_it_is_asked_for(scanned, shell):
    plain = shell("measure", *FILES, "--json", folder=scanned)
    assert "voxel_range" not in json.loads(plain.stdout)
    document = json.loads(
        shell("measure", *FILES, "--json", "--voxel-range", folder=scanned).stdout
    )
    assert document["voxel_range"]["half_voxel_mm"] == pytest.approx(SIDE / 2)
    minimum = document["lesions"][0]["minimum"]["diameter_mm"]
    low, high = span_of(document, "minimum_diameters_mm", "before")
    assert low < minimum < high
    assert document["voxel_range"]["minimum_diameters_mm"][0]["after"] is None


def test_where_no_voxels_are_known_the_range_is_refused(a_folder, shell):
    done = shell(
        "measure", "tube.vtp", "--centerline", "line.vtp", "--voxel-range", folder=a_folder
    )
    assert done.returncode == 2
    assert "expected a surface that knows its voxels" in done.stderr


def test_voxels_are_in_the_unit_of_the_file(scanned):
    path = scanned / "made" / "surface.vtp"
    assert read_surface(path).half_voxel == pytest.approx(SIDE / 2)
    assert read_surface(path, "cm").half_voxel == pytest.approx(10 * SIDE / 2)


def test_walls_that_meet_leave_no_lumen(scanned):
    """A throat of 4 mm whose walls come nearer by more than 2 mm each."""
    vessel = read_input_files(*paths_of(scanned)).vessel
    found = voxel_range(vessel, 2.4)
    assert found.minima[0].before[0] == 0
    assert found.stenoses[0].before[1] == 100


def test_where_half_a_voxel_closes_a_lumen_no_stent_has_a_range(scanned):
    surface, line = map(str, paths_of(scanned))
    stent = Stent(7.5, placement=AtLesion(1), length=24)
    result = run_plan(Plan((stent,), InputFile(surface), InputFile(line)))
    with pytest.raises(InputError, match=r"wider than a voxel, 4\.80 mm, .* got 4\.\d\d mm"):
        treated_voxel_range(case_of(result.plan, result.inputs), result, 2.4)


def test_where_half_a_voxel_closes_an_outlet_all_but_the_pressure_has_its_range(scanned):
    """As of the twigs of a scan: no range at all was known for them."""
    surface, line = map(str, paths_of(scanned))
    stent = Stent(8.5, placement=AtCenter((0, 0, 13)), length=10)
    plan = Plan((stent,), InputFile(surface), InputFile(line), flow=known_flow(50.0))
    result = run_plan(plan)
    case, half = case_of(result.plan, result.inputs), 2.7
    found = treated_voxel_range(case, result, half, result.flow)
    ((low, high),) = (one.before for one in found.lumens)
    assert high - low == pytest.approx(4 * half, rel=0.1)
    assert found.minima[0].before[0] == 0
    assert [one.name for one in found.drops] == list(result.flow.parts)
    assert all(map(math.isnan, found.drops[0].before))
    (told,) = (one for one in voxel_facts(found).sentences if "pressure" in one)
    assert told.endswith("recovered pressure drop: not known, as that closes a vessel.")


def test_of_a_range_without_stenosis_none_is_told():
    """A lumen that is wider than the healthy vessel has no stenosis below nothing."""
    found = VoxelRange(
        0.2,
        (Ranged("lesion 1", (2.21, 3.004), (6.6, 6.6)),),
        (
            Ranged("lesion 1", (57.1, 64.4), (-6.5, 5.7)),
            Ranged("lesion 2", (30.2, 31.0), (-3.0, 0.2)),
        ),
        (),
        (),
    )
    minima, stenoses = voxel_facts(found).sentences
    assert minima.endswith("minimum diameter: lesion 1 2.21 to 3.00 -> 6.60 mm.")
    assert stenoses.endswith(
        "stenosis by diameter: lesion 1 57 % to 64 % -> none to 6 %; lesion 2 30 % to 31 % -> none."
    )
