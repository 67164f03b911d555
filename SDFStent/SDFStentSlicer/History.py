"""Former states of a plan: its stents and its method go back, and forth again."""

from SDFStentLib.validation import InputError

from . import Clock, Plans
from .ParameterNode import stentsOf
from .Transforms import matrixToWorld

SETTLE_MS = 400
"""A plan has to rest so long to be kept: all that a hand does at one go is one step."""
MOST = 100


class History:
    """The documents of one plan in one vessel; `note` keeps another one where the plan has changed.

    The files of its inputs are no part of that: a scene that is saved or loaded has others.
    """

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode
        self._steps, self._at = [], -1
        self.note()  # what is done at once is taken back, too

    def note(self):
        """Keep the plan as it is now; returns whether it could be. A plan whose stents are not all placed is kept once they are."""
        try:
            step = self._stepNow()
        except InputError:
            return False
        if self._at >= 0 and step[0] == self._steps[self._at][0]:
            self._steps[self._at] = step
        else:
            self._steps = [*self._steps[: self._at + 1], step][-MOST:]
            self._at = len(self._steps) - 1
        return True

    def _stepNow(self):
        """The plan without its files, by which it is compared, and with them; and the balloons as they were set."""
        texts = (Plans.textOf(self.parameterNode, hasFiles) for hasFiles in (False, True))
        balloons = [stent.draft.entry["balloon"] for stent in stentsOf(self.parameterNode)]
        return *texts, balloons

    @property
    def document(self):
        """The text of the plan that was kept last, "" before the first."""
        return self._steps[self._at][1] if self._steps else ""

    def mayGo(self, steps):
        """Whether a plan so many steps before this one, or behind it, is kept."""
        return 0 <= self._at + steps < len(self._steps)

    def go(self, steps):
        """Make the plan as it was so many steps before, or as it is behind."""
        if not self.note():
            steps = max(steps, 0)  # back to what was kept last
        if self.mayGo(steps):
            self._at += steps
            _, text, balloons = self._steps[self._at]
            Plans.restore(text, self.parameterNode)
            # The text has a lumen and the balloon that leaves it, and not which of them was set last.
            asSet = {f"stents.{at}.balloon": one for at, one in enumerate(balloons)}
            self.parameterNode.change(asSet)
            self._steps[self._at] = self._stepNow()


class HistoryButtons:
    """*Undo* and *Redo*. `onKept(document)` hears of every plan that is kept.

    `isAwaited()` tells whether what was done goes on to change the plan, as a recoil by the rule does: that is no step of its own.
    """

    def __init__(self, ui, _logic, attempt):
        self.onKept, self.isAwaited = lambda _document: None, lambda: False
        self.ui, self._attempt = ui, attempt
        self._histories, self._history = {}, None
        self._joined = {}
        self._timer = Clock.timer(self._settle, SETTLE_MS)
        ui.undoButton.connect("clicked()", lambda: self._go(-1))
        ui.redoButton.connect("clicked()", lambda: self._go(1))

    def show(self, parameterNode):
        """Show a parameter node, whose plan may have changed."""
        key = self._keyOf(parameterNode)
        history = self._histories.get(key)
        if history is None or history.parameterNode is not parameterNode:
            history = self._histories[key] = History(parameterNode)
        self._history = history
        self._timer.start()
        self._offer()

    def restart(self):
        """Forget what was before: it lies elsewhere."""
        plan = self._history.parameterNode
        self._history = self._histories[self._keyOf(plan)] = History(plan)
        self._offer()

    def join(self, former):
        """Let *Undo* lead back to a former centerline, or None, in whose place another one was made, and *Redo* to that."""
        plan = self._history.parameterNode
        made = plan.centerline
        self._joined[-1, self._keyOf(plan, made)] = former
        self._joined[1, self._keyOf(plan, former)] = made
        self._offer()

    @staticmethod
    def _keyOf(parameterNode, *centerline):
        inputs = parameterNode.vessel, *(centerline or [parameterNode.centerline])
        return (parameterNode.parameterNode.GetID(), *map(_placeOf, inputs))

    def keep(self):
        """Keep the plan as it is, if it was not yet: something else is done to it now."""
        if self._timer.isActive():
            self._note()

    def _settle(self):
        if self.isAwaited():
            self._timer.start()
        else:
            self._note()

    def _note(self):
        self._timer.stop()
        if self._history.parameterNode.parameterNode.GetScene() is not None:
            self._history.note()
            self._tell()

    def _go(self, steps):
        self.keep()
        if self._history.mayGo(steps):
            self._attempt(lambda: self._history.go(steps))
        elif self._leadsOn(steps):
            plan = self._history.parameterNode
            plan.centerline = self._joined[steps, self._keyOf(plan)]
        self._tell()

    def _leadsOn(self, steps):
        """Whether a step leads to another centerline, which is still there."""
        key = steps, self._keyOf(self._history.parameterNode)
        node = self._joined.get(key)
        return key in self._joined and (node is None or node.GetScene() is not None)

    def _tell(self):
        if self._history.document:
            self.onKept(self._history.document)
        self._offer()

    def _offer(self):
        for button, steps in ((self.ui.undoButton, -1), (self.ui.redoButton, 1)):
            button.enabled = self._history.mayGo(steps) or self._leadsOn(steps)


def _placeOf(node):
    """Identity of a node and its matrix to world: what was kept elsewhere would come back beside it."""
    if node is None:
        return None
    matrix = matrixToWorld(node)
    return node.GetID(), None if matrix is None else matrix.tobytes()
