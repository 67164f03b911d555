"""What half a voxel makes of a result, in the panel: found after that, kept with it, and told in tiles and details."""

import pytest
from panel_helpers import deploy, settle
from test_made_centerline import TUBE, addTube, made

from SDFStentLib.validation import DeploymentError

HALF = TUBE.labelmap.voxel / 2


def ranged(host, panel):
    """Wait for the range; the `Stenting` that has it."""
    host.processUntil(lambda: not panel.ranging.isRunning)
    return panel.logic.lastRun(panel._parameterNode)


@pytest.fixture
def aTreatedTube(host, aPanel, aScene):
    """The panel with a segmentation of a tube, stented."""
    addTube(aScene)
    host.process()
    made(host, aPanel)
    settle(host, aPanel)
    host.click(aPanel.ui.addStentButton)
    aPanel.ui.lengthSlider.value = 20.0
    host.process()
    deploy(host, aPanel)
    return aPanel


def tilesBy(panel):
    from SDFStentSlicer import Tiles

    return {tile.name: tile for tile in Tiles.tilesOf(panel._parameterNode)}


def test_lumen_and_stenosis_are_told_with_the_range(host, aTreatedTube):
    panel = aTreatedTube
    assert "(" not in tilesBy(panel)["Narrowest lumen"].beneath  # the result does not wait for it
    run = ranged(host, panel)
    (lumen,), (stenosis,) = run.voxels.lumens, run.voxels.stenoses
    low, high = lumen.before
    assert high - low == pytest.approx(4 * HALF, rel=0.1)
    assert lumen.after[0] <= run.result.stents[0].after.minimum <= lumen.after[1]
    assert stenosis.before[0] < run.lesions[0].before.percent_diameter < stenosis.before[1]
    low, high = (f"{one:.1f}" for one in lumen.after)
    assert low == high  # of the same stent, which is no range
    assert tilesBy(panel)["Narrowest lumen"].beneath.startswith("before ")
    low, high = stenosis.after
    assert low <= run.lesions[0].after.percent_diameter <= high
    assert tilesBy(panel)["Stenosis left"].beneath.startswith(f"({low:.0f}-{high:.0f} %) before ")
    assert f"half a voxel ({HALF:.2f} mm) in or out, narrowest lumen: stent 1 " in (
        panel._parameterNode.lumenSummary
    )


def test_pressures_that_are_asked_for_later_have_it_without_another_deployment(host, aTreatedTube):
    panel = aTreatedTube
    walls = ranged(host, panel)._walls
    panel.ui.flowMeanSpinBox.value = 4.0
    settle(host, panel)
    run = ranged(host, panel)
    assert run._walls is walls
    (drop, *_) = run.voxels.drops
    assert drop.name == "stent 1"
    low, high = drop.before
    before = run.flow.before["mean"].drops[0].recovered.value
    assert low < before < high
    assert tilesBy(panel)["Pressure drop"].beneath.startswith("(")


def test_a_result_of_the_panel_has_the_range_of_the_library(host, aTreatedTube):
    from SDFStentSlicer import Plans

    from SDFStentLib.scan import treated_voxel_range

    run = ranged(host, aTreatedTube)
    parameterNode = aTreatedTube._parameterNode
    patient = aTreatedTube.logic._inputs.patient(parameterNode)
    case = Plans.caseOf(parameterNode, patient)
    expected = treated_voxel_range(case, run.case, HALF)
    assert repr(run.voxels) == repr(expected)


def test_a_process_beside_finds_the_same(host, aTreatedTube, monkeypatch):
    """The previews' process keeps the vessel that it has: another one would have to be prepared anew."""
    from SDFStentSlicer import Calculating, Plans

    from SDFStentLib.plan import Case, TreatedCase

    panel = aTreatedTube
    here = ranged(host, panel).voxels
    monkeypatch.setattr(Plans, "Case", Case)
    monkeypatch.setattr(Calculating, "TreatedCase", TreatedCase)
    Calculating.processes.use(True)
    try:
        deploy(host, panel)
        kept = Calculating.processes.previewing._vessel
        run = ranged(host, panel)
        assert Calculating.processes.previewing._vessel is kept
        assert run.case.vessel is kept
    finally:
        Calculating.processes.use(False)
    assert repr(run.voxels) == repr(here)


def test_a_new_deployment_leaves_it(host, aTreatedTube):
    panel = aTreatedTube
    ranged(host, panel)
    panel.ranging.start(panel.logic.ranged(panel._parameterNode))  # a quick machine had it by now
    assert panel.ranging.isRunning
    host.click(panel.ui.deployButton)
    assert not panel.ranging.isRunning
    settle(host, panel)
    assert ranged(host, panel).voxels is not None


def test_numbers_that_were_taken_away_do_not_come_back_with_it(host, aTreatedTube):
    panel = aTreatedTube
    panel.logic.reset(panel._parameterNode)
    ranged(host, panel)
    assert panel._parameterNode.tiles == ""


def test_where_it_cannot_be_found_the_reason_is_told(host, aTreatedTube, monkeypatch):
    from SDFStentSlicer import Stenting

    def fail(*_arguments):
        raise DeploymentError("no way out")

    panel = aTreatedTube
    panel.ranging.cancel()
    monkeypatch.setattr(Stenting, "moved_cases", fail)
    deploy(host, panel)
    assert ranged(host, panel).voxels is None
    assert "no way out" in panel._parameterNode.lumenSummary


def test_another_vessel_has_none(host, aStent):
    deploy(host, aStent)
    run = ranged(host, aStent)
    assert (run.voxels, run.voxelRemark) == (None, "")
