"""Vessels with several inlets: a Fontan circulation, and any vessel from any of its ends."""

import json
import re
from itertools import pairwise, permutations

import numpy as np
import pytest
from seeds import seeds
from test_flow_graphs import by_nodes
from tube_files import write_vessel

from benchmarks.phantoms import (
    branching_pulmonary_artery,
    cavopulmonary_connection,
    stenosed_tube,
)
from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_lines
from SDFStentLib.flow import (
    L_PER_MIN,
    Ends,
    FlowModel,
    Inflow,
    Part,
    Wave,
    channels_of,
    inlets_of,
    known_flow,
    solved_by_svzerod,
    steady,
)
from SDFStentLib.geometry import NamedFaces
from SDFStentLib.plan import flow_entry, flow_model, known_of
from SDFStentLib.treatment import Vessel
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import VesselName

MMHG = 133.322
ENDS = {"IVC": 2, "RPA": 3, "LPA": 4, "SVC": 5}


def a_vessel(phantom, root=None, names=()):
    tree = phantom.centerline
    if root is not None:
        lines = [tree.ancestry(leaf) for leaf in tree.leaves]
        tree = type(tree).from_lines(tree.points, lines, tree.inscribed_radius, inlet=root)
    faces = NamedFaces(phantom.face_ids, {})
    return Vessel(phantom.surface, tree, faces=faces, names=tuple(names))


def a_fontan(phantom, root=None):
    return a_vessel(phantom, root, (VesselName(name, face) for name, face in ENDS.items()))


def flows(**inlets):
    return tuple(Inflow(name, mean) for name, mean in inlets.items())


def whole(moment):
    return sum(band.value for band in moment.sides)


def test_caval_veins_flow_into_both_lungs(fontan):
    known = known_flow(inlets=flows(IVC=30.0, SVC=20.0), inlet=14.0, wedge=8.0)
    answer = flow_model(a_fontan(fontan), known, "RAS").answer()
    moment = answer.before["mean"]
    assert answer.inlets.names == ("IVC", "SVC")
    assert answer.inflow["mean"] == (30.0, 20.0)
    assert sorted(answer.sides.names) == ["LPA", "RPA"]
    assert whole(moment) == pytest.approx(1.0, abs=1e-12)
    assert moment.inlet.value == pytest.approx(14.0, abs=1e-6)
    first, second = moment.inlets
    # The narrowed conduit costs more than the vein that is as wide as the arteries.
    assert 0 < second.drop.value < first.drop.value
    for inlet, flow in zip(moment.inlets, (30e-6, 20e-6), strict=True):
        assert inlet.power.value == pytest.approx(inlet.drop.value * MMHG * flow, rel=1e-9)
    total = sum(inlet.power.value for inlet in moment.inlets)
    assert moment.power.value == pytest.approx(total, rel=1e-9)
    # What goes in and does not come out is what the blocks lose.
    (network,) = answer.networks
    flow = steady(network, answer.outlets, 50e-6).flow
    lost = (network.resistance + network.stenosis * np.abs(flow)) * flow**2
    assert moment.power.value == pytest.approx(lost.sum(), rel=1e-6)


@pytest.mark.parametrize("seed", seeds(6, 100))
def test_any_of_its_ends_may_be_inlets_outlets_or_closed(fontan, seed):
    random = np.random.default_rng(seed)
    names = random.permutation(list(ENDS)).tolist()
    count = int(random.integers(1, 4))
    means = random.uniform(1, 40, count) * (random.random(count) < 0.8)
    means[0] += 5.0
    given = flows(**dict(zip(names[:count], means.tolist(), strict=True)))
    pressures = {"inlet": 40.0, "wedge": 8.0} if random.random() < 0.5 else {}
    known = known_flow(inlets=given, **pressures)
    answer = flow_model(a_fontan(fontan), known).answer()
    (network,), moment = answer.networks, answer.before["mean"]
    if moment.sides:
        assert whole(moment) == pytest.approx(1.0, abs=1e-9)
    assert all(np.isfinite(one.drop).all() for one in moment.inlets)
    tree, mean = network.tree, 1e-6 * known.mean
    state = steady(network, answer.outlets, mean)
    entering = tree.fractions * mean
    flow, pressure = by_nodes(tree.ends, tree.inlets.tolist(), network, answer.outlets, entering)
    assert state.flow == pytest.approx(flow, abs=1e-7 * mean)
    drops = [state.inlet - one for one in pressure]
    inlet, through = solved_by_svzerod(network, answer.outlets, known)
    assert through[-1] == pytest.approx(flow, abs=1e-6 * mean)
    assert inlet[-1] == pytest.approx(state.inlet, abs=1e-3 * MMHG)
    for one, drop in zip(moment.inlets, drops, strict=False):
        assert moment.inlets[0].drop.value - one.drop.value == pytest.approx(drop / MMHG, abs=1e-4)


