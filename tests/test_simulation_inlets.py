"""`sdfstent simulate` where blood comes in at several ends, or not at the proximal one."""

from xml.etree import ElementTree

import numpy as np
import pytest
from seeds import seeds
from test_flow_inlets import MMHG, a_fontan, a_vessel, flows
from test_simulation import series

from benchmarks.phantoms import branching_pulmonary_artery
from SDFStentLib.flow import Inflow, Wave, known_flow
from SDFStentLib.plan import flow_model
from SDFStentLib.report import simulation_sentences
from SDFStentLib.simulation import Cut, State, prepare
from SDFStentLib.simulation.conditions import conditions_of
from SDFStentLib.simulation.remesh import Wishes
from SDFStentLib.simulation.solver_file import harmonics_of, solver_files, time_steps
from SDFStentLib.treatment import SegmentWishes, Vessel, extract_segment
from SDFStentLib.validation import InputError

PRESSURES = {"inlet": 24.0, "wedge": 8.0}


@pytest.fixture
def prepared(monkeypatch):
    """Segments with what is set at their ends, before and after, without meshes."""
    part = "SDFStentLib.simulation.prepared"
    monkeypatch.setattr(f"{part}._meshed", lambda plan: State(*plan[:2], plan.meshes, plan.throat))

    def made(vessel, known, ends):
        wider = Vessel(vessel.surface, vessel.centerline, faces=vessel.faces)
        cut = Cut(tuple(np.array(one, float) for one in ends))
        return prepare((vessel, wider), flow_model(vessel, known), cut, Wishes(coarser=4.0))

    return made


def conditions_at(vessel, known, ends):
    segment = extract_segment(vessel, *ends, SegmentWishes(False, True)).before
    model = flow_model(vessel, known)
    return conditions_of(model.answer(vessel.channels), model.channels, segment, segment)


@pytest.mark.parametrize("has_pressures", [True, False])
def test_a_vein_that_is_cut_off_is_an_inlet_in_3d(fontan, has_pressures):
    ends = [fontan.vessels[0].axis.point(at)[0] for at in (8.0, 95.0)]
    pressures = {"inlet": 14.0, "wedge": 8.0} if has_pressures else {}
    known = known_flow(inlets=flows(IVC=30.0, SVC=20.0), **pressures)
    made, _ = conditions_at(a_fontan(fontan), known, ends)
    inlet, *others = made.ends
    assert inlet.flow == pytest.approx(-30.0, rel=1e-6)
    (vein,) = (one for one in others if one.flow < 0)
    assert vein.kind == "flow"
    assert vein.value == pytest.approx(-20.0, rel=1e-6)
    assert made.most == pytest.approx(50.0, rel=1e-6)
    assert sum(one.flow for one in others) == pytest.approx(30.0, rel=1e-6)
    if has_pressures:
        # Both lungs leave 14 mmHg less what the connection costs to the flow beyond 8.
        for one in others:
            if one.kind == "resistance":
                assert 4.0 < one.value * one.flow / (10 * MMHG) < 6.0


def a_wave(random, mean, rows, cycle=0.8):
    """Of rows at even times, which may run back."""
    time = np.linspace(0, cycle, rows + 1)
    turns = 2 * np.pi * np.outer(np.arange(1, 5), time / cycle)
    flow = 1 + random.normal(0, 0.6, 4) @ np.cos(turns + random.uniform(0, 6, 4)[:, None])
    flow[-1] = flow[0]
    return Wave(tuple(time.tolist()), tuple(flow.tolist())).scaled(mean)


def rows_of(text):
    return np.array([line.split() for line in text.splitlines()[1:]], float).T


