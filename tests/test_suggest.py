"""A proposal for a lesion: sizes by a named rule, ratios, and the plan of it."""

import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from test_devices import ROW, a_device, a_table

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.cli import main
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import DiameterProfile
from SDFStentLib.plan import load_plan, run_plan
from SDFStentLib.report import ratio_sentence
from SDFStentLib.stent import Stent, stent_axis
from SDFStentLib.treatment import SizingWishes, Vessel, placement_at, suggested
from SDFStentLib.treatment.placing import beside_lesion, healthy_vessel, uncovered_length
from SDFStentLib.treatment.ratios import size_ratios
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import HealthyPlace, Lesion

SUGGEST = ["suggest", "tube.vtp", "--units", "cm", "--centerline", "line.vtp"]


def a_lesion_of(proximal, distal, minimum=4.0):
    """With healthy vessel of these diameters on its sides, None for an unknown one."""
    proximal, distal = (
        None if diameter is None else HealthyPlace((0.0, 0.0, 0.0), 0.0, diameter, lambda: math.nan)
        for diameter in (proximal, distal)
    )
    known = [one.diameter for one in (proximal, distal) if one]
    return Lesion(
        branch=0,
        branch_name="branch 1",
        branch_arc_length=10.0,
        arc_length=10.0,
        start=5.0,
        end=15.0,
        point=(1.0, 2.0, 10.0),
        minimum_diameter=minimum,
        reference_diameter=8.0,
        percent_diameter=100 * (1 - minimum / 8),
        proximal=proximal,
        distal=distal,
        reference="healthy vessel proximal of it (8.0 mm)",
        line=Line([[0.0, 0.0, 5.0], [0.0, 0.0, 15.0]]),
        healthy=np.array([known[0], known[-1]]),
        diameters=np.array([math.nan, math.nan]),
        surface=Surface([[0, 0, -9], [1, 0, -9], [0, 1, -9]], [[0, 1, 2]]),
    )


@pytest.fixture(scope="module")
def a_vessel():
    """A tube of 6 mm, narrowed to 3.6."""
    tube = stenosed_tube(edge_length=0.8)
    return Vessel(tube.surface, tube.centerline)


def test_the_lumen_is_that_of_the_healthy_vessel_and_the_length_that_of_the_lesion(a_vessel):
    one = a_vessel.suggestion(1, SizingWishes())
    (lesion,) = a_vessel.lesions
    assert one.lesion is lesion
    assert one.stent.diameter == pytest.approx(6.0, abs=0.1)  # a balloon in tenths of a mm
    assert one.stent.balloon.diameter == pytest.approx(6.0 / 0.93, abs=0.1)
    assert one.ratios.stent_to_adjacent == pytest.approx(1.0, abs=0.01)
    assert one.ratios.balloon_to_stenosis == pytest.approx(6.45 / 3.6, abs=0.05)
    assert one.stent.length == int(one.stent.length)
    assert 0 <= one.deployed_length - lesion.length < 1
    assert list(one.cautions()) == []
    # It lies over the lesion, as found by the tube's own shape: narrowest at z = 20.
    axis = stent_axis(one.stent, a_vessel.centerline).points
    assert axis[:, 2].mean() == pytest.approx(20, abs=0.5)


def test_in_a_tight_lesion_the_balloon_is_about_a_tenth_wider_than_the_vessel():
    """As the source of the rule advises, without a rule of its own for it."""
    tube = stenosed_tube(throat_radius=1.2, edge_length=0.8)
    one = Vessel(tube.surface, tube.centerline).suggestion(1, SizingWishes())
    assert one.lesion.minimum_diameter < 3
    assert one.stent.balloon.recoil_fraction == 0.1
    assert one.stent.balloon.diameter / beside_lesion(one.lesion).narrowest == pytest.approx(
        1.11, abs=0.02
    )
    assert one.stent.diameter == pytest.approx(beside_lesion(one.lesion).narrowest, abs=0.05)


