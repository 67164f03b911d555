"""Several inlets in the panel: a Fontan circulation from both caval veins, set by hand, kept, taken back."""

import json

import numpy as np
import pytest
from panel_helpers import deploy, saveAsFile, settle

CAVAL = "inferior caval vein", "superior caval vein"


@pytest.fixture
def aFontan(host, aPanel):
    """The panel with the connection of both caval veins, and a stent in the narrow conduit."""
    from SDFStentSlicer.SampleVessels import addVessel

    from benchmarks.phantoms import cavopulmonary_connection

    ui = aPanel.ui
    made = cavopulmonary_connection()
    vessel, centerline = addVessel(made.surface, made.faces, made.centerline, "Fontan")
    ui.vesselSelector.setCurrentNode(vessel)
    ui.centerlineSelector.setCurrentNode(centerline)
    host.click(ui.addStentButton)
    throat = made.throat.point
    aPanel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *throat)
    ui.diameterSlider.value, ui.lengthSlider.value = 16.0, 30.0
    settle(host, aPanel)
    return aPanel


def items(box):
    return [box.itemText(index) for index in range(box.count)]


def choose(host, ui, name):
    """Let the box show the end whose text begins so."""
    found = [n for n, text in enumerate(items(ui.inletComboBox)) if text.startswith(name)]
    host.choose(ui.inletComboBox, found[0])


def bothInlets(host, panel, lower=1.8, upper=1.2):
    """Set the flow of both veins, L/min."""
    ui = panel.ui
    ui.flowCollapsibleButton.collapsed = False
    ui.flowMeanSpinBox.value = 5.0
    for name, flow in zip(CAVAL, (lower, upper), strict=True):
        choose(host, ui, name)
        ui.inletCheckBox.checked = True
        ui.inletFlowSpinBox.value = flow


def known(panel):
    from SDFStentLib.plan import known_of

    return known_of(panel._parameterNode.get("flow"))


def inlets(panel):
    return {one.name: one.mean * 60 / 1000 for one in known(panel).inlets}


def test_ends_are_offered_by_their_names_and_flows_of_inlets_add_up(host, aFontan):
    ui = aFontan.ui
    ui.flowCollapsibleButton.collapsed = False
    assert not ui.inletComboBox.enabled  # without a flow there is none to part
    ui.flowMeanSpinBox.value = 3.0
    assert sorted(items(ui.inletComboBox)) == sorted(
        [*CAVAL, "left pulmonary artery", "right pulmonary artery"]
    )
    assert not ui.inletFlowSpinBox.enabled
    choose(host, ui, CAVAL[0])
    ui.inletCheckBox.checked = True
    assert inlets(aFontan) == {CAVAL[0]: pytest.approx(3.0)}  # the only one brings all
    bothInlets(host, aFontan, 1.8, 1.2)
    assert inlets(aFontan) == dict(zip(CAVAL, map(pytest.approx, (1.8, 1.2)), strict=True))
    assert ui.flowMeanSpinBox.value == pytest.approx(3.0)
    assert f"{CAVAL[0]}: 1.8 L/min" in items(ui.inletComboBox)
    assert ui.flowCollapsibleButton.text == "Flow: 3 L/min at 2 inlets"
    ui.flowMeanSpinBox.value = 6.0  # all of them change by the same
    assert list(inlets(aFontan).values()) == pytest.approx([3.6, 2.4])
    ui.inletCheckBox.checked = False
    assert list(inlets(aFontan).values()) == pytest.approx([3.6])
    assert ui.flowMeanSpinBox.value == pytest.approx(3.6)
    ui.inletFlowSpinBox.value = 0.0  # of none
    choose(host, ui, CAVAL[0])
    ui.inletFlowSpinBox.value = 0.0
    assert "expected more than 0 L/min at one inlet" in ui.statusLabel.text
    assert ui.inletFlowSpinBox.value == pytest.approx(3.6)


