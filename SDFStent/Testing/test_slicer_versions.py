"""What the module must not lean on, because not every Slicer since 5.10.0 has it."""

import types
import typing


def writesOf(slider):
    """The values that are written to a slider from now on."""
    written, check = [], slider.checked_value

    def checked(name, value):
        if name == "value":
            written.append(value)
        return check(name, value)

    slider.checked_value = checked
    return written


def test_a_change_is_shown_once_however_often_the_panel_was_visited(host, aStent):
    parameters = aStent._parameterNode
    for _ in range(30):
        aStent.exit()
        aStent.enter()
    assert aStent._parameterNode is parameters
    written = writesOf(aStent.ui.expansionSlider)
    parameters.expansion = 40.0
    assert written == [40.0]


def test_a_parameter_set_that_was_left_hears_of_nothing(host, aPanel):
    parameters, written = aPanel._parameterNode, writesOf(aPanel.ui.expansionSlider)
    aPanel.exit()
    parameters.expansion = 40.0
    assert written == []
    aPanel.enter()
    assert aPanel.ui.expansionSlider.value == 40.0


def test_node_types_are_optional_in_the_way_that_every_python_tells_apart(theModule):
    from SDFStentSlicer.ParameterNode import SDFStentParameterNode

    hints = typing.get_type_hints(SDFStentParameterNode, include_extras=True)
    assert [n for n, hint in hints.items() if isinstance(hint, types.UnionType)] == []


def test_the_module_needs_no_class_of_modules_that_are_loaded_after_it(host, theModule):
    import slicer
    from sdfstent_host.host import withoutLaterModules

    with withoutLaterModules("SDFStent"):
        assert not hasattr(slicer, "vtkSlicerSegmentationsModuleLogic")
        assert hasattr(slicer, "vtkMRMLMarkupsFiducialNode")
    assert hasattr(slicer, "vtkSlicerSegmentationsModuleLogic")
    assert theModule.python.SDFStentWidget