@pytest.mark.parametrize("seed", seeds(1, 40))
@pytest.mark.parametrize("has_pressures", [True, False])
def test_every_inlet_has_a_wave_of_its_own(fontan, prepared, has_pressures, seed):
    random = np.random.default_rng(seed)
    means = dict(zip(("IVC", "SVC"), random.uniform(8, 35, 2).tolist(), strict=True))
    # Rows on unlike steps: of a hundred and twenty, of a hundred and one.
    waves = {
        "IVC": a_wave(random, means["IVC"], int(random.choice([20, 24, 101]))),
        "SVC": a_wave(random, means["SVC"], int(random.choice([30, 40]))),
    }
    if random.random() < 0.3:
        waves["SVC"] = None
    known = known_flow(
        inlets=tuple(Inflow(name, means[name], waves[name]) for name in means),
        **(PRESSURES if has_pressures else {}),
    )
    axis = fontan.vessels[0].axis
    made = prepared(a_fontan(fontan), known, [axis.point(at)[0] for at in (8.0, 90.0)])
    for state in made.states.values():
        conditions, steps = state.conditions, state.meshes["fine"][1]
        texts = solver_files(conditions, steps)
        root = ElementTree.fromstring(texts["solver.xml"])
        kinds = {
            one.get("name"): one.findtext("Time_dependence")
            for one in root.findall("Add_equation/Add_BC")
        }
        assert [kinds["inlet"], kinds["other_inlet"]] == 2 * ["Unsteady"]
        assert sorted(kinds.values())[:2] == (["RCR", "RCR"] if has_pressures else ["Steady"] * 2)
        files = {"inlet": "IVC", "other_inlet": "SVC"}
        for face, name in files.items():
            time, flow = rows_of(texts[f"{face}.flow"])
            assert time[-1] == pytest.approx(0.8, rel=1e-12)
            assert flow[0] == flow[-1]
            wave = waves[name]
            expected = (
                np.full(len(time), means[name])
                if wave is None
                else np.interp(time, wave.time, wave.flow)
            )
            # Where no steps meet all rows, they go to those beside them.
            assert flow == pytest.approx(
                -expected, abs=0.02 * np.ptp(expected) + 1e-4 * means[name]
            )
            found, given = series(texts[f"{face}.flow"])
            assert found == pytest.approx(given, abs=0.0101 * np.ptp(given) + 1e-4 * means[name])
        # What comes in leaves, at every moment.
        assert np.abs(conditions.cycle.flow.sum(axis=0)).max() < 1e-6 * known.mean
        assert sum(one.flow for one in conditions.ends) == pytest.approx(0, abs=1e-6 * known.mean)
        # The steps meet the fastest blood of all inlets together.
        peak = np.abs(conditions.cycle.flow[[one.flow < 0 for one in conditions.ends]]).sum(axis=0)
        assert conditions.most == peak.max() >= known.wave.peak * (1 - 1e-6)
        assert steps.number >= 3 * known.wave.steps


@pytest.mark.parametrize("root", ["IVC", "RPA", "LPA", "SVC"])
@pytest.mark.parametrize("is_turned", [False, True])
def test_the_proximal_end_may_be_one_at_which_blood_leaves(fontan, prepared, root, is_turned):
    opening = {"IVC": 0, "RPA": 1, "LPA": 2, "SVC": 3}[root]
    vessel = a_fontan(fontan, fontan.openings[opening].center)
    ends = [(0.0, 0.0, 12.0), (32.0, 0.0, 68.0)]
    known = known_flow(inlets=flows(IVC=30.0, SVC=20.0), **PRESSURES)
    made = prepared(vessel, known, ends[::-1] if is_turned else ends)
    assert made.way[0] == pytest.approx([0, 0, 12], abs=1.0)
    assert made.way[-1] == pytest.approx([32, 0, 68], abs=1.0)
    for state in made.states.values():
        inlet, *others = state.conditions.ends
        assert (inlet.name, inlet.kind) == ("inlet", "flow")
        assert inlet.flow == pytest.approx(-30.0, rel=1e-6)
        by_name = {one.name: one for one in others}
        assert by_name["other_inlet"].value == pytest.approx(-20.0, rel=1e-6)
        main = by_name[made.main_outlet]
        assert main.kind == "resistance"
        assert main.flow > 0
        faces = {face.name: face for face in state.segment.faces}
        assert faces[made.main_outlet].center == pytest.approx([32, 0, 68], abs=1.0)
        assert faces["inlet"].kind == faces["other_inlet"].kind == "inlet"
        assert faces[made.main_outlet].kind == "outlet"
    told = made.network["before"]["recovered"][0]
    assert told > 0


def test_where_blood_leaves_at_both_ends_the_inlet_is_where_it_comes_from(prepared):
    """From lung to lung: the main artery was told to be an outlet, and a lung the inlet."""
    phantom = branching_pulmonary_artery()
    vessel = a_vessel(phantom)
    left, right = (vessel_.axis for vessel_ in phantom.vessels)
    ends = [left.point(48.0)[0], right.point(24.0)[0]]
    made = prepared(vessel, known_flow(40.0, **PRESSURES), ends)
    inlet, *others = made.states["before"].conditions.ends
    assert inlet.flow == pytest.approx(-40.0, rel=1e-6)
    assert sum(one.flow for one in others) == pytest.approx(40.0, rel=1e-6)
    assert all(one.kind == "resistance" for one in others)
    # The way leads from the main artery into one of the lungs.
    assert np.linalg.norm(made.way[0] - left.point(24.0)[0]) < 16
    assert made.network["before"]["recovered"][0] > 0