def test_pressure_and_power_from_each_caval_vein_are_told_as_the_library_has_them(host, aFontan):
    from SDFStentSlicer.Tiles import tilesOf

    ui = aFontan.ui
    bothInlets(host, aFontan)
    ui.bodySurfaceSpinBox.value = 1.2
    deploy(host, aFontan)
    run = aFontan.logic.lastRun(aFontan._parameterNode)
    before, after = run.flow.before["mean"], run.flow.after["mean"]
    for name, flow, first, last in zip(
        CAVAL, ("30.0", "20.0"), before.inlets, after.inlets, strict=True
    ):
        line = next(
            one for one in ui.lumenLabel.text.splitlines() if one.startswith(f"from {name}")
        )
        assert line.startswith(f"from {name}, {flow} mL/s drop ")
        assert line.count("->") == 2
        # All power that is lost on the way is drop times flow.
        for one in (first, last):
            assert one.power.value == pytest.approx(one.drop.value * 133.322 * float(flow) * 1e-6)
    assert after.inlets[0].drop.value < before.inlets[0].drop.value  # the conduit is wider
    powers = [one.power.value for one in (before, after)]
    index = [1.2**2 * power / (1060 * 0.05**3) for power in powers]
    assert f"indexed {index[0]:.3g} -> {index[1]:.3g}" in ui.lumenLabel.text
    tile = next(one for one in tilesOf(aFontan._parameterNode) if one.name == "Power lost")
    assert tile.value == f"{1e3 * powers[1]:.1f} mW"
    told = f"before {1e3 * powers[0]:.1f} mW; indexed {index[0]:.3g} -> {index[1]:.3g}"
    assert tile.beneath == told


def test_inlets_are_saved_and_read_and_the_shell_has_the_same_numbers(host, aFontan, tmp_path):
    from SDFStentLib.plan import load_plan, run_plan

    ui, parameters = aFontan.ui, aFontan._parameterNode
    bothInlets(host, aFontan)
    ui.bodySurfaceSpinBox.value, ui.unusualFlowCheckBox.checked = 1.2, True
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    deploy(host, aFontan)
    path = tmp_path / "plan.json"
    aFontan.logic.savePlan(path, parameters)
    flow = load_plan(path).flow
    assert {one.name: one.mean for one in flow.inlets} == dict(
        zip(CAVAL, map(pytest.approx, (30.0, 20.0)), strict=True)
    )
    assert (flow.bsa, flow.unusual) == (1.2, True)
    own = aFontan.logic.lastRun(parameters).flow.after["mean"]
    shell = run_plan(load_plan(path)).flow.after["mean"]
    assert shell.power.value == pytest.approx(own.power.value, rel=1e-3)
    ui.flowMeanSpinBox.value = ui.bodySurfaceSpinBox.value = 0.0
    ui.unusualFlowCheckBox.checked = False
    host.files.append(str(path))
    host.click(ui.loadPlanButton)
    assert list(inlets(aFontan)) == list(CAVAL)
    assert ui.bodySurfaceSpinBox.value == 1.2
    assert ui.unusualFlowCheckBox.checked


def test_inlets_surface_and_unusual_flow_are_taken_back_and_done_again(host, aFontan):
    ui, buttons = aFontan.ui, aFontan.sections[0]

    def rest():
        host.processUntil(lambda: not buttons._timer.isActive())

    def state():
        return (
            inlets(aFontan) if known(aFontan) else None,
            ui.bodySurfaceSpinBox.value,
            ui.unusualFlowCheckBox.checked,
            ui.inletCheckBox.checked,
        )

    ui.flowCollapsibleButton.collapsed = False
    seen = []
    for change in (
        lambda: setattr(ui.flowMeanSpinBox, "value", 3.0),
        lambda: setattr(ui.inletCheckBox, "checked", True),
        lambda: setattr(ui.bodySurfaceSpinBox, "value", 0.8),
        lambda: setattr(ui.unusualFlowCheckBox, "checked", True),
        lambda: setattr(ui.inletFlowSpinBox, "value", 2.0),
    ):
        change()
        rest()
        seen.append(state())
    for expected in seen[-2::-1]:
        host.click(ui.undoButton)
        assert state() == expected
        rest()
    for expected in seen[1:]:
        host.click(ui.redoButton)
        assert state() == expected
        rest()