def a_wave(random, mean, cycle=0.8):
    time = np.linspace(0, cycle, 9)
    flow = mean + mean * random.uniform(-1.2, 1.6, 9)
    flow[-1] = flow[0]
    return Wave(tuple(time.tolist()), tuple(flow.tolist()))


@pytest.mark.parametrize("seed", seeds(2, 40))
def test_waves_of_every_inlet_are_told_as_svzerod_has_them(fontan, seed):
    random = np.random.default_rng(seed)
    means = random.uniform(10, 35, 2).tolist()
    given = tuple(
        Inflow(name, mean, a_wave(random, mean) if random.random() < 0.8 or not k else None)
        for k, (name, mean) in enumerate(zip(("SVC", "IVC"), means, strict=True))
    )
    known = known_flow(inlets=given, inlet=16.0, wedge=6.0)
    assert known.wave.mean == pytest.approx(sum(means))
    model = flow_model(a_fontan(fontan), known)
    solved, steps = model.answer(solve=solved_by_svzerod), model.answer()
    (network,) = solved.networks
    inlet, through = solved_by_svzerod(network, solved.outlets, known)
    told, rough = solved.before["mean"], steps.before["mean"]
    assert told.inlet.value == pytest.approx(inlet.mean() / MMHG, abs=1e-3)
    assert whole(told) == pytest.approx(1.0, abs=1e-9)
    coming = through[:, network.tree.inlets[0]]
    assert 1e6 * coming.mean() == pytest.approx(means[0], rel=1e-3)
    assert rough.inlet.value == pytest.approx(16.0, abs=1e-3)
    assert rough.power.value == pytest.approx(told.power.value, rel=0.1)
    assert np.isfinite([band for one in told.inlets for band in (*one.drop, *one.power)]).all()


def test_waves_of_inlets_that_take_unlike_times_are_refused():
    random = np.random.default_rng(0)
    given = (Inflow("a", 5.0, a_wave(random, 5.0)), Inflow("b", 5.0, a_wave(random, 5.0, 0.9)))
    with pytest.raises(InputError, match=r"one length, got 0\.8 and 0\.9 s; stretch"):
        known_flow(inlets=given)


def test_waves_of_inlets_whose_lengths_are_rounded_are_of_one_length():
    random = np.random.default_rng(0)
    waves = [a_wave(random, 5.0, cycle) for cycle in (0.840612345, 0.840612)]
    known = known_flow(inlets=tuple(Inflow(n, waves[k].mean, waves[k]) for k, n in enumerate("ab")))
    assert [one.wave.cycle for one in known.inlets] == pytest.approx(2 * [0.840612345], rel=1e-12)
    assert known.wave.flow == pytest.approx(np.sum([one.flow for one in waves], axis=0))


def test_rows_of_waves_on_unlike_steps_are_all_met():
    """A row of the coarser wave lay between the steps of the finer one, and was cut off."""
    time, flow = np.linspace(0, 0.8, 25), np.ones(25)
    flow[11] = 60.0
    spike = Wave(tuple(time.tolist()), tuple(flow.tolist()))
    at = np.linspace(0, 0.8, 111)
    calm = 10 + 3 * np.sin(2 * np.pi * at / 0.8)
    calm[-1] = calm[0]
    other = Wave(tuple(at.tolist()), tuple(calm.tolist()))
    known = known_flow(inlets=(Inflow("a", spike.mean, spike), Inflow("b", other.mean, other)))
    alone = np.interp(time[11], at, calm)
    assert known.wave.peak == pytest.approx(60.0 + alone, rel=1e-3)
    assert known.wave.mean == pytest.approx(spike.mean + other.mean, rel=1e-9)
    flows, weights = known.spread(2)
    # Means, and those of squares, as of the lines between all rows.
    fine = np.linspace(0, 0.8, 400_001)
    for number, (rows, values) in enumerate(((time, flow), (at, calm))):
        line = np.interp(fine, rows, values)
        assert weights @ flows[:, number] == pytest.approx(np.trapezoid(line, fine) / 0.8, rel=1e-6)
        squares = np.trapezoid(line**2, fine) / 0.8
        assert weights @ flows[:, number] ** 2 == pytest.approx(squares, rel=1e-4)


