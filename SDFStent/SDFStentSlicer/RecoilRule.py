"""A balloon whose recoil is by the rule: measured anew when the balloon or the place of the stent has changed."""

from . import Clock, Conversion, Sizes
from .ParameterNode import stentOf, stentsOf
from .Portions import SteppedRun, working

SETTLE_MS = 250
"""The stent has to rest so long, so that nothing is measured while it is being dragged."""


class RecoilRule:
    """Follows the selected stent of a parameter node. A stent that comes from a plan keeps its recoil until it is changed."""

    def __init__(self, logic, onDone):
        self._logic, self._onDone = logic, onDone
        self._parameterNode, self._whose, self._what = None, None, None
        self._run = SteppedRun(lambda _value: None, self._done)
        self._timer = Clock.timer(self._begin, SETTLE_MS)

    @property
    def isBusy(self):
        """Whether a lumen is being measured, or about to be."""
        return self._run.isRunning or self._timer.isActive()

    def follow(self, parameterNode):
        """Look at what is selected now, of a parameter node or of none; called whenever it may have changed."""
        whose, what = _standing(parameterNode)
        isSame = parameterNode is self._parameterNode and whose == self._whose
        if isSame and what == self._what:
            return
        self._cancel()
        self._parameterNode, self._whose, self._what = parameterNode, whose, what
        if isSame and what is not None:
            self._timer.start()

    def hurry(self):
        """Begin now what would begin after a longer rest; returns whether a lumen is being measured."""
        if self._timer.isActive():
            self._timer.stop()
            self._begin()
        return self._run.isRunning

    def finish(self):
        """Do at once what is about to be done."""
        if self.isBusy:
            self._cancel()
            for _part in self._logic.recoilByRule(self._parameterNode):
                pass

    def _cancel(self):
        self._timer.stop()
        self._run.cancel()

    def _begin(self):
        self._run.start(working(self._logic.recoilByRule(self._parameterNode)))

    def _done(self, error):
        self._onDone(error)


def _standing(parameterNode):
    """Which stent is selected, and on what the recoil of its balloon depends; None where that is no matter of the rule."""
    if parameterNode is None or not stentsOf(parameterNode):
        return None, None
    stent = stentOf(parameterNode)
    whose = (parameterNode.selected, stent.handle.GetID() if stent.handle is not None else None)
    balloon = Sizes.balloonOf(stent)
    if balloon is None or balloon.is_given:
        return whose, None
    length, handle = Sizes.lengthOf(stent), Conversion.changeStamp(stent.handle)
    place = (str(stent.entry["placement"]), length, stent.wholeCurve, handle)
    inputs = Conversion.inputStamp(parameterNode)
    wide = (stent.diameter, None) if Sizes.isLumenSet(stent) else (None, balloon.diameter)
    return whose, (wide, stent.foreshortening, place, inputs)
