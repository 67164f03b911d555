"""The section Device: device, balloon, recoil, what is kept, redilation."""

import json

import numpy as np
import pytest
from panel_helpers import deploy, planned, settle, theThroat

BENCH = {
    "name": "bench-16",
    "nominal_length": 16,
    "lengths": [[4, 16], [12, 12]],
    "maximum_diameter": 14,
    "source": "own bench",
}


@pytest.fixture
def aTable(tmp_path):
    """A device table of the user's own."""
    path = tmp_path / "own.json"
    table = {"schema": "sdfstent-devices", "version": 1, "devices": [BENCH]}
    path.write_text(json.dumps(table), encoding="utf-8")
    return path


@pytest.fixture
def theSection(host, aStent, aTable):
    """The panel with one stent, the section open, and the rows of a table of one's own."""
    aStent.ui.deviceCollapsibleButton.collapsed = False
    host.process()
    host.files.append(str(aTable))
    host.click(aStent.ui.deviceTableButton)
    host.processUntil(lambda: not aStent.lesions.isBusy)
    return aStent


def names(box):
    return [box.itemText(index) for index in range(box.count)]


def chooseDevice(host, panel, name):
    host.choose(panel.ui.deviceComboBox, names(panel.ui.deviceComboBox).index(name))


def measured(host, panel):
    """Wait for a recoil by the rule."""
    host.processUntil(lambda: not panel.recoil.isBusy)


def test_devices_are_those_of_the_library_and_of_the_user(theSection):
    from SDFStentLib.plan import device_table

    listed = names(theSection.ui.deviceComboBox)
    assert listed == [device.name for device in device_table()] + ["bench-16"]
    assert listed[0] == "generic" == theSection.ui.deviceComboBox.currentText
    assert planned(theSection)[0].device is None


@pytest.mark.parametrize(
    ("device", "way"), [("numed-cp", "the slider"), ("palmaz-xl-10-series", "the box")]
)
def test_a_shortening_that_is_not_known_has_to_be_said(host, theSection, device, way):
    ui = theSection.ui
    chooseDevice(host, theSection, device)
    assert ui.statusLabel.text.startswith(
        f"Stent 1: device {device}: its shortening is not known; say how much of its length it loses"
        f" (in Device, untick {ui.deviceShorteningCheckBox.text} or move Foreshortening)"
    )
    assert ui.foreshorteningSliderLabel.text == "Foreshortening:"
    assert not ui.deployButton.enabled
    assert ui.foreshorteningSlider.enabled
    if way == "the box":
        ui.deviceShorteningCheckBox.checked = False
    else:
        ui.foreshorteningSlider.value = 15.0
        assert not ui.deviceShorteningCheckBox.checked
    assert ui.deployButton.enabled
    lost = 0.1 if way == "the box" else 0.15
    assert planned(theSection)[0].foreshortening == pytest.approx(lost)


def test_every_device_of_the_table_can_be_deployed(host, theSection):
    """As it is chosen, or once its shortening is said; and the length that was set comes back."""
    ui, own = theSection.ui, theSection.ui.lengthSlider.value
    for index, name in enumerate(names(ui.deviceComboBox)):
        host.choose(ui.deviceComboBox, index)
        if not ui.deployButton.enabled:
            ui.foreshorteningSlider.value = 12.0
        assert ui.deployButton.enabled, name
        (stent,) = planned(theSection)
        length = getattr(stent.device, "nominal_length", None) or own
        assert (stent.length, ui.lengthSlider.value) == (length, length)
        assert ui.stentTable.item(0, 2).text() == f"{length:.1f} mm"
        host.choose(ui.deviceComboBox, 0)
        assert planned(theSection)[0].length == ui.lengthSlider.value == own, name


def test_a_diameter_beyond_the_devices_is_refused_in_the_librarys_sentence(
    host, theSection, aTable
):
    from SDFStentLib.plan import device_named
    from SDFStentLib.stent import AtCenter, Stent

    ui = theSection.ui
    chooseDevice(host, theSection, "bench-16")
    theSection._parameterNode.stent.diameter = 15.0
    with pytest.raises(ValueError, match="expected at most 14 mm") as said:
        Stent(15.0, placement=AtCenter(np.zeros(3)), device=device_named("bench-16", aTable))
    assert ui.statusLabel.text.startswith(f"Stent 1: {said.value}")
    assert ui.deployButton.toolTip == f"Stent 1: {said.value}"
    assert not ui.deployButton.enabled
    ui.diameterSlider.value = 10.0
    assert ui.statusLabel.text == ""
    ui.redilationSpinBox.value = 14.5
    assert "expected at most 14 mm, the largest diameter of bench-16" in ui.statusLabel.text
    ui.redilationSpinBox.value = 9.0
    assert "redilation: expected more than the 10 mm of stent 1, got 9 mm" in ui.statusLabel.text