@pytest.mark.parametrize("root", ["RPA", "LPA", "SVC"])
def test_the_root_of_the_centerline_does_not_matter(fontan, root):
    known = known_flow(inlets=flows(IVC=30.0, SVC=20.0), inlet=14.0, wedge=8.0)
    place = next(one.center for one in fontan.openings if one.face_id == ENDS[root])
    told, other = (
        flow_model(vessel, known).answer().before["mean"]
        for vessel in (a_fontan(fontan), a_fontan(fontan, place))
    )
    assert other.power.value == pytest.approx(told.power.value, rel=0.05)
    for one, same in zip(told.inlets, other.inlets, strict=True):
        assert same.drop.value == pytest.approx(one.drop.value, abs=0.02)


def test_a_stent_in_the_conduit_spares_the_lower_body(fontan):
    wide = cavopulmonary_connection(1.3, throat_radius=9.0)
    known = known_flow(inlets=flows(IVC=60.0, SVC=20.0), inlet=16.0, wedge=8.0)
    before, after = (
        flow_model(a_fontan(one), known).answer().before["mean"] for one in (fontan, wide)
    )
    assert before.inlets[0].drop.value > after.inlets[0].drop.value + 0.3
    assert before.power.value > after.power.value + 0.3 * MMHG * 60e-6


def test_a_tube_costs_the_same_from_either_end():
    tube = stenosed_tube(edge_length=0.7, stenosis_length=20.0)
    channels = channels_of(tube.surface, tube.centerline)
    ends = Ends(("the tube",))
    place = tube.centerline.points[[0, -1]]
    drops = []
    for node in (0, 1):
        inlets = inlets_of(channels, known_flow(5.0), ends)._replace(fractions={node: 1.0})
        model = FlowModel(channels, known_flow(5.0), inlets=inlets)
        drops.append(model.answer(parts=[Part("tube", place)]).before["mean"].drops[0])
    for kind in ("recovered", "maximal"):
        one, other = (getattr(drop, kind).value for drop in drops)
        assert other == pytest.approx(one, rel=0.02)


def test_blood_that_runs_from_a_branch_into_the_main_artery_costs_something_else():
    """Where two streams meet more is lost than where one divides, and it is no NaN."""
    vessel = a_vessel(branching_pulmonary_artery(1.0))
    names = {branch: number for number, branch in enumerate(vessel.branch_names)}
    answers = []
    for first, second in permutations([f"branch {k}" for k in (2, 3)]):
        known = known_flow(inlets=flows(**{first: 12.0, second: 8.0}))
        moment = flow_model(vessel, known).answer().before["mean"]
        answers.append([one.drop.value for one in moment.inlets])
        assert moment.sides is None
        assert min(answers[-1]) > 0
    assert len(names) == 3
    assert np.isfinite(answers).all()


@pytest.mark.parametrize(
    ("inlets", "words"),
    [
        (flows(SCV=20.0), "name of one end"),
        ((Inflow("IVC", 3.0), Inflow("ivc", 3.0)), "each once"),
        (flows(IVC=30.0, **{"branch 1": 3.0}), "another end for each"),
        (flows(IVC=1.0, SVC=1.0, LPA=1.0, RPA=1.0), "at which blood leaves"),
    ],
)
def test_inlets_that_are_none_are_refused(fontan, inlets, words):
    with pytest.raises(InputError, match=words):
        flow_model(a_fontan(fontan), known_flow(inlets=inlets))