@pytest.mark.parametrize(
    ("lumen", "balloon", "kinds"),
    [
        (7.0, 7.5, []),
        (4.2, 4.5, []),  # 0.6, as half of the stents of the source
        (2.6, 2.8, ["ratio-adjacent"]),
        (8.3, 8.9, []),
        (8.5, 9.1, ["overdilated"]),
        (10.9, 11.7, ["overdilated"]),  # 1.56
        (7.0, 12.0, []),
        (7.0, 12.1, ["ratio-stenosis"]),
        (9.0, 13.0, ["overdilated", "ratio-stenosis"]),
        (7.0, math.nan, []),
    ],
)
def test_a_ratio_beyond_its_sources_range_is_said(lumen, balloon, kinds):
    lesion = a_lesion_of(proximal=9.0, distal=7.0, minimum=4.0)
    ratios = size_ratios(lesion, lumen, balloon)
    assert ratios.stent_to_adjacent == pytest.approx(lumen / 7.0)
    assert [caution.kind for caution in ratios.cautions()] == kinds
    for caution in ratios.cautions():
        words = "at its distal end (7.0 mm)", "above 3 the recoil"
        assert words[caution.kind == "ratio-stenosis"] in str(caution)


def test_ranges_medians_and_denominators_are_those_of_the_source():
    """Heart 2003;89:905, abstract."""
    told = ratio_sentence(size_ratios(a_lesion_of(9.0, 7.0), 6.0))
    assert told == (
        "Stent : healthy vessel 0.86 where that is narrowest (7.0 mm), 0.67 at the proximal end "
        "(9.0 mm), 0.86 at the distal end (7.0 mm). In its source: distal pulmonary artery 0.44 to "
        "1.5 (median 0.66), dilated again 0.48 to 1.88 (0.86); descending aorta 0.38 to 1.02 "
        "(median 0.66), dilated again 0.52 to 1.2 (0.85)."
    )


def a_native_lumen(*widths):
    """Along a straight axis on which the lesion of `a_lesion_of` lies from 5 to 15 mm, a station
    every mm from -5 on."""
    along = np.arange(len(widths)) - 5.0
    places = np.column_stack([np.zeros((len(along), 2)), along])
    return DiameterProfile(along, places, np.array(widths, dtype=float), np.array(widths) * 1.0)


@pytest.mark.parametrize(
    ("widths", "length", "lesions", "found"),
    [
        # The reference in the lesion, the lumen itself beside it: never the stenosis.
        ([8.0] * 10 + [4.0] * 11 + [8.0] * 10, 20.0, True, (8.0, 8.0, 8.0)),
        # Into a wide parent: the ends differ, the widest lumen says nothing.
        ([20.0] * 8 + [8.0] * 2 + [4.0] * 11 + [8.0] * 10, 20.0, True, (20.0, 8.0, 8.0)),
        # A narrower vessel behind the lesion.
        ([8.0] * 10 + [4.0] * 11 + [5.0] * 15, 25.0, True, (8.0, 5.0, 5.0)),
        # An end in the lesion: there the reference stands.
        ([8.0] * 10 + [4.0] * 11 + [8.0] * 10, 10.0, True, (8.0, 8.0, 8.0)),
        # The reference is of a wider vessel than the one beyond the end.
        ([8.0] * 10 + [4.0] * 11 + [5.0] * 10, 14.5, True, (8.0, 5.0, 5.0)),
        # Lesions were not looked for: nothing is said of the ends.
        ([6.0] * 10 + [4.0] * 11 + [8.0] * 10, 20.0, False, (math.nan, math.nan, 8.0)),
    ],
)
def test_a_stent_is_held_against_the_healthy_vessel_at_its_ends_and_where_that_is_narrowest(
    widths, length, lesions, found
):
    native = a_native_lumen(*widths)
    healthy = healthy_vessel(native, length, [a_lesion_of(8.0, 8.0)] if lesions else None)
    np.testing.assert_allclose(healthy, found, equal_nan=True)


def a_lesion_along(points, start, narrowest):
    """A lesion of a vessel that runs along z, whose points they are, 1 mm apart."""
    return replace(
        a_lesion_of(8.0, 8.0),
        line=Line(points),
        start=start,
        end=start + len(points) - 1.0,
        arc_length=narrowest,
        point=(0, 0, narrowest),
        healthy=np.full(len(points), 8.0),
    )


