"""A centerline of another vessel: no verdict and no deployment, but a sentence."""

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import deploy, pointsOf, settle

WORDS = "not of this vessel"


def sample(phantom, name):
    from SDFStentSlicer.SampleVessels import addSampleVessel

    return addSampleVessel(phantom, name)


def moved(node, offset):
    """The same model elsewhere, hardened."""
    transform = vtk.vtkTransform()
    transform.Translate(*offset)
    node.ApplyTransform(transform)
    return node


def countIn(node):
    return node.GetPolyData().GetNumberOfPoints()


def others():
    return {
        "shape": lambda: sample("arch_with_coarctation", "Arch"),
        "place": lambda: [
            moved(n, (0, 60, 0)) for n in sample("branching_pulmonary_artery", "Far")
        ],
        "beside": lambda: [
            moved(n, (0, 9, 0)) for n in sample("branching_pulmonary_artery", "Near")
        ],
    }


@pytest.mark.parametrize("kind", others())
def test_lesions_are_not_said_to_be_none_by_a_centerline_of_another_vessel(
    host, aPanel, aVessel, kind
):
    ui = aPanel.ui
    ui.vesselSelector.setCurrentNode(aVessel[0])
    ui.centerlineSelector.setCurrentNode(others()[kind]()[1])
    settle(host, aPanel)
    assert WORDS in ui.lesionLabel.text
    assert not ui.lesionTable.visible
    assert ui.lesionLabel.visible
    host.click(ui.addStentButton)
    assert WORDS in ui.statusLabel.text
    assert not ui.lesionLabel.visible  # it is told where something was asked for
    assert len(aPanel._parameterNode.stents) == 0
    ui.centerlineSelector.setCurrentNode(aVessel[1])
    settle(host, aPanel)
    assert ui.lesionTable.rowCount == 1
    assert not ui.lesionLabel.visible


@pytest.mark.parametrize("isLive", [True, False])
@pytest.mark.parametrize("kind", others())
def test_a_vessel_that_is_changed_under_its_stents_is_shown_as_it_is(host, aStent, kind, isLive):
    ui, parameters = aStent.ui, aStent._parameterNode
    deploy(host, aStent)
    ui.autoUpdateCheckBox.checked = isLive
    settle(host, aStent)
    other = others()[kind]()[0]
    ui.vesselSelector.setCurrentNode(other)
    settle(host, aStent)
    if not isLive:
        assert ui.oldLabel.visible
        host.click(ui.deployButton)
        settle(host, aStent)
    assert WORDS in ui.statusLabel.text
    assert not ui.lesionLabel.visible  # it had been told twice
    assert not parameters.certificateSummary or not isLive
    assert "certified" not in aStent._state.atHand.text
    if isLive:
        assert aStent._state.atHand.text == ""
        np.testing.assert_allclose(pointsOf(parameters.outputVessel), pointsOf(other), atol=1e-4)
        assert countIn(parameters.outputCenterline) == 0  # it is of the former one
    former = next(
        node
        for node in slicer.util.getNodesByClass("vtkMRMLModelNode")
        if node.GetName() == "Artery"
    )
    ui.vesselSelector.setCurrentNode(former)
    settle(host, aStent)
    deploy(host, aStent)
    assert WORDS not in ui.statusLabel.text
    assert parameters.certificateSummary
    assert countIn(parameters.outputCenterline) > 0


def test_a_part_that_lies_outside_is_said(host, aPanel, aVessel):
    ui, (vessel, centerline) = aPanel.ui, aVessel
    points = pointsOf(centerline)
    root = points[0] + 12.0 * (points[0] - points[3]) / np.linalg.norm(points[0] - points[3])
    data = centerline.GetPolyData().GetPoints()
    data.SetPoint(0, *root)
    data.Modified()
    ui.vesselSelector.setCurrentNode(vessel)
    ui.centerlineSelector.setCurrentNode(centerline)
    settle(host, aPanel)
    assert WORDS not in ui.lesionLabel.text
    assert ui.lesionTable.visible


def test_only_the_chosen_vessel_and_its_centerline_stand_in_the_views(host, aStent):
    """Lines of the former vessel beside the present one would look like its own."""
    ui = aStent.ui
    own = ui.vesselSelector.currentNode(), ui.centerlineSelector.currentNode()
    deploy(host, aStent)
    other = sample("arch_with_coarctation", "Arch")
    for chosen, gone in ((other, own), (own, other)):
        host.click(ui.removeStentButton)
        ui.vesselSelector.setCurrentNode(chosen[0])
        ui.centerlineSelector.setCurrentNode(chosen[1])
        host.click(ui.addStentButton)
        deploy(host, aStent)
        output = aStent._parameterNode.outputVessel
        assert pointsOf(output).shape == pointsOf(chosen[0]).shape
        shown = [one.GetDisplayVisibility() for one in (*chosen, *gone, output)]
        assert shown == [0, 1, 0, 0, 1]  # the stented vessel stands where the chosen one was
    gone[1].SetDisplayVisibility(True)  # who wants to see both may
    ui.vesselSelector.setCurrentNode(gone[0])
    assert gone[1].GetDisplayVisibility()