def test_flows_of_inlets_add_up_to_the_mean_flow():
    assert known_flow(inlets=flows(a=1.0, b=2.0)).mean == 3.0
    with pytest.raises(InputError, match="add up to the mean flow, 4 mL/s, got 3"):
        known_flow(4.0, inlets=flows(a=1.0, b=2.0))
    with pytest.raises(InputError, match="greater than 0"):
        known_flow(inlets=flows(a=0.0, b=0.0))


@pytest.fixture
def files(tmp_path, monkeypatch, fontan):
    write_vessel(tmp_path, fontan, "fontan.vtp", "line.vtp", per_mm=1.0, radii=True)
    (tmp_path / "names.json").write_text(json.dumps(ENDS), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


FLOW = ["flow", "fontan.vtp", "--centerline", "line.vtp", "--names", "names.json"]
INLETS = ["--inlet", "IVC=1.8L/min", "--inlet", "SVC=20mL/s"]


def test_the_command_tells_what_each_caval_vein_loses_before_and_after(files, capsys):
    stent = ["--center", "0", "0", "26", "--length", "36", "--diameter", "18"]
    made = ["-o", "out.vtp", "--save-plan", "plan.json", "--report", "report.html"]
    assert main(["deploy", *FLOW[1:], *INLETS, *stent, "--bsa", "1.2", *made]) == 0
    told = capsys.readouterr().out
    assert "from IVC, 30.0 mL/s drop" in told
    assert "power loss of the connection" in told
    plan = json.loads((files / "plan.json").read_text(encoding="utf-8"))["flow"]
    assert plan["inlets"][1] == {"name": "SVC", "mean": 20.0, "wave": None}
    assert plan["bsa"] == 1.2
    page = (files / "report.html").read_text(encoding="utf-8")
    assert "Fontan circulation" in page
    assert "power loss of the connection" in page
    assert main(["run", "plan.json", "-o", "again"]) == 0
    section = json.loads((files / "again" / "report.json").read_text(encoding="utf-8"))["flow"]
    assert section["known"]["inlets"][0] == {"name": "IVC", "flow_ml_s": pytest.approx(30.0)}
    before, after = (section[state]["mean"] for state in ("before", "after"))
    assert sum(share["value"] for share in after["share"].values()) == pytest.approx(1.0)
    assert before["power_loss_w"]["value"] > after["power_loss_w"]["value"]
    index = before["power_loss_w"]["value"] * 1.2**2 / (1060 * 0.05**3)
    assert before["indexed_power_loss"]["value"] == pytest.approx(index, rel=1e-9)


def test_a_cycle_is_that_of_the_waves_of_inlets_too(files, capsys):
    time = 0.05 * np.arange(48)
    for name, mean in (("ivc.csv", 30), ("svc.txt", 20)):
        breath = 0.2 * np.sin(2 * np.pi * time / 2.4)
        flow = mean * (1 + np.sin(2 * np.pi * time / 0.8) + breath)
        rows = [f"{a:.3f},{b:.6f}" for a, b in zip(time, flow, strict=True)]
        (files / name).write_text("\n".join(["t_s,q_mL/s", *rows]), encoding="utf-8")
    inlets = ["--inlet", "IVC=ivc.csv", "--inlet", "SVC=svc.txt"]
    assert main([*FLOW, *inlets]) == 2
    assert "beats/min" in capsys.readouterr().err
    assert main([*FLOW, *inlets, "--cycle", "0.8s", "--json", "flow.json"]) == 0
    known = json.loads((files / "flow.json").read_text(encoding="utf-8"))["known"]
    assert known["wave"]["cycle_s"] == pytest.approx(0.8)
    assert known["mean_flow_ml_s"] == pytest.approx(50.0, rel=1e-5)
    assert main([*FLOW, *INLETS, "--cycle", "0.8s"]) == 2
    assert "--cycle: expected a wave beside it" in capsys.readouterr().err
    both = ["--inlet", "IVC=20mL/s", *inlets[2:], "--wave", "ivc.csv", "--cycle", "0.8s"]
    assert main([*FLOW, *both]) == 2
    assert "--wave: expected one wave for all inlets" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["SVC", "=20mL/s", "SVC=", "SVC=20", "SVC=-3mL/s"])