def a_lesion_across_a_junction():
    """It and its tree: a branch leaves at 30 mm, the lesion lies from 23 to 33."""
    main, side = np.linspace((0, 0, 0), (0, 0, 60), 61), np.linspace((1, 0, 30), (20, 0, 30), 20)
    parent = np.r_[np.arange(61) - 1, 30, np.arange(61, 80)]
    tree = Centerline(np.concatenate([main, side]), np.full(81, 3.0), parent)
    return a_lesion_along(main[23:34], 23.0, 28.0), tree


def axis_at(lesion, tree, length):
    """Of a stent of that length, which does not shorten, placed at a lesion."""
    place = placement_at(lesion, tree, length, 0.0)
    return stent_axis(Stent(8.0, placement=place, length=length, foreshortening_fraction=0), tree)


def test_a_stent_for_a_lesion_across_a_junction_warns_of_no_choice_there():
    """The branch is the lesion's; the proposal itself was warned of when it was carried out."""
    axis = axis_at(*a_lesion_across_a_junction(), 10.0)
    assert axis.warnings == ()
    np.testing.assert_allclose(axis.points[[0, -1], 2], [23, 33])


def test_a_long_stent_across_a_junction_reaches_as_far_beyond_its_lesion_on_both_sides():
    axis = axis_at(*a_lesion_across_a_junction(), 30.0)
    np.testing.assert_allclose(axis.points[[0, -1], 2], [13, 43])


@pytest.mark.parametrize("seed", range(20))
def test_a_short_stent_is_as_near_to_the_middle_as_the_narrowest_place_lets_it(seed):
    """The narrowest place lies in the middle half of the stent."""
    random = np.random.default_rng(seed)
    tree = Centerline(np.linspace((0, 0, 0), (0, 0, 60), 61), np.full(61, 4.0), np.arange(61) - 1)
    length, narrowest = random.uniform(4, 20), random.uniform(10, 40)
    lesion = a_lesion_along(tree.points[10:41], 10.0, narrowest)
    middle = axis_at(lesion, tree, length).points[[0, -1], 2].mean()
    expected = sorted([narrowest - length / 4, 25.0, narrowest + length / 4])[1]
    assert middle == pytest.approx(expected, abs=1e-6)


def test_a_device_gives_its_own_length_and_one_that_is_too_short_is_refused(a_vessel):
    """A suggestion never leaves its own lesion uncovered."""
    row = {"nominal_length": 14, "lengths": [[4, 14], [8, 13]], "name": "own"}
    one = a_vessel.suggestion(1, SizingWishes(device=a_device(**row)))
    assert one.stent.length == 14
    assert one.deployed_length == pytest.approx(14 - 0.25 * (one.stent.diameter - 4), abs=1e-9)
    assert one.deployed_length > one.lesion.length
    assert "length that of the device" in one.rule
    short = a_device(name="short", nominal_length=8, lengths=[[4, 8], [8, 6]])
    with pytest.raises(InputError, match=r"cover lesion 1, got short, which has 7\.0 mm; choose"):
        a_vessel.suggestion(1, SizingWishes(device=short))


SOLD = {"nominal_length": None, "lengths": None, "foreshortening_fraction": 0.1, "name": "sold"}


def test_a_length_is_one_that_is_sold_where_the_table_knows_them(a_vessel):
    device = a_device(**SOLD, sold_lengths=[9, 18, 29, 36])
    one = a_vessel.suggestion(1, SizingWishes(device=device))
    assert one.lesion.length > 0.9 * 9
    assert one.stent.length == 18
    assert "the shortest that is sold" in one.rule
    assert uncovered_length(one.lesion, [one.axis.line]) == 0
    with pytest.raises(InputError, match=r"got sold, which has 32\.4 mm"):
        a_vessel.suggestion(1, SizingWishes(device=device, margin=20))
    with pytest.raises(InputError, match=r"in which sold is sold \(9, 18, 29, 36 mm\), got 20 mm"):
        replace(one.stent, length=20.0)
    with pytest.raises(InputError, match="sold_lengths: expected rising lengths, each once"):
        a_device(**SOLD, sold_lengths=[18, 9])
    with pytest.raises(InputError, match="sold_lengths: expected none beside a nominal_length"):
        a_device(**{**SOLD, "nominal_length": 9}, sold_lengths=[9, 18])