def test_a_balloon_leaves_the_lumen_by_its_recoil(host, theSection):
    ui, parameters = theSection.ui, theSection._parameterNode
    assert not ui.balloonSlider.enabled
    ui.balloonCheckBox.checked = True
    measured(host, theSection)
    assert ui.balloonSlider.value == 9.14  # 8.5 / 0.93
    assert parameters.stent.diameter == 8.5
    assert not ui.recoilSpinBox.enabled
    ui.balloonSlider.value = 8.0
    measured(host, theSection)
    assert parameters.stent.diameter == pytest.approx(8.0 * 0.93)
    reference = theSection.lesions._search.found[0].reference_diameter
    assert ui.deviceLabel.text.splitlines()[0] == (
        "Balloon 8 mm, lumen 7.44 mm after recoil of 7 % (the mean in great vessels "
        f"(7 \N{PLUS-MINUS SIGN} 4 %)), reference {reference:.2f} mm."
    )
    ui.diameterSlider.value = 9.0
    measured(host, theSection)
    assert ui.deviceLabel.text.startswith("Balloon 9.68 mm, lumen 9.00 mm")
    ui.balloonSlider.value = 8.0
    ui.recoilRuleCheckBox.checked = False
    ui.recoilSpinBox.value = 12.0
    (stent,) = planned(theSection)
    assert (stent.balloon.diameter, stent.balloon.recoil_fraction) == (8.0, 0.12)
    assert stent.balloon.is_given
    assert stent.diameter == pytest.approx(8.0 * 0.88)
    deploy(host, theSection)
    assert "Balloon 8 mm, lumen 7.04 mm after recoil of 12 % (as given), reference" in (
        ui.lumenLabel.text
    )
    ui.balloonCheckBox.checked = False
    (stent,) = planned(theSection)
    assert stent.balloon is None
    assert stent.diameter == pytest.approx(7.04)


def test_a_balloon_that_is_switched_off_and_on_again_changes_nothing(host, theSection):
    """Above three times the native lumen the rule raised the recoil each time, and the lumen became narrower."""
    ui, parameters = theSection.ui, theSection._parameterNode
    ui.diameterSlider.value = 12.0
    for _time in range(2):
        ui.balloonCheckBox.checked = True
        measured(host, theSection)
        (stent,) = planned(theSection)
        assert stent.balloon.recoil_fraction == 0.10
        assert (stent.diameter, ui.balloonSlider.value) == (12.0, 13.33)
        ui.balloonCheckBox.checked = False
        measured(host, theSection)
        assert parameters.stent.diameter == 12.0


def test_the_recoil_is_by_the_rule_where_the_stent_lies(host, theSection):
    """Above three times the native lumen it is 10 %; the throat is 4.1 mm wide, the trunk much wider."""
    ui, parameters = theSection.ui, theSection._parameterNode
    ui.diameterSlider.value = 12.0
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 13.0
    measured(host, theSection)
    (stent,) = planned(theSection)
    assert stent.balloon.recoil_fraction == 0.10
    assert "the balloon was over 3 times the native lumen; it is 3.2 times" in ui.deviceLabel.text
    tree = theSection.logic.centerlineOf(parameters)
    wide = tree.path_from_proximal(tree.points[tree.roots[0]], 12.0).points[-1]
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *wide)
    measured(host, theSection)
    assert planned(theSection)[0].balloon.recoil_fraction == 0.07
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    host.click(ui.deployButton)  # does not wait for it
    assert planned(theSection)[0].balloon.recoil_fraction == 0.10


def test_an_end_is_kept_on_shortening(host, theSection):
    from SDFStentLib.stent import KEPT

    logic, parameters = theSection.logic, theSection._parameterNode
    theSection.ui.foreshorteningSlider.value = 40.0
    host.choose(theSection.ui.keptComboBox, 2)
    (stent,) = planned(theSection)
    assert stent.keeps == KEPT[2]
    deploy(host, theSection)
    (treated,) = logic.lastRun(parameters).result.stents
    packed = logic.centerlineOf(parameters).path_around(theThroat(), 14.0).points
    away = [np.linalg.norm(treated.axis.points[end] - packed[end]) for end in (0, -1)]
    lost = 0.4 * 14.0
    expected = {"center": [lost / 2, lost / 2], "proximal": [0, lost], "distal": [lost, 0]}
    np.testing.assert_allclose(away, expected[KEPT[2]], atol=0.2)


