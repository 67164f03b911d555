"""When to deploy: on request, and again while something changes."""

import math
import time

from SDFStentLib.deformation import NEARLY_DONE

from . import Clock, Portions, Showing
from .Portions import SteppedRun

COALESCE_MS = 0
"""A change waits until the application has handled what else has arrived; a longer or restarted wait would starve a fast drag."""

REST_MS = 20
"""A hand that has rested so long, a frame, may have stopped: the full method begins. Nothing is seen of it yet."""

LATE = 1.5
"""Ratio of a rest to its time beyond which a frame was drawn in it."""

SETTLE_MS = 100
"""A hand that rests so long from then on has stopped, for now: the panel says that it deploys."""

MOST_LEFT = 1
"""Largest number of abandoned calculations that still run with which a full method begins by itself."""


class DeploySession:
    """A deployment at a time, never re-entrant; the latest values always win.

    A change that arrives while a deployment runs is remembered: a preview is finished first, so that something is seen while
    the user drags; the full method is dropped. After the end the inputs are compared with those of the run, so the final state is
    never lost. While the user drags the library's preview runs; once nothing has changed for a frame, the full method with
    measurements and certificate begins, unseen; once nothing has changed for a moment, it takes the preview's place. Where a hand
    lets go the full method begins at once, and what it has grown is seen as a preview.
    """

    def __init__(
        self,
        logic,
        onStart,
        onProgress,
        onDone,
        beforeAny=lambda: None,
        beforeFull=lambda: False,
        finishBefore=lambda: None,
    ):
        """`beforeAny()` is called before it is looked at what there is to deploy; `beforeFull()` when a hand rests, and tells whether
        something that may change the plan is still under way: the full method would begin in vain. `finishBefore()` does that at
        once."""
        self._logic, self._onStart, self._onDone = logic, onStart, onDone
        self._beforeAny, self._beforeFull = beforeAny, beforeFull
        self._finishBefore = finishBefore
        self._parameterNode = self._signature = None
        self._run, self._onProgress = SteppedRun(self._progressed, self._finished), onProgress
        self._live = self._isQuiet = self._isAtOnce = self._isSeen = False
        self._timer = Clock.timer(self._updateInOneFrame, COALESCE_MS)
        self._frame, self._drawing = Showing.HeldFrame(), Showing.QuickDrawing()
        self._restTimer, self._restsFrom = Clock.timer(self._rested, REST_MS), 0.0
        self._settleTimer = Clock.timer(self._settle, SETTLE_MS)

    @property
    def isRunning(self):
        return self._run.isRunning

    @property
    def _isGrowing(self):
        """Whether a preview is under way that nothing is seen of yet."""
        return self.isRunning and self._live and not self._isSeen

    @property
    def isPreview(self):
        """Whether what runs, or ran last, is the quick method, or the full one for a hand that may go on."""
        return self._isQuiet

    @property
    def isBusy(self):
        """Whether something runs or is about to."""
        return self.isRunning or self._timer.isActive() or self._restTimer.isActive()

    @property
    def mayBeCancelled(self):
        """Whether something runs, or begins by itself where nothing changes any more."""
        return self.isRunning or self._restTimer.isActive()

    def isRenewing(self, standing):
        """Whether the results are being renewed, or will be without a click; `standing` is that of the parameter node."""
        if self.isRunning or self._restTimer.isActive():
            return True
        return self._isNew(standing) and self._parameterNode.autoUpdate

    def setParameterNode(self, parameterNode):
        """Work for another parameter node, or for none; whatever runs is stopped."""
        self.cancel()
        self._parameterNode, self._signature = parameterNode, None

    def start(self):
        """Deploy now, in full."""
        self._beforeAny()
        self._stop()
        self._begin(live=False)

    def request(self):
        """Deploy soon if something that matters has changed since the last deployment began; what has changed is drawn with that."""
        if not self._timer.isActive():
            self._timer.start()
        if not self._isGrowing:  # else it may be what that shows, to be seen now
            self._frame.hold()

    def letGo(self):
        """Deploy in full at once what a hand has let go of, without the previews that would have come before."""
        self._beforeAny()
        if self._parameterNode is None or not self._parameterNode.autoUpdate:
            return
        isAlone = len(self._logic.places(self._parameterNode)) == 1  # else a preview is far quicker
        if not isAlone or Portions.countLeft() > MOST_LEFT:
            return
        self._finishBefore()
        standing = self._standing()
        if not self._isNew(standing):
            return
        self._stopRun()
        self._frame.hold()  # for a moment: what has grown may be drawn with it
        self._settleTimer.start()
        self._begin(False, standing, isAtOnce=True)

    def followFlow(self):
        """Tell the results for another flow, where that was set; after what is under way."""
        if self._parameterNode is None or self.isBusy:
            return
        if self._logic.isFlowOld(self._parameterNode):
            self._live = self._isQuiet = False
            self._run.start(self._logic.tellFlow(self._parameterNode))
            self._onStart()

    def cancel(self):
        """Stop at once; what is shown stays."""
        self._stop()
        self._rest()

    def _stop(self):
        self._stopRun()
        self._frame.release()

    def _stopRun(self):
        for timer in (self._timer, self._restTimer, self._settleTimer):
            timer.stop()
        self._run.cancel()

    def _rest(self):
        """Show all as well as it can be, when nothing more is coming."""
        if self._parameterNode is not None and not self.isBusy:
            self._logic.showOutline(self._parameterNode)
            self._drawing.end()

    def _standing(self):
        return self._logic.standing(self._parameterNode)

    def _isNew(self, standing):
        """Whether there is something to deploy that the last deployment, finished or not, did not begin with."""
        if self._parameterNode is None or standing.missing:
            return False
        return standing.signature != self._signature

    def _updateInOneFrame(self):
        try:
            self._beforeAny()
            self._update()
        finally:
            if not (self.isRunning and self._live):  # else what was moved is seen with its preview
                self._frame.release()

    def _update(self):
        standing = self._parameterNode and self._standing()
        if standing is None or not self._isNew(standing):
            self._rest()
            self.followFlow()
            return
        if self.isRunning:
            if self._live:
                return  # looked at again when the run ends
            self._stop()
        self._begin(True, standing)

    def _beginRest(self):
        self._restsFrom = time.perf_counter()
        self._restTimer.start()

    def _rested(self):
        if time.perf_counter() - self._restsFrom > LATE * REST_MS / 1000:
            self._restsFrom = (
                math.inf
            )  # the application was away: what the hand did meanwhile it hears next
            self._restTimer.start()
        elif Portions.countLeft() > MOST_LEFT or self._beforeFull():
            self._restTimer.start()
        elif not self.isRunning and not self._isNew(standing := self._standing()):
            self._settleTimer.start()
            self._begin(False, standing)
        self._rest()

    def _settle(self):
        self._frame.release()  # a large vessel takes long to grow, and a view that stands still looks broken
        self._isQuiet = False
        self._onStart()

    def _begin(self, live, standing=None, isAtOnce=False):
        standing = standing or self._standing()
        self._restTimer.stop()
        mayGoOn = self._settleTimer.isActive
        wasQuiet, self._isQuiet = self._isQuiet, live or mayGoOn()
        self._signature, self._live, self._isAtOnce = standing.signature, live, isAtOnce
        self._isSeen = False
        self._drawing.begin()
        self._run.start(
            self._logic.steps(self._parameterNode, live=live, standing=standing, mayGoOn=mayGoOn),
            isSeen=live or not self._isQuiet,
        )
        if not (wasQuiet and self._isQuiet):  # else nothing else can be done than before
            self._onStart()
        if live:
            self._run.advance()

    def _progressed(self, fraction):
        if fraction >= NEARLY_DONE and not self._isSeen:
            self._isSeen = True
            self._frame.release()
        self._onProgress(fraction)

    def _finished(self, error):
        standing = self._parameterNode and self._standing()
        if error is not None and self._isAtOnce:
            self._signature = None  # a preview shows what there is instead
        goesOn = standing and self._parameterNode.autoUpdate and self._isNew(standing)
        if goesOn:
            self._timer.start()
        else:
            self._frame.release()
            if standing and self._parameterNode.autoUpdate and self._live and error is None:
                self._beginRest()
        self._settleTimer.stop()
        self._isQuiet = self._live
        self._onDone(error, standing)
        self._rest()
        if error is None:
            self.followFlow()
