"""What the module must not lean on, because not every Slicer since 5.10.0 has it."""

import types
import typing


def writesOf(parameters, name, shown):
    """Count what is written to every widget that shows a parameter now."""
    for bound in parameters._bindings.values():
        connector = bound[name]

        def counted(value, write=connector.write):
            shown.append(value)
            write(value)

        connector.write = counted


def test_a_change_is_shown_once_however_often_the_panel_was_visited(host, aStent):
    parameters, shown = aStent._parameterNode, []
    for _ in range(30):
        aStent.exit()
        aStent.enter()
    assert aStent._parameterNode is parameters
    writesOf(parameters, "method.tissueGap", shown)
    parameters.method.tissueGap = 1.5
    assert aStent.ui.tissueGapSlider.value == 1.5
    assert shown == [1.5]


def test_a_parameter_set_that_was_left_hears_of_nothing(host, aPanel):
    parameters, shown = aPanel._parameterNode, []
    writesOf(parameters, "showStents", shown)
    aPanel.exit()
    parameters.showStents = False
    assert shown == []
    aPanel.enter()
    assert not aPanel.ui.showStentCheckBox.checked


def test_node_types_are_optional_in_the_way_that_every_python_tells_apart(theModule):
    from SDFStentSlicer.ParameterNode import SDFStentParameterNode, StentParameters

    for cls in (SDFStentParameterNode, StentParameters):
        hints = typing.get_type_hints(cls, include_extras=True)
        assert [n for n, hint in hints.items() if isinstance(hint, types.UnionType)] == []


def test_the_module_needs_no_class_of_modules_that_are_loaded_after_it(host, theModule):
    import slicer
    from sdfstent_host.host import withoutLaterModules

    with withoutLaterModules("SDFStent"):
        assert not hasattr(slicer, "vtkSlicerSegmentationsModuleLogic")
        assert hasattr(slicer, "vtkMRMLMarkupsFiducialNode")
    assert hasattr(slicer, "vtkSlicerSegmentationsModuleLogic")
    assert theModule.python.SDFStentWidget
