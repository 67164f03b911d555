"""Pressure drops, against the formulas integrated by hand and the one case with a solver."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from scipy.integrate import quad
from test_plan import SCHEMA, a_document
from tube_files import deploy

from SDFStentLib.cli import main
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.flow import Blood, pressure_band, vessel_block
from SDFStentLib.lumen import DiameterProfile
from SDFStentLib.phantoms import straight_tube
from SDFStentLib.plan import load_plan, plan_from_document
from SDFStentLib.report import zero_d_cautions, zero_d_document
from SDFStentLib.stent import AlongAxis, OfStent, Stent
from SDFStentLib.treatment import Treatment
from SDFStentLib.validation import InputError

MMHG = 133.322


def profile(diameter, length, equivalent=None, count=401):
    """Of a diameter that is a function of the position, mm."""
    x = np.linspace(0.0, length, count)
    inscribed = np.vectorize(diameter, otypes=[float])(x)
    wide = inscribed if equivalent is None else np.vectorize(equivalent, otypes=[float])(x)
    return DiameterProfile(x, np.zeros((count, 3)), inscribed, wide)


def throat(healthy, narrow, length):
    """A smooth narrowing in the middle of a vessel."""
    return lambda x: healthy - (healthy - narrow) * np.sin(np.pi * x / length) ** 2


def by_quadrature(diameter, length, flow, blood):
    """Poiseuille and Young-Tsai, mmHg, by adaptive quadrature in SI units."""
    area = lambda x: np.pi / 4 * (1e-3 * diameter(1e3 * x)) ** 2  # noqa: E731
    q = 1e-6 * flow
    along = 8 * np.pi * blood.viscosity * q * quad(lambda x: area(x) ** -2, 0, 1e-3 * length)[0]
    healthy, narrow = area(0.0), area(0.5e-3 * length)
    behind = 1.52 * blood.density / (2 * healthy**2) * (healthy / narrow - 1) ** 2 * q**2
    return (along + behind) / MMHG


@pytest.mark.parametrize("flow", [4.15, 8.3, 200.0])
@pytest.mark.parametrize(("healthy", "narrow"), [(16.0, 8.0), (6.0, 2.6), (7.0, 6.9)])
def test_the_closed_form_is_that_of_an_adaptive_quadrature(healthy, narrow, flow):
    blood = Blood(1050.0, 0.0035)
    diameter = throat(healthy, narrow, 30.0)
    line = profile(diameter, 30.0)
    block = vessel_block(line.arc_length, line.inscribed_diameter, blood)
    q = 1e-6 * flow
    drop = (block.resistance + block.stenosis * q) * q / MMHG
    assert drop == pytest.approx(by_quadrature(diameter, 30.0, flow, blood), rel=1e-3)


def test_the_loss_behind_a_coarctation_is_that_of_the_published_example():
    """16 to 8 mm at 200 mL/s: 53.8 mmHg behind the throat, 63.3 by 4 v^2 (domain facts, 3.6)."""
    line = profile(throat(16.0, 8.0, 15.0), 15.0)
    block = vessel_block(line.arc_length, line.inscribed_diameter)
    assert block.stenosis * (200e-6) ** 2 / MMHG == pytest.approx(53.8, abs=0.1)
    band = pressure_band(line, 200.0)
    assert band.high == pytest.approx(1.66 * 63.3, rel=2e-3)
    assert band.low < 55.3 < band.high


def test_a_tube_has_the_resistance_of_poiseuille_and_the_inertance_of_its_blood():
    block = vessel_block(np.linspace(0, 26.0, 27), np.full(27, 6.0))
    radius, length = 3e-3, 26e-3
    assert block.resistance == pytest.approx(8 * 0.004 * length / (np.pi * radius**4), rel=1e-12)
    assert block.inertance == pytest.approx(1060 * length / (np.pi * radius**2), rel=1e-12)
    assert block.stenosis == 0.0


@pytest.mark.parametrize(
    ("forms", "solver", "narrowing"),
    [
        ((12.5, 7.5, 9.4), 13.1, 0.6),
        ((3.8, 2.3, 2.4), 3.5, 0.6),
        ((0.30, 0.25, 0.44), 1.02, 0.0),
        ((0.14, 0.12, 0.11), 0.30, 0.0),
    ],
)
def test_the_band_holds_what_the_solver_gave(forms, solver, narrowing):
    """The left pulmonary artery that was compared with a solver (domain facts, 3.7)."""
    from SDFStentLib.flow.pressure import band_of

    low, high = band_of(forms, narrowing)
    assert low < solver < high


def test_narrowings_of_nearly_the_same_share_have_nearly_the_same_band():
    shares = np.linspace(0.0, 0.5, 251)
    highs = [pressure_band(profile(throat(6.0, 6 * (1 - s), 20.0), 20.0), 8.0).high for s in shares]
    assert np.abs(np.diff(np.log(highs))).max() < 0.02


def test_widening_lowers_the_band_and_a_stented_tube_has_the_wider_one():
    before = pressure_band(profile(throat(7.0, 3.0, 26.0), 26.0), 8.0)
    after = pressure_band(profile(lambda x: 7.0, 26.0), 8.0)
    assert after.high < before.low
    assert after.high / after.low > before.high / before.low


def test_equivalent_diameters_give_the_low_end_where_the_lumen_is_not_round():
    narrow, wide = throat(8.0, 3.0, 20.0), throat(8.0, 4.5, 20.0)
    band = pressure_band(profile(narrow, 20.0, wide), 10.0)
    assert band.low <= by_quadrature(wide, 20.0, 10.0, Blood()) * 1.001
    assert band.high >= by_quadrature(narrow, 20.0, 10.0, Blood())


@pytest.mark.parametrize("flow", [0.0, -3.0, float("nan"), float("inf"), "fast"])
def test_a_flow_that_is_none_is_refused(flow):
    with pytest.raises(InputError, match="flow"):
        pressure_band(profile(lambda x: 6.0, 20.0), flow)


def test_a_stretch_with_unknown_diameters_is_refused():
    line = profile(lambda x: float("nan") if x > 15 else 6.0, 20.0)
    with pytest.raises(InputError, match="some are not known"):
        pressure_band(line, 5.0)


def read(path):
    return json.loads(Path(path).read_text(encoding="utf-8"))


def test_shell_report_and_plan_tell_the_pressure_for_a_flow(a_folder, capsys):
    files = ["--report", "r.json", "--report", "r.html", "--save-plan", "p.json"]
    assert deploy("--flow", "4", "8.5", "--export-0d", "zero.json", *files) == 0
    said = capsys.readouterr().out
    (stent,) = read("r.json")["stents"]
    along, pressure = stent["diameters"]["along"], stent["pressure"]
    start, end = stent["diameters"]["stent_ends_mm"]
    is_own = (np.array(along["arc_length_mm"]) >= start) & (np.array(along["arc_length_mm"]) <= end)
    for when in ("before", "after"):
        columns = [along[f"{kind}_{when}_mm"] for kind in ("mis", "equivalent")]
        x, inscribed, equivalent = np.array([along["arc_length_mm"], *columns], dtype=float)[
            :, is_own
        ]
        line = DiameterProfile(x, np.zeros((len(x), 3)), inscribed, equivalent)
        for flow, (low, high) in zip((4.0, 8.5), pressure[f"{when}_mmhg"], strict=True):
            assert (low, high) == pytest.approx(pressure_band(line, flow)[1:])
            per_minute = f"({flow * 60 / 1000:.3g} L/min)"
            assert f"{low:.2g} to {high:.2g} mmHg at {flow:g} mL/s {per_minute}" in said
    assert pressure["after_mmhg"][1][1] < pressure["before_mmhg"][1][0]
    page = Path("r.html").read_text(encoding="utf-8")
    assert "<h2>Pressure</h2>" in page
    assert "No measured gradient" in page
    assert load_plan("p.json").flow == (4.0, 8.5)
    jsonschema.validate(read("p.json"), SCHEMA)


def test_the_blocks_for_a_solver_are_those_of_the_lumen_in_cgs(a_folder):
    assert deploy("--flow", "4", "8", "--export-0d", "zero.json") == 0
    document = read("zero.json")
    before, after = document["vessels"]
    values = after["zero_d_element_values"]
    # A lumen of 0.6 cm over 2 cm less the foreshortening of 10 %.
    assert after["vessel_length"] == pytest.approx(1.8, abs=0.01)
    assert values["R_poiseuille"] == pytest.approx(8 * 0.04 * 1.8 / (np.pi * 0.3**4), rel=0.02)
    assert values["L"] == pytest.approx(1.06 * 1.8 / (np.pi * 0.3**2), rel=0.02)
    assert values["stenosis_coefficient"] < 1e-2
    assert before["zero_d_element_values"]["stenosis_coefficient"] > 1.0
    assert "K_t = 1.52" in document["stenosis_coefficient"]
    assert document["not_one_vessel"] == {}


def test_blocks_of_overlapping_stents_say_what_both_of_them_have():
    """In series they are longer than the vessel, by that; one dilated again counts as it lies."""
    tube = straight_tube(radius=3.0, edge_length=1.2)
    ends = ((10.0, 22.0), (18.0, 30.0), (29.5, 34.0))
    stents = [Stent(6.6, placement=AlongAxis(tube.axis_at(np.array(end)))) for end in ends]
    stents.append(Stent(7.0, placement=OfStent(2)))
    result = Treatment(tube.surface, stents, settings=DeploymentSettings(certify=False)).result
    document = zero_d_document(result)
    after = {one["vessel_name"]: one["vessel_length"] for one in document["vessels"]}
    both = document["length_in_both_cm"]
    assert sorted(both) == ["stents 1 and 4", "stents 3 and 4"]
    in_series = sum(after[f"stent_{number}_after"] for number in (1, 3, 4))
    assert in_series - sum(both.values()) == pytest.approx(2.4, abs=0.03)
    assert next(str(one) for one in zero_d_cautions(result)) == (
        "The 0D blocks of stents 1 and 4 both have the 4.0 mm of vessel over which these overlap; "
        "in series, leave it out of one of them."
    )


def test_no_flow_no_word_of_pressure(a_folder, capsys):
    assert deploy("--report", "r.json", "--report", "r.html") == 0
    assert "ressure" not in capsys.readouterr().out
    assert read("r.json")["stents"][0]["pressure"] is None
    assert "ressure" not in Path("r.html").read_text(encoding="utf-8")


def test_where_a_branch_opens_within_the_stent_nothing_is_estimated(tmp_path, capsys):
    assert main(["demo", "-o", str(tmp_path / "demo"), "--quiet"]) == 0
    document = read(tmp_path / "demo" / "plan.json")
    document["flow"] = [5, 20]
    plan = tmp_path / "demo" / "flow.json"
    plan.write_text(json.dumps(document), encoding="utf-8")
    blocks = tmp_path / "zero.json"
    assert main(["run", str(plan), "-o", str(tmp_path / "out"), "--export-0d", str(blocks)]) == 0
    said = capsys.readouterr()
    assert "Pressure drop: not estimated; flow leaves through right" in said.out
    split = "The 0D block of stent 1 is not one vessel: flow leaves through right"
    assert split in " ".join(said.err.split())
    pressure = read(tmp_path / "out" / "report.json")["stents"][0]["pressure"]
    assert pressure["before_mmhg"] is pressure["after_mmhg"] is None
    # Who takes the blocks for a solver reads no report.
    assert read(blocks)["not_one_vessel"] == {
        "stent 1": "flow leaves through right pulmonary artery within the stent"
    }


@pytest.mark.parametrize(
    ("flow", "words"),
    [
        (("0", "5"), "flow: expected a number greater than 0 and at most 10000 (mL/s), got 0"),
        (("-2", "5"), "flow: expected a number greater than 0 and at most 10000 (mL/s), got -2"),
        (("5", "4"), "flow at most: expected"),
        (("nan", "4"), "flow"),
    ],
)
def test_a_flow_of_zero_or_backwards_is_a_sentence_and_nothing_is_written(
    a_folder, capsys, flow, words
):
    assert deploy("--flow", *flow) == 2
    assert words in capsys.readouterr().err
    assert not Path("out.vtp").exists()


@pytest.mark.parametrize("flow", [[5], 5, [5, 4], [0, 4], ["5", "8"], [1, 2, 3], [True, 2]])
def test_a_plan_with_another_flow_is_refused(flow):
    with pytest.raises(InputError, match="flow"):
        plan_from_document({**a_document(), "flow": flow})
