"""Device, balloon, kept end and shape of the selected stent, as the logic sets them."""

from SDFStentLib.plan import (
    by_rule,
    device_named,
    device_table,
    earlier_of,
    in_lumen,
    inflated,
    shaped,
    with_device,
    with_usual_recoil,
)
from SDFStentLib.validation import InputError

from . import Conversion, Handles, Plans
from .ParameterNode import stentOf, stentsOf
from .PlanFields import Placement
from .Portions import untilDone
from .StentList import StentList


class Fitting:
    """A part of `SDFStentLogic` whose methods change the selected stent of a parameter node at once.

    What follows from a value, as a lumen from a balloon, the library says. `self._inputs` are the logic's `Inputs`.
    """

    @staticmethod
    def devices(parameterNode):
        """Rows of the device table, the generic ones first, and of the user's own table, if any."""
        return device_table(parameterNode.deviceTable or None)

    def setDeviceTable(self, parameterNode, path):
        """Use a table of the user's own, too, or with "" none any more; raises `InputError` for one that cannot be
        read."""
        device_table(path or None)
        parameterNode.deviceTable = str(path)

    def setDevice(self, parameterNode, device):
        """Give the stent a device, by its name in the table or as the library's `Device`.

        The stent gets the device's length, if that has one, and its shortening; its own length is kept for another
        device. The generic row stands for no device: the shortening is set by the user.
        """
        if isinstance(device, str):
            device = device_named(device, parameterNode.deviceTable or None)
        isGeneric = device == device_table()[0]
        self._set(parameterNode, with_device, None if isGeneric else device)

    def setBalloon(self, parameterNode, diameter, recoil=None):
        """Expand the stent with a balloon of this diameter, mm, whose recoil is a fraction, or follows the rule if it
        is None; without a diameter use no balloon.

        The rule measures the native lumen where the stent lies.
        """
        self._set(parameterNode, inflated, diameter, recoil)
        untilDone(self.recoilByRule(parameterNode))

    @staticmethod
    def recoilStanding(parameterNode):
        """Whose recoil the rule may change, and on what that depends; None where that is no matter of the rule.

        A stent that comes from a plan keeps its recoil until it is changed.
        """
        if parameterNode is None or not stentsOf(parameterNode):
            return None, None
        stent = stentOf(parameterNode)
        node, handle = parameterNode.parameterNode.GetID(), stent.handle
        whose = (node, parameterNode.selected, handle and handle.GetID())
        known = by_rule(stent.draft)
        place = Conversion.changeStamp(handle), Conversion.inputStamp(parameterNode)
        return whose, known and (*known, *place)

    def recoilByRule(self, parameterNode):
        """Apply the rule for the recoil in the lumen where the stent lies; yields None until that is measured.

        It does nothing for a balloon whose recoil was given, or if the stent cannot lie there.
        """
        stent = parameterNode.stent
        if by_rule(stent.draft) is None:
            return
        stents = stentsOf(parameterNode)
        drafts, handles = [one.draft for one in stents], [one.handle for one in stents]
        first = earlier_of(drafts, handles, parameterNode.selected)
        try:
            if first is not None:
                native = first.final.diameter
            else:
                # Measured as the command does: where the stent lies with the usual recoil.
                lying = with_usual_recoil(stent.draft, Plans.placeOf(stent))
                native = yield from self._inputs.nativeLumenInPortions(parameterNode, lying)
        except InputError:
            return  # a deployment says why
        self._set(parameterNode, in_lumen, native)

    def setKept(self, parameterNode, end):
        """Keep the center, the proximal or the distal end of the stent in place when it shortens."""
        self._set(parameterNode, lambda _stent: {"keeps": end})

    def setShape(self, parameterNode, shape):
        """Give the stent a `Shape` of the library, or with None a cylinder. A table determines the diameter, too."""
        self._set(parameterNode, shaped, shape)

    @staticmethod
    def _set(parameterNode, changesOf, *values):
        """Set what a function of the library says that changes in the `Draft` of the selected stent."""
        changes = changesOf(parameterNode.stent.draft, *values)
        if changes:
            StentList(parameterNode).change(**changes)

    @staticmethod
    def shareHandle(parameterNode):
        """Give a stent that dilates another one again the handle of the stent above it, and any other stent a handle
        of its own.

        Returns whether it dilates another one again.
        """
        stent, stents = parameterNode.stent, StentList(parameterNode)
        above = stentsOf(parameterNode)[: parameterNode.selected]
        originals = [one.handle for one in above if one.placement != Placement.AGAIN]
        if stent.placement != Placement.AGAIN:
            if stent.handle is not None and stent.handle in originals:
                stents.change(handle=Handles.copyHandle(stent.handle, stent.label))
            return False
        former = stent.handle
        handle = former if former in originals or not originals else originals[-1]
        stents.change(handle=handle, foreshortening=0.0, deviceShortening=True)
        if former not in [one.handle for one in parameterNode.stents]:
            Handles.removeHandle(former)
        return True
