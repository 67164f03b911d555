"""What is typed into a number: with a comma, beyond its ends, or none at all."""

import pytest
from panel_helpers import settle
from PySide6 import QtCore, QtTest, QtWidgets


def boxOf(widget):
    inner = widget.findChild(QtWidgets.QAbstractSpinBox)
    return inner or widget


def typeIn(host, panel, name, text):
    box = boxOf(getattr(panel.ui, name))
    panel.parent.activateWindow()
    host.process()
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, text)
    if not text:
        QtTest.QTest.keyClick(box, QtCore.Qt.Key_Delete)
    QtTest.QTest.keyClick(box, QtCore.Qt.Key_Return)
    host.process()
    return box


@pytest.mark.parametrize(
    ("text", "value"), [("7,5", 7.5), ("7.5", 7.5), ("6", 6.0), ("6,25 mm", 6.25)]
)
def test_a_comma_is_as_good_as_a_point(host, aStent, text, value):
    settle(host, aStent)
    typeIn(host, aStent, "diameterSlider", text)
    assert aStent.ui.diameterSlider.value == value
    assert aStent._parameterNode.stent.diameter == value
    assert "Expected" not in aStent.ui.statusLabel.text


@pytest.mark.parametrize("text", ["99", "0", "-3", "abc", "", "nan", "7,5,1", "1e9"])
@pytest.mark.parametrize(
    "name", ["diameterSlider", "balloonSlider", "recoilSpinBox", "flowMeanSpinBox"]
)
def test_what_does_not_fit_is_refused_with_a_sentence(host, aStent, name, text):
    settle(host, aStent)
    ui = aStent.ui
    ui.balloonCheckBox.checked = True
    ui.recoilRuleCheckBox.checked = False
    for section in ("deviceCollapsibleButton", "flowCollapsibleButton"):
        getattr(ui, section).collapsed = False
    settle(host, aStent)
    box = boxOf(getattr(ui, name))
    least, most, before = box.minimum, box.maximum, box.value
    least, most, before = (one() if callable(one) else one for one in (least, most, before))
    typeIn(host, aStent, name, text)
    number = float(text.replace(",", ".")) if text in ("99", "0", "-3", "1e9") else None
    fits = number is not None and least <= number <= most
    told = ui.statusLabel.text
    after = box.value() if callable(box.value) else box.value
    assert after == pytest.approx(number if fits else before)
    assert ("Expected" in told) == (not fits)
    if not fits:
        assert f"{least:g} to {most:g}" in told
        assert f"it stays {before:g}" in told
    if not text:
        assert "got nothing" in told


def test_no_digit_is_a_value_of_its_own(host, aStent):
    """In the application a slider's number counts every key: a stent of 12.5 mm was one of 1 mm first."""
    settle(host, aStent)
    heard = []
    aStent.ui.diameterSlider.connect("valueChanged(double)", heard.append)
    typeIn(host, aStent, "diameterSlider", "12.5")
    assert heard == [12.5]
