"""Deployments in a process beside the application: shown as those on its own threads, and taken over by these where it ends."""

import os
import signal

import numpy as np
import pytest
from panel_helpers import theThroat

from SDFStentLib.plan import Case, TreatedCase


@pytest.fixture
def aProcess(theModule, monkeypatch):
    """Deployments are calculated in a process, and nothing that was measured before is used."""
    from SDFStentSlicer import Calculating, Plans

    monkeypatch.setattr(Plans, "Case", Case)
    monkeypatch.setattr(Calculating, "TreatedCase", TreatedCase)
    Calculating.processes.use(True)
    yield Calculating.processes
    Calculating.processes.use(False)


def numbers(parameters):
    return (
        parameters.lumenSummary,
        parameters.certificateSummary,
        parameters.status,
    )


def test_a_deployment_is_the_one_of_a_thread(aLogic, theParameters, aProcess):
    there = aLogic.deploy(theParameters)
    told, run = numbers(theParameters), aLogic.lastRun(theParameters)
    assert len(run.recorded) > 3
    aProcess.use(False)
    here = aLogic.deploy(theParameters)
    assert numbers(theParameters) == told
    assert np.array_equal(there.surface.points, here.surface.points)
    assert len(aLogic.lastRun(theParameters).recorded) == len(run.recorded)
    assert [one.number for one in run.lesions] == [
        one.number for one in aLogic.lastRun(theParameters).lesions
    ]


def previewed(aLogic, parameters):
    for _fraction in aLogic.steps(parameters, live=True):
        pass
    return aLogic.lastRun(parameters).points, parameters.tiles


def test_a_preview_is_the_one_of_a_thread_also_where_its_process_ends(
    aLogic, theParameters, aProcess
):
    aLogic.deploy(theParameters)
    theParameters.stent.handle.SetNthControlPointPositionWorld(0, *(np.array(theThroat()) + 0.5))
    points, tiles = previewed(aLogic, theParameters)
    os.kill(aProcess.previewing.pid, signal.SIGKILL)
    again = previewed(aLogic, theParameters)
    assert np.array_equal(again[0], points)
    assert again[1] == tiles
    aProcess.use(False)
    here = previewed(aLogic, theParameters)
    assert np.array_equal(here[0], points)
    assert here[1] == tiles


def test_somebody_else_may_ask_meanwhile(aLogic, theParameters, aProcess):
    aLogic.deploy(theParameters)
    theParameters.stent.handle.SetNthControlPointPositionWorld(0, *(np.array(theThroat()) + 0.5))
    points, tiles = previewed(aLogic, theParameters)
    deployed = aLogic.deploy(theParameters).surface.points
    told = numbers(theParameters)
    for live in (True, False):
        for count, _fraction in enumerate(aLogic.steps(theParameters, live=live)):
            if count == 2:
                aProcess.deploying.leave()
                aProcess.previewing.leave()
        if live:
            assert np.array_equal(aLogic.lastRun(theParameters).points, points)
            assert theParameters.tiles == tiles
    assert np.array_equal(aLogic.lastRun(theParameters).result.surface.points, deployed)
    assert numbers(theParameters) == told


@pytest.mark.parametrize("after", [0.0, 0.3, 1.0], ids=["at once", "while it grows", "grown"])
def test_a_thread_takes_over_where_the_process_ends(aLogic, theParameters, aProcess, after):
    aProcess.use(False)
    expected = aLogic.deploy(theParameters)
    told, count = numbers(theParameters), len(aLogic.lastRun(theParameters).recorded)
    aProcess.use(True)
    pid = aProcess.deploying.pid
    for fraction in aLogic.steps(theParameters):
        if pid is not None and isinstance(fraction, float) and fraction >= after:
            os.kill(pid, signal.SIGKILL)
            pid = None
    assert pid is None
    run = aLogic.lastRun(theParameters)
    assert len(run.recorded) == count
    assert numbers(theParameters) == told
    assert np.array_equal(run.result.surface.points, expected.surface.points)
    assert aProcess.deploying.pid  # another one
    aLogic.deploy(theParameters)


def test_the_panel_shows_what_the_process_finds_and_drops_what_is_cancelled(host, aStent, aProcess):
    host.click(aStent.ui.deployButton)
    host.processUntil(lambda: aStent.session.isRunning)
    host.click(aStent.ui.cancelButton)
    assert not aStent.session.isRunning
    aStent.ui.diameterSlider.value = 9.0
    host.click(aStent.ui.deployButton)
    host.processUntil(lambda: not aStent.session.isRunning)
    assert "9.00" in aStent.ui.lumenLabel.text
