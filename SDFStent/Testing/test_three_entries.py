"""One plan with device, balloon, waist and flow, from the shell, the library and the panel."""

import numpy as np
import pytest
from panel_helpers import deploy, saveAsFile

TURN = (-1, -1, 1)
"""From RAS, in which the panel is, to LPS, in which the files are."""


def inDoublePrecision(node):
    import vtk

    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    points.DeepCopy(node.GetPolyData().GetPoints())
    node.GetPolyData().SetPoints(points)


@pytest.fixture
def thePlan(host, aStent, tmp_path):
    """The panel with that plan, set by its controls and deployed, and the plan and the inputs as files."""
    ui, parameters = aStent.ui, aStent._parameterNode
    inDoublePrecision(parameters.vessel)  # files are written in that of their surface
    for node, name in ((parameters.vessel, "artery"), (parameters.centerline, "lines")):
        saveAsFile(node, tmp_path / f"{name}.vtp", "LPS")
    host.choose(ui.deviceComboBox, ui.deviceComboBox.findText("gore-vbx"))
    ui.balloonCheckBox.checked = True
    ui.recoilRuleCheckBox.checked = False
    ui.balloonSlider.value, ui.recoilSpinBox.value = 9.0, 8.0
    ui.waistSpinBox.value, ui.waistPositionSpinBox.value = 6.5, 40.0
    ui.flowMeanSpinBox.value, ui.flowPeakSpinBox.value = 1.2, 3.6
    deploy(host, aStent)
    path = tmp_path / "plan.json"
    aStent.logic.savePlan(path, parameters)
    assert parameters.status == ""
    return aStent, path


def ofThePanel(panel):
    """The panel's wall in the frame of the files."""
    return panel.logic.lastRun(panel._parameterNode).result.points * TURN


def ofFile(path):
    from SDFStentLib.files import read_surface

    return read_surface(path).points


def shell(*arguments):
    from SDFStentLib.cli import main

    assert main([*map(str, arguments), "--quiet"]) == 0


def test_the_panels_plan_gives_the_same_wall_in_library_and_shell(thePlan, tmp_path):
    from SDFStentLib.plan import load_plan, run_plan

    panel, path = thePlan
    (stent,) = load_plan(path).stents
    assert (stent.device.name, stent.balloon.diameter) == ("gore-vbx", 9.0)
    assert (stent.balloon.recoil_fraction, stent.foreshortening) == (0.08, 0.0)
    assert stent.shape.waist.position == 0.4
    flow = load_plan(path).flow
    assert (flow.mean, flow.peak) == pytest.approx((20, 60))
    expected = ofThePanel(panel)
    native = ofFile(tmp_path / "artery.vtp")
    assert np.abs(expected - native).max() > 1
    by_library = run_plan(load_plan(path)).treatment.points
    np.testing.assert_allclose(by_library, expected, rtol=0, atol=1e-9)
    shell("run", path, "-o", tmp_path / "out")
    np.testing.assert_allclose(
        ofFile(tmp_path / "out" / "artery_stented.vtp"), expected, rtol=0, atol=1e-9
    )


@pytest.mark.bench
def test_the_shells_options_give_the_wall_of_the_panels_controls(thePlan, tmp_path):
    panel, _path = thePlan
    handle = panel._parameterNode.stent.handle
    place = np.array(handle.GetNthControlPointPositionWorld(0)) * TURN
    files = [tmp_path / "artery.vtp", "--centerline", tmp_path / "lines.vtp"]
    where = ["--center", *map(repr, place.tolist()), "--length", 14]
    size = ["--device", "gore-vbx", "--balloon", 9, "--recoil", 0.08]
    shape = ["--waist", 6.5, "--waist-position", 0.4, "--mean-flow", "20mL/s"]
    out = ["-o", tmp_path / "shell.vtp", "--save-plan", tmp_path / "shell.json"]
    shell("deploy", *files, *where, *size, *shape, *out)
    expected = ofThePanel(panel)
    np.testing.assert_allclose(ofFile(tmp_path / "shell.vtp"), expected, rtol=0, atol=1e-9)


def test_the_shells_plan_gives_the_wall_in_the_panel(host, thePlan, tmp_path):
    """What was set is set otherwise before the plan is loaded."""
    from SDFStentLib.plan import load_plan, run_plan, save_plan

    panel, path = thePlan
    expected = ofThePanel(panel)
    save_plan(run_plan(load_plan(path)).plan, path)
    ui = panel.ui
    ui.balloonCheckBox.checked = False
    host.choose(ui.deviceComboBox, 0)
    ui.waistSpinBox.value = 0.0
    ui.flowMeanSpinBox.value = 0.0
    host.files.append(str(path))
    host.click(ui.loadPlanButton)
    assert (ui.balloonSlider.value, ui.recoilSpinBox.value) == (9.0, 8.0)
    assert (ui.deviceComboBox.currentText, ui.waistSpinBox.value) == ("gore-vbx", 6.5)
    assert (ui.flowMeanSpinBox.value, ui.flowPeakSpinBox.value) == pytest.approx((1.2, 3.6))
    deploy(host, panel)
    np.testing.assert_allclose(ofThePanel(panel), expected, rtol=0, atol=1e-9)
    assert "Balloon 9 mm, lumen 8.28 mm after recoil of 8 % (as given)" in ui.lumenLabel.text
    assert "Device gore-vbx: 14 mm long as packed, 14.0 mm at 8.28 mm" in ui.lumenLabel.text
    assert "At the mean flow of 20 mL/s" in ui.lumenLabel.text