def test_a_stent_that_is_long_enough_covers_a_lesion_that_is_narrowest_at_one_end(a_vessel):
    """It is not moved to the narrowest place, as a shorter one is."""
    (lesion,) = a_vessel.lesions
    aside = replace(lesion, arc_length=lesion.start + 0.5)
    for length_mm, left in ((math.ceil(lesion.length), 0.0), (6.0, lesion.length - 6.0)):
        place = placement_at(aside, a_vessel.centerline, length_mm, 0.0)
        stent = Stent(6.0, placement=place, length=length_mm, foreshortening_fraction=0.0)
        axis = stent_axis(stent, a_vessel.centerline).line
        assert uncovered_length(lesion, [axis]) == pytest.approx(left, abs=1.6 * (left > 0))


def test_an_axis_covers_a_lesion_only_within_its_healthy_lumen(a_vessel):
    """A stent in a vessel beside it would count as its own up to two diameters away."""
    (lesion,) = a_vessel.lesions
    healthy = float(lesion.healthy.max())
    beside = np.cross(lesion.line.directions[0], [0.3, -0.5, 0.8])
    beside *= healthy / np.linalg.norm(beside)
    inside, outside = (Line(lesion.line.points + away * beside) for away in (0.2, 0.9))
    assert uncovered_length(lesion, [inside]) < 0.3 * lesion.length
    assert uncovered_length(lesion, [outside]) == pytest.approx(lesion.length)


def test_the_rule_names_what_is_rounded_and_what_is_wanted(a_vessel):
    """The numbers that it speaks of are those of the proposal."""
    wished = a_vessel.suggestion(1, SizingWishes(ratio=0.9, margin=2.5))
    recoil = wished.stent.balloon.recoil_fraction
    wanted = 0.9 * wished.ratios.adjacent_diameter / (1 - recoil)
    assert wished.stent.balloon.diameter == round(wanted, 1) != wanted
    nominal = (wished.lesion.length + 5) / (1 - wished.stent.foreshortening)
    assert wished.stent.length == math.ceil(nominal) != nominal
    assert wished.rule == (
        "lumen 0.9 times as wide as the smaller healthy vessel beside the lesion, balloon wider by "
        "its recoil, rounded to the nearest 0.1 mm, length that of the lesion and 2.5 mm beyond "
        "both of its ends, longer by what shortening takes, rounded up to whole mm"
    )


@pytest.mark.parametrize("name", ["pulmonary", "aorta_iliac"])
def test_in_anatomies_the_proposed_stent_covers_its_lesion(data_dir, name):
    assert name in ANATOMIES
    found = anatomy(data_dir, name)
    vessel = Vessel(found.surface, found.centerline)
    for number, lesion in enumerate(vessel.lesions[:3], start=1):
        one = suggested(lesion, number, found.centerline, SizingWishes())
        sides = [side.diameter for side in (lesion.proximal, lesion.distal) if side]
        assert one.stent.diameter == pytest.approx(min(sides), abs=0.05)
        axis = stent_axis(one.stent, found.centerline).points
        assert Line(axis).length >= lesion.length - 1e-6
        # Both ends of the lesion lie beside the stent, not beyond it.
        for end in lesion.line.points[[0, -1]]:
            assert np.linalg.norm(axis - end, axis=1).min() < 1.5


# ---- the shell


def test_the_command_that_suggest_tells_can_be_typed_whatever_the_plan_is_called(a_folder, capsys):
    assert main([*SUGGEST, "-o", "its own plan.json"]) == 0
    said = capsys.readouterr().out
    command = shlex.split(said.split("to carry it out: ")[1])
    assert command == ["sdfstent", "run", "its own plan.json", "-o", "DIR"]