def test_an_inlet_without_name_or_flow_is_refused(files, capsys, text):
    assert main([*FLOW, "--inlet", "IVC=30mL/s", "--inlet", text]) == 2
    assert "--inlet" in capsys.readouterr().err


def test_networks_of_two_inlets_run_unchanged_in_svzerod(files):
    svzerod = pytest.importorskip("svzerod")
    assert main([*FLOW, *INLETS, "--inlet-pressure", "14", "--wedge", "8", "--export-0d", "o"]) == 0
    document = json.loads((files / "o" / "before.json").read_text(encoding="utf-8"))
    kinds = [one["bc_type"] for one in document["boundary_conditions"]]
    assert kinds.count("FLOW") == 2
    found = svzerod.simulate(document)
    first = found[found["name"] == "vessel0"].iloc[-1]
    assert first["pressure_in"] / (10 * MMHG) == pytest.approx(14.0, abs=1e-3)


def between(tree, start, end):
    """Points of a line of the file from one end of a tree to another."""
    up, down = tree.ancestry(start).tolist(), tree.ancestry(end).tolist()
    shared = sum(one == other for one, other in zip(up, down, strict=False))
    return [*up[: shared - 1 : -1], *down[shared - 1 :]]


@pytest.mark.parametrize(
    ("lines", "is_closed"),
    [
        ([("IVC", "RPA"), ("IVC", "LPA"), ("SVC", "RPA"), ("SVC", "LPA")], True),
        ([("IVC", "RPA"), ("SVC", "LPA")], True),
        ([("RPA", "IVC"), ("LPA", "SVC")], True),
        ([("IVC", "RPA"), ("IVC", "LPA"), ("IVC", "SVC")], False),
        ([("RPA", "IVC"), ("LPA", "IVC"), ("SVC", "IVC")], False),
    ],
)
def test_another_end_where_lines_begin_is_an_inlet_that_is_closed_and_said_to_be(
    fontan, tmp_path, monkeypatch, capsys, lines, is_closed
):
    write_vessel(tmp_path, fontan, "fontan.vtp", per_mm=1.0)
    tree = fontan.centerline
    nodes = {"IVC": int(tree.roots[0])}
    for opening in fontan.openings[1:]:
        away = np.linalg.norm(tree.points[tree.leaves] - opening.center, axis=1)
        name = next(name for name, face in ENDS.items() if face == opening.face_id)
        nodes[name] = int(tree.leaves[away.argmin()])
    ways = [between(tree, nodes[one], nodes[other]) for one, other in lines]
    cuts = np.cumsum([0, *map(len, ways)])
    data = polydata_from_lines(
        tree.points[np.concatenate(ways)],
        [np.arange(first, last) for first, last in pairwise(cuts.tolist())],
    )
    (tmp_path / "line.vtp").write_bytes(encode_vtp(data))
    monkeypatch.chdir(tmp_path)
    assert main(["flow", "fontan.vtp", "--centerline", "line.vtp", "--mean-flow", "3L/min"]) == 0
    told = capsys.readouterr().out
    assert ("All blood comes in at branch to face 2; branch to face 5 is an" in told) is is_closed
    shares = [float(one) for one in re.findall(r"flow to the .*: ([\d.]+) ", told)]
    assert sum(shares) == pytest.approx(100.0, abs=0.2)


@pytest.mark.parametrize("seed", range(5))
def test_an_entry_stays_the_same_whenever_it_is_read_and_written(seed):
    """Last digits came and went, of which each was a step to be undone."""
    random = np.random.default_rng(seed)
    for _entry in range(200):
        count = int(random.integers(1, 4))
        mean = round(random.uniform(0.5, 12.0), 2) / L_PER_MIN
        own = [{"name": str(number), "mean": mean / count} for number in range(count)]
        entry = flow_entry(known_of({"mean": mean, "inlets": own}))
        assert entry["inlets"] == own
        asked = {**entry, "mean": round(random.uniform(0.5, 12.0), 2) / L_PER_MIN}
        scaled = flow_entry(known_of(asked))
        assert flow_entry(known_of(scaled)) == scaled
        assert sum(one["mean"] for one in scaled["inlets"]) == pytest.approx(asked["mean"])
