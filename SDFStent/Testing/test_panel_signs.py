"""Small signs: what is off, of which plan something is, what a heading names, where a legend is."""

import numpy as np
import slicer
from panel_helpers import deploy, settle


def test_a_stent_that_is_off_is_seen_to_be(host, aStent):
    ui, parameters = aStent.ui, aStent._parameterNode
    host.click(ui.copyStentButton)
    aStent._onEnableStent(0, False)
    settle(host, aStent)
    assert [ui.stentTable.item(row, 3).text() for row in (0, 1)] == [
        "switched off",
        "Middle at a point",
    ]
    first, second = (stent.handle.GetDisplayNode().GetOpacity() for stent in parameters.stents)
    assert first < 0.5 * second
    aStent._onEnableStent(0, True)
    settle(host, aStent)
    assert parameters.stents[0].handle.GetDisplayNode().GetOpacity() == second
    assert ui.stentTable.item(0, 3).text() == "Middle at a point"


def test_a_heading_names_what_is_missing(host, aStent, aScene):
    heading = aStent.ui.inputsCollapsibleButton
    assert heading.text == "Vessel: Artery, Artery centerline"
    aScene.RemoveNode(aStent._parameterNode.vessel)
    host.process()
    assert heading.text == "Vessel: none, Artery centerline"
    aScene.RemoveNode(aStent._parameterNode.centerline)
    host.process()
    assert heading.text == "Vessel"


def test_whole_curve_is_asked_of_curves_only(host, aStent):
    box = aStent.ui.wholeCurveCheckBox
    aStent.ui.placeCollapsibleButton.collapsed = False
    for index, isCurve in ((0, False), (3, False), (4, True), (0, False)):
        host.choose(aStent.ui.placementComboBox, index)
        assert box.visible == isCurve, aStent.ui.placementComboBox.currentText


def test_results_are_called_by_their_plan(host, aStent):
    deploy(host, aStent)
    host.click(aStent.ui.duplicatePlanButton)
    aStent.ui.diameterSlider.value = 6.0
    deploy(host, aStent)
    parameters = aStent._parameterNode
    assert parameters.parameterNode.GetName() == "Plan 2"
    for role, name in (
        ("outputVessel", "Stented vessel"),
        ("outputStents", "Stents"),
        ("outputCenterline", "Stented centerline"),
        ("outputTable", "Stent diameters"),
        ("outputTexts", "Stent diameters to read"),
    ):
        assert getattr(parameters, role).GetName() == f"{name}, Plan 2"


def test_a_legend_is_shown_where_its_digits_can_be_read(host, aStent, aScene):
    deploy(host, aStent)
    aStent.ui.mapComboBox.currentIndex = 1
    host.process()
    output = aStent._parameterNode.outputVessel
    legend = slicer.vtkSlicerColorLogic.GetColorLegendDisplayNode(output)
    views = slicer.util.getNodesByClass("vtkMRMLViewNode")
    assert views
    assert [legend.GetNthViewNodeID(n) for n in range(legend.GetNumberOfViewNodeIDs())] == [
        one.GetID() for one in views
    ]


def test_diameters_have_two_decimals(host, aStent):
    deploy(host, aStent)
    table = aStent._parameterNode.outputTable
    values = slicer.util.arrayFromTableColumn(table, "After (mm)")
    known = values[np.isfinite(values)]
    np.testing.assert_allclose(known, known.round(2), rtol=0, atol=1e-12)


def test_the_table_to_read_has_the_same_numbers_and_nothing_where_none_is_known(host, aStent):
    """Slicer's view writes what a column's variants are as texts: "nan" where a number is none."""
    deploy(host, aStent)
    host.click(aStent.ui.showTableButton)
    parameters = aStent._parameterNode
    numbers, shown = parameters.outputTable, parameters.outputTexts
    columns = range(numbers.GetNumberOfColumns())
    names = [numbers.GetColumnName(column) for column in columns]
    assert [shown.GetColumnName(column) for column in columns] == names
    empty = 0
    for column, name in enumerate(names):
        values = slicer.util.arrayFromTableColumn(numbers, name)
        table = shown.GetTable()
        texts = [table.GetValue(row, column).ToString() for row in range(table.GetNumberOfRows())]
        assert len(texts) == len(values)
        for text, value in zip(texts, values, strict=True):
            assert text == ("" if np.isnan(value) else f"{value + 0.0:.2f}")
            empty += not text
        assert shown.GetColumnTitle(name) == name.removesuffix(" (mm)")
        assert shown.GetColumnUnitLabel(name) == "mm"
    assert empty > 0  # beyond the stent nothing is prescribed
    assert shown.GetLocked()
    assert shown.GetDescription() == numbers.GetDescription()


def test_every_sample_has_a_picture_of_its_own(theModule):
    from pathlib import Path

    import SampleData

    sources = SampleData.SampleDataLogic.sampleDataSourcesByCategory("SDF Stent")
    pictures = [Path(source.thumbnailFileName) for source in sources]
    assert all(one.is_file() for one in pictures)
    assert len({one.read_bytes() for one in pictures}) == len(pictures) == 2
