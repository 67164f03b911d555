"""Device, balloon, kept end and shape of the selected stent, as the logic sets them."""

from dataclasses import replace

from SDFStentLib.plan import device_named, device_table, to_document
from SDFStentLib.stent import (
    DEFAULT_FORESHORTENING,
    Balloon,
    Shape,
    balloon_by_rule,
    balloon_leaving,
)
from SDFStentLib.validation import InputError

from . import Handles, Plans, Sizes
from .ParameterNode import stentsOf
from .PlanFields import Placement
from .Portions import untilDone
from .StentList import StentList

NOT_KNOWN = float("nan")


class Fitting:
    """A part of `SDFStentLogic` whose methods change the selected stent of a parameter node at once.

    `self._inputs` are the logic's `Inputs`.
    """

    @staticmethod
    def devices(parameterNode):
        """The rows of the device table, the generic ones first, with those of the user's own table if there is one."""
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
        if device == device_table()[0]:
            usual = _usualForeshortening(parameterNode.stent)
            values = {"foreshortening": usual, "deviceShortening": False}
            self.setDetails(parameterNode, device=None, **values)
        else:
            self.setDetails(parameterNode, device=device, deviceShortening=True)

    def setBalloon(self, parameterNode, diameter, recoil=None):
        """Expand the stent with a balloon of this diameter, mm, whose recoil is a fraction, or follows the rule if it
        is None; without a diameter use no balloon.

        The rule measures the native lumen where the stent lies.
        """
        if diameter is None:
            self.setDetails(parameterNode, balloon=None)
        elif recoil is not None:
            self.inflate(parameterNode, Balloon(diameter, recoil))
        else:
            self.inflateByRule(parameterNode, diameter)
            untilDone(self.recoilByRule(parameterNode))

    def inflateByRule(self, parameterNode, diameter):
        """Expand the stent with a balloon, mm, whose recoil follows the rule; `recoilByRule` still has to apply it.

        Until then it has the recoil of the balloon before, or the usual one.
        """
        former = Sizes.balloonOf(parameterNode.stent)
        if former is None or former.is_given:
            self.inflate(parameterNode, balloon_by_rule(diameter, NOT_KNOWN))
        else:
            self.inflate(parameterNode, replace(former, diameter=diameter))

    def inflate(self, parameterNode, balloon):
        """Set the balloon and the lumen that it leaves."""
        self.setDetails(parameterNode, balloon=balloon, diameter=balloon.lumen_diameter)

    def recoilByRule(self, parameterNode):
        """Apply the rule for the recoil in the lumen where the stent lies; yields None until that is measured.

        It does nothing for a balloon whose recoil was given, or if the stent cannot lie there.
        """
        balloon = Sizes.balloonOf(parameterNode.stent)
        if balloon is None or balloon.is_given:
            return
        try:
            if (first := Sizes.dilatedBy(parameterNode)) is not None:
                self._inflateIn(parameterNode, balloon, Sizes.lumenLeft(first))
                return
            planned = Plans.plannedStent(parameterNode.stent)
            usual = balloon_by_rule(balloon.diameter, NOT_KNOWN)
            # Measured as the command does: where the stent lies with the usual recoil.
            placed = replace(planned, diameter=usual.lumen_diameter, balloon=usual, shape=None)
            native = yield from self._inputs.nativeLumenInPortions(parameterNode, placed)
        except InputError:
            return  # a deployment says why
        self._inflateIn(parameterNode, balloon, native)

    def _inflateIn(self, parameterNode, balloon, lumen):
        """Apply the rule for the recoil of a balloon in a lumen, mm. If the stent's lumen was set last, choose the
        balloon that leaves it."""
        stent = parameterNode.stent
        if not Sizes.isLumenSet(stent):
            found = balloon_by_rule(balloon.diameter, lumen)
            if found != balloon:
                self.inflate(parameterNode, found)
            return
        found = balloon_leaving(stent.diameter, lumen)
        if found != balloon:
            kept = Sizes.partOf(Balloon, stent, "balloon")
            self.setDetails(parameterNode, balloon=replace(found, diameter=kept.diameter))

    def setKept(self, parameterNode, end):
        """Keep the center, the proximal or the distal end of the stent in place when it shortens."""
        self.setDetails(parameterNode, keeps=end)

    def setShape(self, parameterNode, shape):
        """Give the stent a `Shape` of the library, or with None a cylinder. A table determines the diameter, too."""
        table = () if shape is None else shape.table
        diameter = {"diameter": max(row[1] for row in table)} if table else {}
        self.setDetails(parameterNode, shape=shape, **diameter)

    def changeShape(self, parameterNode, **parts):
        """Set parts of the stent's `Shape`; a shape without any special part becomes a cylinder."""
        shape = replace(Sizes.shapeOf(parameterNode.stent) or Shape(), **parts)
        self.setShape(parameterNode, None if shape == Shape() else shape)

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

    @staticmethod
    def setDetails(parameterNode, **changes):
        """Set values of the stent: values of the library as they are, or as documents."""
        values = {name: to_document(value) for name, value in changes.items()}
        StentList(parameterNode).change(**values)


def _usualForeshortening(stent):
    hasLength = not stent.placement.usesHandleLength
    return 100 * DEFAULT_FORESHORTENING if hasLength else 0.0
