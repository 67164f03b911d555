"""How much of the time goes to previews while frames of the 3D view cost what they do in software."""

import threading
import time

import numpy as np
import pytest
from panel_helpers import settle, theThroat

PREVIEW_MS, NUMBERS_MS, WARM_S, SECONDS = 40, 20, 1.0, 4.0


def working(milliseconds):
    """What a thread needs to advance so long: the interpreter, again and again."""
    for _ in range(milliseconds):
        time.sleep(0.001)


def test_a_thread_advances_in_the_host_only_while_it_is_waited_for(host):
    from SDFStentSlicer.Portions import inPortions

    advanced = []
    portions = inPortions(lambda: [advanced.append(working(1)) for _ in range(1000)])
    next(portions)
    counts = [len(advanced)]
    host.process(0.3)
    counts.append(len(advanced))
    for _ in range(20):
        next(portions)
    counts.append(len(advanced))
    portions.close()
    idle, waited = np.diff(counts)
    assert idle < 5 < waited


def test_what_nobody_waits_for_ends_before_the_full_method_begins(host, aStent):
    from SDFStentSlicer.Portions import inPortions

    advanced, isOver, session = [], threading.Event(), aStent.session

    def work():
        # Ends: when the test has looked.
        while not isOver.is_set():
            advanced.append(working(1))

    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    for _ in range(2):
        abandoned = inPortions(work)
        next(abandoned)
        abandoned.close()
    aStent.ui.diameterSlider.value = 9.0
    host.processUntil(lambda: session._restTimer.isActive() and not session.isRunning)
    before = len(advanced)
    host.process(1.0)
    assert not session.isRunning
    assert len(advanced) - before > 150
    isOver.set()
    settle(host, aStent)
    assert "(9.0 prescribed)" in aStent.ui.lumenLabel.text


@pytest.fixture
def costly(monkeypatch):
    """Previews and numbers that take a thread a while, however busy the machine is."""
    from SDFStentSlicer.Portions import inPortions
    from SDFStentSlicer.Previewing import PreviewedVessel, PreviewRun

    known = {}

    def portions(self, *plan):
        yield from inPortions(lambda: working(PREVIEW_MS))
        if "run" not in known:
            known["run"] = yield from preview(self, *plan)
        return known["run"]

    def lumens(self):
        yield from inPortions(lambda: working(NUMBERS_MS))
        return [8.0]

    preview = PreviewedVessel.portions
    monkeypatch.setattr(PreviewedVessel, "portions", portions)
    monkeypatch.setattr(PreviewRun, "lumens", lumens)


@pytest.mark.parametrize(("cost", "numbers"), [(0.046, 2.0), (0.1, 2.0), (0.28, 1.0)])
def test_half_of_the_frames_of_a_drag_carry_a_new_surface(
    host, aStent, costly, monkeypatch, cost, numbers
):
    """And the numbers come twice a second, as long as frames leave the time for it."""
    from SDFStentSlicer import Results
    from SDFStentSlicer.SurfaceOutput import SurfaceOutput

    shown, told, carried = [], [], []
    showChanged, showPreviewed = SurfaceOutput.showChanged, Results.showPreviewed
    monkeypatch.setattr(SurfaceOutput, "showChanged", lambda *a: (shown.append(1), showChanged(*a)))
    monkeypatch.setattr(Results, "showPreviewed", lambda *a: (told.append(1), showPreviewed(*a)))
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    handle = aStent._parameterNode.stent.handle
    with host.drawing(cost) as frames:
        frames.onFrame = lambda: (carried.append(bool(shown)), shown.clear())
        start = time.perf_counter()
        # Ends: with the time.
        while (elapsed := time.perf_counter() - start) < WARM_S + SECONDS:
            if elapsed < WARM_S:  # what a frame costs has to be seen first
                told.clear()
                carried.clear()
            place = theThroat() + np.array([0.0, 0.0, 4.0 * np.sin(3.0 * elapsed)])
            handle.SetNthControlPointPositionWorld(0, *place)
            host.process(1 / 60)
    assert len(carried) > 0.2 * SECONDS / cost
    assert np.mean(carried) >= 0.5
    assert len(told) >= numbers * SECONDS
