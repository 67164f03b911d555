"""Vessel and centerline that a transform moves after stents were placed: handles and results go along, or it is said what did not."""

import numpy as np
import pytest
from panel_helpers import deploy, pointsOf, settle
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform


def aMotion(seed):
    """A turn and a shift, (4, 4)."""
    rng = np.random.default_rng(seed)
    turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = turned * np.sign(np.linalg.det(turned))
    matrix[:3, 3] = rng.uniform(-80, 80, 3)
    return matrix


def asVtk(matrix):
    result = vtkMatrix4x4()
    result.DeepCopy(matrix.ravel().tolist())
    return result


def at(handle):
    return np.array(handle.GetNthControlPointPositionWorld(0))


@pytest.fixture
def aTransform(host, aStent, aScene):
    """A transform above vessel and centerline, before anything is placed below it."""
    node = aScene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    for one in (aStent._parameterNode.vessel, aStent._parameterNode.centerline):
        one.SetAndObserveTransformNodeID(node.GetID())
    settle(host, aStent)
    return node


@pytest.mark.parametrize("isLive", [False, True])
def test_handles_and_results_go_along(host, aStent, aTransform, isLive):
    parameters, motion = aStent._parameterNode, aMotion(1)
    deploy(host, aStent)
    other = aStent.logic.duplicatePlan(parameters)
    handles = [plan.stents[0].handle for plan in (parameters, other)]
    line, wall = map(pointsOf, (parameters.outputCenterline, parameters.outputVessel))
    before = list(map(at, handles))
    aStent.ui.autoUpdateCheckBox.checked = isLive
    aTransform.SetMatrixTransformToParent(asVtk(motion))
    settle(host, aStent)
    for handle, former in zip(handles, before, strict=True):
        np.testing.assert_allclose(at(handle), motion[:3, :3] @ former + motion[:3, 3], atol=1e-4)
    for node, former in ((parameters.outputCenterline, line), (parameters.outputVessel, wall)):
        moved = former @ motion[:3, :3].T + motion[:3, 3]
        # Deployed anew where it is, the wall may differ by what rounding leads to.
        np.testing.assert_allclose(pointsOf(node), moved, atol=0.05 if isLive else 1e-3)
    assert "expected" not in aStent.ui.statusLabel.text
    deploy(host, aStent)
    host.process(0.5)
    assert parameters.certificateSummary
    assert not aStent.ui.undoButton.enabled  # what was before lies elsewhere


def test_what_is_hardened_or_put_below_the_same_transform_moves_once(host, aStent, aTransform):
    parameters, motion = aStent._parameterNode, aMotion(2)
    handle, former = parameters.stent.handle, at(parameters.stent.handle)
    aTransform.SetMatrixTransformToParent(asVtk(motion))
    settle(host, aStent)
    moved = motion[:3, :3] @ former + motion[:3, 3]
    for node in (parameters.vessel, parameters.centerline):
        node.HardenTransform()
    settle(host, aStent)
    np.testing.assert_allclose(at(handle), moved, atol=1e-4)
    for node in (parameters.vessel, parameters.centerline, handle):
        node.SetAndObserveTransformNodeID(aTransform.GetID())
    settle(host, aStent)
    np.testing.assert_allclose(at(handle), motion[:3, :3] @ moved + motion[:3, 3], atol=1e-4)
    aTransform.SetMatrixTransformToParent(vtkMatrix4x4())
    settle(host, aStent)
    np.testing.assert_allclose(at(handle), moved, atol=1e-4)


def test_a_handle_that_is_left_behind_is_named(host, aStent, aTransform, aScene):
    parameters = aStent._parameterNode
    own = aScene.AddNewNodeByClass("vtkMRMLMarkupsFiducialNode", "Mine")
    place = at(parameters.stent.handle)
    own.AddControlPointWorld(*place)
    aStent.ui.handleSelector.setCurrentNode(own)
    settle(host, aStent)
    aTransform.SetMatrixTransformToParent(asVtk(aMotion(3)))
    settle(host, aStent)
    np.testing.assert_allclose(at(own), place)
    told = aStent.ui.statusLabel.text
    assert "was moved by its transform" in told
    assert "Mine" in told


def test_a_transform_that_bends_is_told(host, aStent, aScene):
    parameters = aStent._parameterNode
    bend = vtkThinPlateSplineTransform()
    node = aScene.AddNewNodeByClass("vtkMRMLTransformNode")
    node.SetAndObserveTransformToParent(bend)
    for one in (parameters.vessel, parameters.centerline):
        one.SetAndObserveTransformNodeID(node.GetID())
    settle(host, aStent)
    assert "was moved by its transform" in aStent.ui.statusLabel.text
    assert "Stent 1" in aStent.ui.statusLabel.text
