"""How much of the time goes to previews while frames of the 3D view cost what they do in software."""

import threading
import time

import numpy as np
import pytest
import slicer
from panel_helpers import settle


def working(milliseconds):
    """What a thread needs to advance so long: the interpreter, again and again."""
    for _ in range(milliseconds):
        time.sleep(0.001)


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
    host.processUntil(lambda: len(advanced) > before + 100)
    assert not session.isRunning
    isOver.set()
    settle(host, aStent)
    assert "prescribed 9 mm" in aStent.ui.lumenLabel.text


def test_a_preview_is_shown_by_the_turn_that_hears_of_the_change(host, aStent, monkeypatch):
    """In the application there is a frame in every turn while a hand drags: with a turn between, it shows nothing new."""
    from SDFStentSlicer import Clock, Previewing

    # A turn has the time that a preview takes, however slow the machine.
    monkeypatch.setattr(Clock.QtTimer, "TURN_S", (4.0, 4.0))
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    parameters = aStent._parameterNode
    tree, handle = aStent.logic.centerlineOf(parameters), parameters.stent.handle
    way = tree.points[tree.ancestry(tree.leaves[0])]
    shown, show, turns, end = [], Previewing.show, 0, time.perf_counter() + 40.0
    monkeypatch.setattr(Previewing, "show", lambda *args: (shown.append(1), show(*args)))
    with host.drawing(0.1):
        while len(shown) < 10 and time.perf_counter() < end:  # Ends: with the time at the latest.
            place = way[len(way) // 3 + 2 * len(shown)]
            if not np.allclose(handle.GetNthControlPointPositionWorld(0), place):
                handle.SetNthControlPointPositionWorld(0, *place)
            host.process()
            turns += 1
    settle(host, aStent)
    assert len(shown) >= 10
    assert turns < 15


@pytest.fixture
def longTurns(theModule, monkeypatch):
    """Turns that every preview ends in: one that takes longer has a frame of the handle alone."""
    from SDFStentSlicer import Clock

    monkeypatch.setattr(Clock.QtTimer, "TURN_S", (10.0, 10.0))


def test_what_a_hand_moves_is_drawn_once_and_with_its_surface(host, longTurns, aStent, monkeypatch):
    from SDFStentSlicer import Previewing

    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    parameters, order, show = aStent._parameterNode, [], Previewing.show
    tree, handle = aStent.logic.centerlineOf(parameters), parameters.stent.handle
    way = iter(tree.points[tree.ancestry(tree.leaves[0])][40:])
    monkeypatch.setattr(Previewing, "show", lambda *args: (order.append("surface"), show(*args)))
    with host.drawing(0.05) as frames:
        frames.onFrame = lambda: order.append("frame")
        for _ in range(8):
            for _event in range(2):  # the mouse goes on while the first one is handled
                handle.SetNthControlPointPositionWorld(0, *next(way))
                time.sleep(0.02)
            host.process()
    assert order.count("surface") > 4
    assert order.count("frame") <= order.count("surface") + 1


@pytest.mark.parametrize("isSeen", [False, True])
def test_a_slow_frame_makes_only_those_turns_long_whose_work_is_seen(host, monkeypatch, isSeen):
    from SDFStentSlicer import Clock, Portions

    turns = []

    def work():
        for _ in range(200):
            time.sleep(0.002)
            turns[-1] += 0.002
            yield 1.0

    run = Portions.SteppedRun(lambda _value: turns.append(0.0), lambda _error: None)
    monkeypatch.setattr(Clock.QtTimer, "TURN_S", (0.01, 0.5))
    Portions._application.needed(0.2)  # a frame just now
    turns.append(0.0)
    run.start(work(), isSeen=isSeen)
    host.processUntil(lambda: not run.isRunning)
    assert (max(turns) > 0.1) == isSeen


@pytest.mark.parametrize("frame", [0.02, 0.1, 0.2, 0.3, 0.45, 0.6])
def test_a_turn_and_its_frame_together_do_not_keep_a_hand_waiting(theModule, frame):
    """Frames of 0.3 s had turns of 0.5 before them."""
    from SDFStentSlicer import Clock

    least, most = Clock.QtTimer.TURN_S
    turn = Clock.turn(frame)
    assert turn + frame <= most or turn == least
    assert turn == pytest.approx(2 * frame) or turn + frame == pytest.approx(most) or turn == least


def test_no_view_peels_depths_while_a_hand_moves(host, aStent):
    slicer.app.showMainWindow(True)
    view, node = host.application.view, host.application.view.node
    renderer, modified = view.renderer, node.GetMTime()
    renderer.SetUseDepthPeeling(node.GetUseDepthPeeling())
    before = renderer.GetUseDepthPeeling(), renderer.GetUseOIT()
    assert before == (1, True)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    aStent.ui.diameterSlider.value = 9.0
    host.processUntil(lambda: aStent.session.isRunning)
    assert not renderer.GetUseDepthPeeling()
    settle(host, aStent)
    slicer.app.showMainWindow(False)
    assert (renderer.GetUseDepthPeeling(), renderer.GetUseOIT()) == before
    assert node.GetMTime() == modified  # the user's


def test_no_frame_is_drawn_of_half_a_stent(host, aStent, monkeypatch):
    logic, order = aStent.logic, []
    find, lead = logic.stentLying, logic.leadEnds
    monkeypatch.setattr(logic, "stentLying", lambda *args: (time.sleep(0.05), find(*args))[1])
    monkeypatch.setattr(logic, "leadEnds", lambda *args: (lead(*args), order.append("whole")))
    host.processUntil(lambda: not aStent.ends.isBusy)
    order.clear()
    with host.drawing(0.05) as frames:
        frames.onFrame = lambda: order.append("frame")
        aStent.ends._update()
        host.process(0.2)
    assert order[0] == "whole"
    assert "frame" in order


@pytest.mark.parametrize("seconds", [0.0, 0.2])
def test_the_dots_of_a_stent_that_rests_come_in_the_frame_of_its_end(
    host, aStent, monkeypatch, seconds
):
    """Also where a preview takes longer than dots wait for: they were shown with what had been deployed before."""
    from SDFStentSlicer import Results

    order, end, steps = [], Results.showEnd, aStent.logic.steps

    def late(parameterNode, **options):
        until = time.perf_counter() + seconds
        while options["live"] and time.perf_counter() < until:
            yield 0.0
        yield from steps(parameterNode, **options)

    monkeypatch.setattr(aStent.logic, "steps", late)
    monkeypatch.setattr(Results, "showEnd", lambda *args: (end(*args), order.append("end")))
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    host.processUntil(lambda: not aStent.ends.isBusy)
    show = aStent.ends._showDots
    monkeypatch.setattr(aStent.ends, "_showDots", lambda: (show(), order.append("dots")))
    order.clear()
    with host.drawing(0.05) as frames:
        frames.onFrame = lambda: order.append("frame")
        aStent.ui.diameterSlider.value = 9.0
        settle(host, aStent)
        host.processUntil(lambda: not aStent.ends.isBusy)
    assert order.count("end") == order.count("dots") == 1
    between = order[order.index("dots") : order.index("end")]
    between += order[order.index("end") : order.index("dots")]
    assert "frame" not in between
