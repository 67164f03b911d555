"""What is shown in place of something else: a node, or of a segmentation one segment in 3D."""

ONE_COLOR = "SDFStent.OneColor"


def inOneColor(*nodes):
    """Show models without the colors of the arrays that they happen to have: once, for who wants them turns them on again."""
    for node in nodes:
        isModel = node is not None and node.IsA("vtkMRMLModelNode") and node.GetDisplayNode()
        if isModel and not node.GetAttribute(ONE_COLOR):
            node.SetAttribute(ONE_COLOR, "1")
            node.GetDisplayNode().SetScalarVisibility(False)


def isShown(node, segmentID=""):
    """Whether a node can be seen; None for one that nothing shows, and for a segment that is gone."""
    display = node.GetDisplayNode()
    if display is None or not _has(node, segmentID):
        return None
    return bool(display.GetSegmentVisibility3D(segmentID) if segmentID else display.GetVisibility())


def setShown(node, isVisible, segmentID=""):
    """Show a node, or hide it. The outline of a segment stays in the slice views, and so do the other segments."""
    if isShown(node, segmentID) == (not isVisible):
        display = node.GetDisplayNode()
        if segmentID:
            display.SetSegmentVisibility3D(segmentID, isVisible)
        else:
            display.SetVisibility(isVisible)


def changeOver(node, attribute, isVisible, segmentID=""):
    """Show or hide a node that was not, and remember that."""
    if isShown(node, segmentID) == (not isVisible):
        setShown(node, isVisible, segmentID)
        node.SetAttribute(attribute + segmentID, "1")


def changeBack(node, attribute, isVisible, segmentID=""):
    """Show or hide a node again of which the opposite was remembered."""
    if node.GetAttribute(attribute + segmentID):
        node.RemoveAttribute(attribute + segmentID)
        setShown(node, isVisible, segmentID)


def _has(node, segmentID):
    return not segmentID or node.GetSegmentation().GetSegment(segmentID) is not None