def test_a_table_of_ones_own_is_taken_away_again_and_stents_keep_their_device(
    host, theSection, aTable
):
    ui, parameters = theSection.ui, theSection._parameterNode
    chooseDevice(host, theSection, "bench-16")
    before = planned(theSection)
    assert ui.removeTableButton.enabled
    host.click(ui.removeTableButton)
    assert parameters.deviceTable == ""
    assert not ui.removeTableButton.enabled
    assert ui.deviceTableButton.toolTip.startswith("Add the devices of a table")
    assert ui.deviceComboBox.currentText == "bench-16"
    assert planned(theSection) == before
    chooseDevice(host, theSection, "gore-vbx")
    assert "bench-16" not in names(ui.deviceComboBox)


def test_details_survive_saving_and_loading_the_scene(host, theSection, aScene, aTable, tmp_path):
    ui, parameters = theSection.ui, theSection._parameterNode
    chooseDevice(host, theSection, "bench-16")
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 8.0
    ui.redilationSpinBox.value = 10.0
    host.choose(ui.keptComboBox, 2)
    ui.waistSpinBox.value, ui.distalEndSpinBox.value = 6.0, 9.5
    host.choose(ui.capsComboBox, 1)
    measured(host, theSection)
    before = planned(theSection)
    assert before[0].shape is not None
    path = tmp_path / "scene.mrb"
    assert aScene.WriteToMRB(str(path))
    host.newScene()
    aTable.unlink()
    assert aScene.ReadFromMRB(str(path), True)
    host.process()
    assert planned(theSection) == before
    assert ui.deviceComboBox.currentText == "bench-16"
    assert ui.balloonSlider.value == 8.0
    assert ui.keptComboBox.currentText == "Distal end"
    assert (ui.waistSpinBox.value, ui.distalEndSpinBox.value) == (6.0, 9.5)
    assert ui.capsComboBox.currentText == "Flat"
    assert "own.json" in ui.deviceTableButton.toolTip
    chooseDevice(host, theSection, "gore-vbx")  # those that come along are there
    assert planned(theSection)[0].device.name == "gore-vbx"
    assert parameters is not None


def test_a_table_that_cannot_be_read_is_refused_where_errors_are(host, theSection, tmp_path):
    (tmp_path / "none.json").write_text("{}", encoding="utf-8")
    host.files.append(str(tmp_path / "none.json"))
    host.click(theSection.ui.deviceTableButton)
    assert "none.json: device table: " in theSection.ui.statusLabel.text
    assert names(theSection.ui.deviceComboBox)[-1] == "bench-16"


def test_the_console_sets_all_of_it_without_a_panel(aLogic, theParameters, aTable):
    from SDFStentSlicer import Plans

    from SDFStentLib.stent import Shape, StentEnd

    aLogic.setDeviceTable(theParameters, aTable)
    aLogic.setDevice(theParameters, "bench-16")
    aLogic.setBalloon(theParameters, 9.0, recoil=0.1)
    aLogic.setKept(theParameters, "distal")
    aLogic.setShape(theParameters, Shape(end=StentEnd(9.0, 3.0)))
    (stent,) = Plans.plannedOf(theParameters)
    assert (stent.device.name, stent.length, stent.diameter) == ("bench-16", 16, 8.1)
    assert (stent.balloon.diameter, stent.keeps, stent.shape.end.length) == (9.0, "distal", 3.0)
    aLogic.setDevice(theParameters, "generic")
    aLogic.setBalloon(theParameters, None)
    aLogic.setShape(theParameters, None)
    (stent,) = Plans.plannedOf(theParameters)
    assert (stent.device, stent.balloon, stent.shape) == (None, None, None)
    assert stent.foreshortening == pytest.approx(0.1)
    aLogic.stentList(theParameters).remove()
    with pytest.raises(ValueError, match="Stent: expected one that is selected, got none; add one"):
        aLogic.setKept(theParameters, "distal")


def test_a_full_method_begins_once_where_the_recoil_is_measured_anew(host, theSection, monkeypatch):
    """It began, and was dropped when the balloon had changed: the answer came half a second later."""
    ui, logic, parameters = theSection.ui, theSection.logic, theSection._parameterNode
    ui.diameterSlider.value = 12.0
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 13.0
    ui.autoUpdateCheckBox.checked = True
    measured(host, theSection)
    settle(host, theSection)
    begun, steps = [], logic.steps

    def counted(parameterNode, live=False, **how):
        begun.append("preview" if live else "full")
        return steps(parameterNode, live=live, **how)

    monkeypatch.setattr(logic, "steps", counted)
    tree, handle = logic.centerlineOf(parameters), parameters.stent.handle
    wide = tree.path_from_proximal(tree.points[tree.roots[0]], 12.0).points[-1]
    for place, recoil in ((wide, 0.07), (theThroat(), 0.10)):
        begun.clear()
        handle.SetNthControlPointPositionWorld(0, *place)
        settle(host, theSection)
        measured(host, theSection)
        settle(host, theSection)
        assert planned(theSection)[0].balloon.recoil_fraction == recoil
        assert begun.count("full") == 1
        assert begun[-1] == "full"
