"""The settings of Advanced, and how far the panel's sliders reach."""

import numpy as np
import pytest


@pytest.mark.parametrize("name", ["falloff", "blend"])
def test_shapes_are_named_in_words_from_gradual_to_steep(host, aPanel, name):
    from SDFStentSlicer.PlanFields import CHOICE_LABELS

    from SDFStentLib.deformation import BLENDS, FALLOFFS

    box = getattr(aPanel.ui, name + "ComboBox")
    texts = [box.itemText(i) for i in range(box.count)]
    known = FALLOFFS if name == "falloff" else BLENDS
    assert not set(texts) & set(known)  # words, not keys
    half = {CHOICE_LABELS[name][key]: float(f(np.array([0.5]))[0]) for key, f in known.items()}
    gradual = [half[text] for text in texts if "gradual" in text]
    steep = [half[text] for text in texts if "steep" in text]
    steepest = [half[text] for text in texts if "steepest" in text]
    assert min(gradual) > max(steep)
    assert steepest in ([], [min(half.values())])
    for index in range(box.count):
        host.choose(box, index)
        assert getattr(aPanel._parameterNode.method, name) == list(known)[index]


def test_choices_are_those_of_the_library(aLogic):
    from SDFStentSlicer.PlanFields import CHOICE_LABELS

    from SDFStentLib.deformation import BLENDS, FALLOFFS, RULES, DeploymentSettings

    for known, name in ((BLENDS, "blend"), (FALLOFFS, "falloff"), (RULES, "rule")):
        assert list(CHOICE_LABELS[name]) == list(known)
        assert len(set(CHOICE_LABELS[name].values())) == len(known)
        method = aLogic.getParameterNode().method
        assert getattr(method, name) == getattr(DeploymentSettings(), name)
        for value in known:
            setattr(method, name, value)
            assert getattr(method, name) == value
        with pytest.raises(ValueError, match="one of"):
            setattr(method, name, "none of them")


@pytest.mark.parametrize(
    ("name", "widget", "usual", "wide"),
    [
        ("influenceDistance", "influenceDistanceSlider", 30.0, 40.0),
        ("tissueGap", "tissueGapSlider", 5.0, 7.0),
    ],
)
def test_a_slider_reaches_farther_only_for_a_value_that_needs_it(aStent, name, widget, usual, wide):
    slider, method = getattr(aStent.ui, widget), aStent._parameterNode.method
    assert slider.maximum == usual
    setattr(method, name, wide)
    assert (slider.maximum, slider.value) == (wide, wide)
    assert getattr(method, name) == wide
    aStent.ui.defaultsButton.click()
    assert slider.maximum == usual


def test_a_straightened_stent_is_measured_along_its_straightened_axis(aLogic, theParameters):
    """Shown and measured along one axis, that of the library; the preview takes it, too."""
    from SDFStentSlicer import Plans

    from SDFStentLib.lumen import diameter_profile
    from SDFStentLib.treatment import AxisChange, Preview, axis_in_vessel

    theParameters.method.straightening = 40.0
    inputs, planned = aLogic._inputs, Plans.plannedOf(theParameters)
    vessel, line = inputs.vessel(theParameters).surface, inputs.centerline(theParameters)
    straight, plain = (
        axis_in_vessel(planned[0], line, vessel, AxisChange(fraction)) for fraction in (0.4, 0.0)
    )
    assert straight.warnings == ()
    assert np.abs(straight.points - plain.points).max() > 0.05
    for _fraction in aLogic.steps(theParameters, live=True):
        pass
    settings = Plans.settingsOf(theParameters, live=True)
    seen = Preview(vessel, line).of(planned, settings, straightening_fraction=0.4)
    state = aLogic.lastRun(theParameters).state
    np.testing.assert_array_equal(state.coordinates, seen.coordinates)
    for _fraction in aLogic.steps(theParameters):
        pass
    run = aLogic.lastRun(theParameters)
    (drawn,), (treated,) = run.end()[1], run.result.stents
    for axis in (drawn.axis, treated.axis):
        np.testing.assert_allclose(axis.points, straight.points, atol=1e-12)
    own = diameter_profile(vessel, straight.points)
    assert treated.before.mean == pytest.approx(own.mean, abs=1e-6)
    # The narrowest place of a stent that lies at a lesion is that of the lesion.
    (lesion,) = run.lesions
    assert treated.before.minimum == lesion.before.minimum_diameter
    assert abs(treated.before.mean - diameter_profile(vessel, plain.points).mean) > 1e-4
