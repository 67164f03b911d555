"""Opens *Extract Centerline*, a module of the extension SlicerVMTK."""

import slicer
from slicer.i18n import tr as _

from SDFStentLib.validation import InputError

MODULE = "ExtractCenterline"


def openFor(vessel, segmentID):
    """Open the module with a vessel chosen as its surface; in a segmentation, with a segment chosen by its ID.

    Raises `InputError` with a sentence that says what to do if the module is missing, or would see the vessel in
    another place.
    """
    if not hasattr(slicer.modules, MODULE.lower()):
        raise InputError(
            _(
                "Extract Centerline belongs to the extension SlicerVMTK, which is not installed: install it with View / Extensions "
                "Manager, restart Slicer, and click here again."
            )
        )
    if vessel.GetParentTransformNode() is not None:
        raise InputError(
            _(
                "Vessel {name}: expected one under no transform, which Extract Centerline does not look at; harden the transform "
                "first."
            ).format(name=vessel.GetName())
        )
    slicer.util.selectModule(MODULE)
    theirs = slicer.util.getModuleWidget(MODULE).ui
    theirs.inputSurfaceSelector.setCurrentNode(vessel)
    if segmentID:
        theirs.inputSegmentSelectorWidget.setCurrentSegmentID(segmentID)