def test_suggest_tells_the_rule_and_writes_a_plan_that_runs(a_folder, capsys):
    assert main(SUGGEST) == 0
    said = capsys.readouterr().out
    for words in (
        "Lesion 1: 40 % by diameter, minimum 3.5",
        "Proposed: balloon 6.4 mm, lumen 5.95 mm, nominal length ",
        "Rule: lumen as wide as the smaller healthy vessel beside the lesion, balloon wider by its "
        "recoil, rounded to the nearest 0.1 mm, length that of the lesion, longer by what "
        "shortening takes, rounded up to whole mm. ",
        "Recoil 7 %: the mean in great vessels",
        "These are sizes that the lesion asks for, of no product; in the table no row has such ",
        "Stent : healthy vessel 1.00 where that is narrowest (5.9 mm), 1.00 at the proximal end",
        " Balloon : stenosis 1.8",
        "Wrote tube_plan.json; to carry it out: sdfstent run tube_plan.json -o DIR",
    ):
        assert words in said, words
    result = run_plan(load_plan("tube_plan.json"))
    assert result.treatment.certificate.passed
    (stent,) = result.treatment.stents
    assert stent.stent.name == "lesion 1"
    (lesion,) = result.lesions
    assert lesion.stents == (1,)
    assert lesion.after.percent_diameter < 5
    assert main(["run", "tube_plan.json", "-o", "out", "--quiet"]) == 0
    (told,) = json.loads(Path("out/report.json").read_text(encoding="utf-8"))["stents"]
    assert told["stent_to_adjacent"] == pytest.approx(1.0, abs=0.01)
    assert told["balloon_to_stenosis"] == pytest.approx(1.8, abs=0.05)
    page = Path("out/report.html").read_text(encoding="utf-8")
    assert "<td>Stent : healthy vessel where that is narrowest</td><td>1.0" in page


def test_suggest_prints_json_and_takes_a_device(a_folder, capsys):
    row = {**ROW, "name": "own", "nominal_length": 16, "lengths": [[4, 16], [8, 12]]}
    Path("own.json").write_text(a_table(row), encoding="utf-8")
    more = ["--device", "own", "--device-table", "own.json", "-o", "p.json", "--json"]
    assert main([*SUGGEST, *more]) == 0
    (one,) = json.loads(capsys.readouterr().out)["suggestions"]
    assert (one["lesion"], one["device"], one["nominal_length_mm"]) == (1, "own", 16)
    assert one["deployed_length_mm"] == pytest.approx(16 - (one["lumen_diameter_mm"] - 4))
    (stent,) = load_plan("p.json").stents
    assert (stent.device.name, stent.length) == ("own", 16)
    assert stent.diameter == one["lumen_diameter_mm"]


def deployed_in_the_tube(capsys, *options):
    """What is said of a stent at the throat of the tube of 6 mm, and its warnings."""
    more = ["--center", "0", "0", "2", "--length", "12", "-o", "o.vtp", "--report", "r.json"]
    more.append("--verbose")
    assert main(["deploy", *SUGGEST[1:], *more, *options]) == 0
    warnings = json.loads(Path("r.json").read_text(encoding="utf-8"))["warnings"]
    told = capsys.readouterr()
    assert all(sentence in told.err for sentence in warnings)
    ratios = ("times as wide as the healthy", "the recoil was")
    return told.out, [one for one in warnings if any(words in one for words in ratios)]


def test_ratios_beyond_their_sources_are_warned_of(a_folder, capsys):
    out, warnings = deployed_in_the_tube(capsys, "--balloon", "11", "--recoil", "0.2")
    wide, tight = warnings
    lumen, balloon = (float(re.findall(r"is (\S+) times as wide", one)[0]) for one in warnings)
    assert lumen == pytest.approx(8.8 / 6.0, abs=0.03)
    assert balloon == pytest.approx(11 / 3.6, abs=0.06)
    assert f"Stent : healthy vessel {lumen:.2f} where that is narrowest (5.9 mm)" in out
    assert "In coarctations its source had at most 1.02, and 1.2 dilated again" in wide
    assert tight.endswith("above 3 the recoil was more than 10 %.")
