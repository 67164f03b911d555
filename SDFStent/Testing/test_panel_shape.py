"""The section Shape: waist, ends, profile, caps."""

import numpy as np
import pytest
from panel_helpers import deploy


@pytest.fixture
def theSection(host, aStent):
    """The panel with one stent and the section open."""
    aStent.ui.shapeCollapsibleButton.collapsed = False
    host.process()
    return aStent


def planned(panel):
    from SDFStentSlicer import Plans

    return Plans.plannedOf(panel._parameterNode)[0]


def writeProfile(path, *rows):
    lines = ["fraction,diameter", *(f"{at},{wide}" for at, wide in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def test_a_waist_narrows_the_lumen_where_it_was_narrowest(host, theSection):
    from SDFStentLib.stent import Waist

    ui = theSection.ui
    assert not ui.waistPositionSpinBox.enabled
    ui.waistSpinBox.value = 6.0
    assert planned(theSection).shape.waist == Waist(6.0)
    assert ui.waistPositionSpinBox.text == "the narrowest place"
    deploy(host, theSection)
    treated = theSection.logic.lastRun(theSection._parameterNode).result.stents[0]
    assert treated.after.minimum == pytest.approx(6.0, abs=0.15)
    before, after = (p.inscribed_diameter for p in (treated.before, treated.after))
    assert abs(int(np.nanargmin(before)) - int(np.nanargmin(after))) <= 1
    assert "prescribed 6.00 to 8.50 mm" in ui.lumenLabel.text
    ui.waistPositionSpinBox.value = 25.0
    ui.waistLengthSpinBox.value = 4.0
    assert planned(theSection).shape.waist == Waist(6.0, 0.25, 4.0)
    ui.waistSpinBox.value = 0.0
    assert planned(theSection).shape is None


def test_ends_are_wider_or_narrower_than_the_stent(host, theSection):
    from SDFStentLib.stent import StentEnd

    ui = theSection.ui
    assert not ui.distalEndLengthSpinBox.enabled
    ui.proximalEndSpinBox.value = 10.0
    ui.proximalEndLengthSpinBox.value = 4.0
    ui.distalEndSpinBox.value = 7.5
    shape = planned(theSection).shape
    assert (shape.start, shape.end) == (StentEnd(10.0, 4.0), StentEnd(7.5, 3.0))
    deploy(host, theSection)
    treated = theSection.logic.lastRun(theSection._parameterNode).result.stents[0]
    diameters = treated.axis.profile.diameters
    assert (diameters[0], diameters[-1]) == (10.0, 7.5)
    assert treated.after.inscribed_diameter[1] > 9.0
    assert "prescribed 7.50 to 10.00 mm" in ui.lumenLabel.text


def test_a_profile_from_a_file_takes_the_place_of_waist_and_ends(host, theSection, tmp_path):
    ui, parameters = theSection.ui, theSection._parameterNode
    ui.waistSpinBox.value = 6.0
    host.files.append(writeProfile(tmp_path / "p.csv", (0, 9), (0.5, 6), (1, 8)))
    host.click(ui.loadProfileButton)
    assert planned(theSection).shape.table == ((0, 9), (0.5, 6), (1, 8))
    assert planned(theSection).shape.waist is None
    assert parameters.stent.diameter == ui.diameterSlider.value == 9.0
    assert ui.profileLabel.text == "3 rows, 6.0 to 9.0 mm"
    assert not ui.waistSpinBox.enabled
    ui.diameterSlider.value = 4.5  # in proportion
    assert planned(theSection).shape.table == ((0, 4.5), (0.5, 3), (1, 4))
    assert ui.profileLabel.text == "3 rows, 3.0 to 4.5 mm"
    host.click(ui.removeProfileButton)
    assert planned(theSection).shape is None
    assert ui.waistSpinBox.enabled


def test_a_profile_that_cannot_be_is_refused_where_errors_are(host, theSection, tmp_path):
    host.files.append(writeProfile(tmp_path / "p.csv", (0, 9), (1, 6), (0.5, 8)))
    host.click(theSection.ui.loadProfileButton)
    assert "profile: expected fractions that rise from 0 to 1, each once, got 0, 1, 0.5" in (
        theSection.ui.statusLabel.text
    )
    host.files.append(writeProfile(tmp_path / "p.csv", (0, "wide"), (1, 6)))
    host.click(theSection.ui.loadProfileButton)
    assert "p.csv, row 1: expected two numbers" in theSection.ui.statusLabel.text
    assert planned(theSection).shape is None


def test_caps_of_a_plan_are_shown_as_they_are(host, theSection):
    from SDFStentLib.stent import Shape

    ui, parameters = theSection.ui, theSection._parameterNode
    theSection.logic.setShape(parameters, Shape(cap_height=0.5))
    assert ui.capsComboBox.currentText == "0.5 of the radius high"
    ui.waistSpinBox.value = 7.0
    assert planned(theSection).shape.cap_height == 0.5
    host.choose(ui.capsComboBox, 0)
    assert ui.capsComboBox.count == 2


def test_an_end_of_one_stent_is_none_of_the_next(host, theSection):
    ui = theSection.ui
    ui.distalEndSpinBox.value, ui.distalEndLengthSpinBox.value = 9.0, 7.0
    host.click(ui.addStentButton)
    ui.distalEndSpinBox.value = 9.5
    ends = [one.shape["end"] for one in theSection._parameterNode.stents]
    assert ends == [{"diameter": 9.0, "length": 7.0}, {"diameter": 9.5, "length": 3.0}]