def test_a_wave_that_runs_back_enters_and_leaves_at_the_proximal_end(prepared):
    phantom = branching_pulmonary_artery()
    vessel = a_vessel(phantom)
    time = np.linspace(0, 0.8, 21)
    flow = np.where(time < 0.32, 200 * np.sin(np.pi * time / 0.32), -45.0)
    flow[-1] = flow[0]
    wave = Wave(tuple(time.tolist()), tuple(flow.tolist()))
    axis = phantom.vessels[0].axis
    ends = [axis.point(at)[0] for at in (6.0, 50.0)]
    made = prepared(vessel, known_flow(30.0, wave, inlet=40.0, wedge=8.0), ends)
    conditions = made.states["before"].conditions
    texts = solver_files(conditions, made.states["before"].meshes["fine"][1])
    _, rows = rows_of(texts["inlet.flow"])
    assert rows == pytest.approx(-flow * 30.0 / wave.mean, rel=1e-6, abs=1e-9)
    assert rows.max() > 20
    # Blood that comes in where pressure is set needs what the solver has against that.
    root = ElementTree.fromstring(texts["solver.xml"])
    assert float(root.findtext("Add_equation/Backflow_stabilization_coefficient")) > 0


def test_no_end_with_flow_is_a_sentence(fontan, prepared):
    vessel = a_fontan(fontan)
    known = known_flow(inlets=flows(IVC=30.0, SVC=0.0), **PRESSURES)
    axis = fontan.vessels[2].axis if len(fontan.vessels) > 2 else None
    assert axis is not None
    tip = fontan.openings[3].center
    with pytest.raises(InputError, match="nothing flows"):
        prepared(vessel, known, [tip - [0.8, 0, 8.0], tip - [2.0, 0, 20.0]])


def test_flow_that_does_not_vary_takes_no_more_harmonics_than_usual():
    time = np.linspace(0, 0.8, 41)
    noise = 1e-9 * np.random.default_rng(0).normal(size=41)
    noise[-1] = noise[0]
    for flow in (0 * time, 5 + 0 * time, 5 + noise):
        assert harmonics_of(time, flow, 1e-6) == 16


def test_steps_of_reversed_flow_are_those_of_flow_as_fast(fontan):
    known = known_flow(inlets=flows(IVC=30.0, SVC=20.0), **PRESSURES)
    ends = [(0.0, 0.0, 12.0), (32.0, 0.0, 68.0)]
    one, _ = conditions_at(a_fontan(fontan), known, np.array(ends))
    turned = one._replace(ends=one.ends[::-1])
    assert time_steps(one, 1.0, 5.0, 1e4) == time_steps(turned, 1.0, 5.0, 1e4)


def test_what_comes_in_at_a_further_inlet_is_told_without_a_minus():
    """`flow through other_inlet: -20` reads as if it went the other way."""

    def state(other: float) -> dict[str, object]:
        drop = {"value": 1.0, "error": None}
        band = dict.fromkeys(("value", "low", "high"), 1.0)
        keys = ("total_drop_mmhg", "static_drop_mmhg", "largest_drop_mmhg")
        flows = {"outlet": 50.0 + other, "other_inlet": other}
        return {
            "inflow_ml_s": 50.0,
            "inlet_mmhg": None,
            **dict.fromkeys((*keys, "shear_mean_pa", "shear_high_pa"), drop),
            "outlets": {name: {"flow_ml_s": flow} for name, flow in flows.items()},
            "network": {
                **dict.fromkeys(("recovered_mmhg", "maximal_mmhg"), band),
                "outlets_ml_s": flows,
            },
        }

    def told(*others: float) -> list[str]:
        states = zip(("before", "after"), others, strict=True)
        document = {name: {"mean": state(other)} for name, other in states}
        lines = simulation_sentences({**document, "main_outlet": "outlet", "notes": []})
        return [line.strip() for line in lines if "other_inlet" in line]

    assert told(-20.0, -21.5) == [
        "flow in through other_inlet: 20 -> 21.5 mL/s [network 20 -> 21.5 mL/s]."
    ]
    # Where the blood turns, it takes a sign to say so.
    assert told(-2.0, 3.0) == ["flow through other_inlet: -2 -> 3 mL/s [network -2 -> 3 mL/s]."]