def test_an_inlet_of_a_plan_that_is_no_end_can_be_taken_away(host, aFontan, tmp_path):
    ui, path = aFontan.ui, tmp_path / "plan.json"
    bothInlets(host, aFontan)
    aFontan.logic.savePlan(path, aFontan._parameterNode)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["flow"]["inlets"][1]["name"] = "azygos"
    path.write_text(json.dumps(document), encoding="utf-8")
    host.files.append(str(path))
    host.click(ui.loadPlanButton)
    deploy(host, aFontan)
    assert "expected the name of one end of the vessel" in ui.lumenLabel.text
    choose(host, ui, "azygos")
    ui.inletCheckBox.checked = False
    settle(host, aFontan)
    assert not any(text.startswith("azygos") for text in items(ui.inletComboBox))
    assert f"from {CAVAL[0]}" not in ui.lumenLabel.text  # of one inlet there is one pressure
    assert "At the mean flow of 30 mL/s" in ui.lumenLabel.text


def test_waves_of_inlets_of_a_plan_stay_with_them_when_their_flow_is_changed(
    host, aFontan, tmp_path
):
    from SDFStentLib.flow import Inflow, Wave, known_flow
    from SDFStentLib.plan import Plan, load_plan, save_plan

    time = (0.0, 0.2, 0.5, 0.8)
    waves = [Wave(time, flow) for flow in ((10, 60, 15, 10), (5, 30, 40, 5))]
    inlets = [Inflow(name, one.mean, one) for name, one in zip(CAVAL, waves, strict=True)]
    path, again = tmp_path / "plan.json", tmp_path / "again.json"
    logic, parameters, ui = aFontan.logic, aFontan._parameterNode, aFontan.ui
    logic.savePlan(path, parameters)
    save_plan(
        Plan(load_plan(path).stents, frame="RAS", flow=known_flow(inlets=tuple(inlets))), path
    )
    logic.loadPlan(path, parameters)
    ui.flowCollapsibleButton.collapsed = False
    choose(host, ui, CAVAL[1])
    ui.inletFlowSpinBox.value = 0.9
    logic.savePlan(again, parameters)
    flow = load_plan(again).flow
    first, second = flow.inlets
    assert first.mean == pytest.approx(waves[0].mean, rel=1e-3)
    assert first.wave.flow == pytest.approx(waves[0].flow, rel=1e-3)
    assert second.mean == pytest.approx(15.0)
    assert second.wave.flow == pytest.approx([15 / waves[1].mean * one for one in waves[1].flow])
    assert flow.mean == pytest.approx(first.mean + 15.0)
    both = [one.at(np.array(flow.wave.time)) for one in flow.inlets]
    assert flow.wave.flow == pytest.approx(np.sum(both, axis=0))


def test_a_flow_beyond_the_usual_is_asked_about_and_carried_out_once_it_is_meant(host, aFontan):
    ui = aFontan.ui
    ui.flowMeanSpinBox.value = 30.0
    assert "correct its unit, or tell that it is meant so (in Flow, tick Unusual" in (
        ui.statusLabel.text
    )
    assert not ui.deployButton.enabled
    ui.unusualFlowCheckBox.checked = True
    assert ui.statusLabel.text == ""
    assert ui.deployButton.enabled


def test_an_end_at_which_lines_begin_is_closed_as_in_the_shell(host, aFontan):
    """Lines from either caval vein to both arteries, as VMTK makes them of two sources."""
    from SDFStentLib.files import polydata_from_lines

    parameters = aFontan._parameterNode
    tree = aFontan.logic.centerlineOf(parameters)
    ends = {
        names[0]: leaf
        for names, leaf in zip(
            aFontan.logic.endNames(parameters),
            (tree.roots[0], *(nodes[-1] for nodes in tree.branches if nodes[-1] in tree.leaves)),
            strict=True,
        )
    }
    ways = {name: tree.ancestry(leaf) for name, leaf in ends.items()}
    upper = np.array(ways[CAVAL[1]][::-1])
    lines = []
    for name, way in ways.items():
        if name.endswith("artery"):
            joint = max(set(upper.tolist()) & set(way), key=lambda node: tree.arc_length[node])
            down = upper[: list(upper).index(joint)].tolist()
            lines += [list(way), down + list(way)[list(way).index(joint) :]]
    parameters.centerline.SetAndObservePolyData(polydata_from_lines(tree.points, lines))
    aFontan.ui.flowMeanSpinBox.value = 3.0
    settle(host, aFontan)
    deploy(host, aFontan)
    settle(host, aFontan)
    assert "is an inlet, too, by the lines of the centerline, and was closed" in (
        aFontan.ui.lumenLabel.text
    )
