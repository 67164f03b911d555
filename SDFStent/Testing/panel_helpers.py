"""What several tests of the module ask for."""

import numpy as np


def theThroat():
    """The narrowest place of the pulmonary artery."""
    from benchmarks.phantoms import branching_pulmonary_artery

    return branching_pulmonary_artery().throat.point


def settle(host, panel):
    """Let a panel run until nothing is under way or about to start."""
    busy = panel.session, panel.lesions
    host.processUntil(lambda: not (panel._suggesting.isRunning or any(one.isBusy for one in busy)))


def suggest(host, panel):
    """Click Suggest and wait for the stent."""
    host.click(panel.ui.suggestButton)
    host.processUntil(lambda: not panel._suggesting.isRunning)


def planned(panel):
    """The library's stents of the plan that the panel shows."""
    from SDFStentSlicer import Plans

    return Plans.plannedOf(panel._parameterNode)


def pointsOf(node):
    """Points of a model as they are now, (n, 3)."""
    import slicer

    return np.array(slicer.util.arrayFromModelPoints(node))


def clickSample(name):
    """A click on the picture of a sample in Sample Data; its vessel and centerline."""
    import SampleData

    sources = SampleData.SampleDataLogic.sampleDataSourcesByCategory("SDF Stent")
    (source,) = (source for source in sources if source.sampleName == name)
    return source.customDownloader(source)


def offered(selector):
    """Names of the nodes that a selector offers."""
    return [node.GetName() for node in selector.nodes()]


def deploy(host, panel):
    """Click Deploy and wait for the numbers."""
    host.click(panel.ui.deployButton)
    settle(host, panel)


def expanded(logic, parameters):
    """Deploy all stents and measure nothing, for tests that look at the wall; all its points, (n, 3)."""
    parameters.lumenSummary = ""
    steps = logic.steps(parameters)
    # Ends: it says that nothing is measured yet when all are in place.
    while not parameters.lumenSummary:
        next(steps)
    steps.close()
    return logic.lastRun(parameters).points


def saveAsFile(node, path, frame):
    """Write a model to a file in a frame, RAS or LPS, and let the node know where it is kept."""
    import slicer

    storage = slicer.vtkMRMLModelStorageNode()
    slicer.mrmlScene.AddNode(storage)
    node.SetAndObserveStorageNodeID(storage.GetID())
    storage.SetFileName(str(path))
    storage.SetCoordinateSystem(storage.GetCoordinateSystemTypeFromString(frame))
    assert storage.WriteData(node)


def handleNames(scene):
    """Of the handles that a user sees in a scene, in order."""
    import slicer

    nodes = slicer.util.getNodesByClass("vtkMRMLMarkupsFiducialNode", scene)
    return [node.GetName() for node in nodes if not node.GetHideFromEditors()]
