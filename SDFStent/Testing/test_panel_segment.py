"""The section Flow solver: a segment of the vessel, as `sdfstent extract` writes it."""

import json

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, saveAsFile


@pytest.fixture
def aSegment(host, aStent):
    """The panel with a stent, the section open, and two points on the centerline that are no ends of the vessel."""
    ui, scene = aStent.ui, slicer.mrmlScene
    ui.segmentCollapsibleButton.collapsed = False
    aStent.parent.resize(460, 2000)
    tree = aStent.logic.centerlineOf(aStent._parameterNode)
    way = tree.path_around(
        aStent._parameterNode.stent.handle.GetNthControlPointPositionWorld(0), 36.0
    )
    node = scene.AddNewNodeByClass("vtkMRMLMarkupsLineNode", "Ends")
    for point in way.points[[0, -1]]:
        node.AddControlPointWorld(*point)
    ui.segmentEndsSelector.setCurrentNode(node)
    host.process()
    return aStent


def written(host, panel, folder):
    host.files.append(str(folder))
    host.click(panel.ui.writeSegmentButton)
    host.processUntil(lambda: not panel.sections[-1].writing.isRunning)


def exterior(folder):
    from SDFStentLib.files import read_surface

    return read_surface(folder / "mesh-complete.exterior.vtp", "cm")


def test_the_segment_is_that_of_sdfstent_extract(host, aSegment, tmp_path):
    """Of the same files and places, by the shell, before treatment; after it, of the panel's own wall."""
    from SDFStentLib import treatment
    from SDFStentLib.cli import main

    parameters, ui = aSegment._parameterNode, aSegment.ui
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "RAS")
    deploy(host, aSegment)
    written(host, aSegment, tmp_path)
    folder = tmp_path / "segment"
    ends = np.array([parameters.segmentEnds.GetNthControlPointPositionWorld(i) for i in range(2)])
    start, end = (list(map(repr, place.tolist())) for place in ends)
    files = [
        str(tmp_path / f"{node.GetName()}.vtp")
        for node in (parameters.vessel, parameters.centerline)
    ]
    out = tmp_path / "shell"
    words = ["extract", files[0], "--centerline", files[1], "--from", *start, "--to", *end]
    assert main([*words, "-o", str(out), "--quiet"]) == 0
    ours, theirs = exterior(folder / "before"), exterior(out / "before")
    np.testing.assert_allclose(ours.points, theirs.points, atol=1e-9)
    np.testing.assert_array_equal(ours.triangles, theirs.triangles)
    assert ours.faces.names == theirs.faces.names
    assert ours.frame == "RAS"
    document = json.loads((folder / "segment.json").read_text(encoding="utf-8"))
    named = [document["inputs"][role]["file"] for role in ("surface", "centerline")]
    assert named == files
    expected = json.loads((out / "segment.json").read_text(encoding="utf-8"))
    for mine, other in zip(document["planes"], expected["planes"], strict=True):
        assert mine["branch"] == other["branch"]
        assert mine["origin"] == pytest.approx(other["origin"], abs=1e-9)
        assert mine["normal"] == pytest.approx(other["normal"], abs=1e-9)
    inputs = aSegment.logic._inputs
    vessel = inputs.vessel(parameters)
    found = treatment.extract_segment(
        treatment.Vessel(vessel.surface, inputs.centerline(parameters), faces=vessel.faces),
        *ends,
        after=treatment.Vessel(aSegment.logic.lastRun(parameters).result.surface),
    )
    assert document["after"]["volume"] == pytest.approx(found.after.volume / 1000, rel=1e-9)
    assert document["after"]["volume"] > document["before"]["volume"]
    wrote = f"Wrote {folder}, in cm; segment.json tells what is in it."
    assert ui.statusLabel.text == wrote == slicer.util.shownMessages[-1]  # there is little room


def test_what_is_not_deployed_is_said_and_branches_are_closed_when_asked_for(
    host, aSegment, tmp_path
):
    ui = aSegment.ui
    volumes = []
    for isClosed, name in ((False, "segment"), (True, "segment 2")):
        ui.closeBranchesCheckBox.checked = isClosed
        written(host, aSegment, tmp_path)
        document = json.loads((tmp_path / name / "segment.json").read_text(encoding="utf-8"))
        assert document["after"] is None
        assert document["inputs"]["surface"]["file"] == "Artery"  # which is in no file
        assert "Before treatment only: deploy" in ui.statusLabel.text
        assert sorted(path.name for path in (tmp_path / name).iterdir()) == [
            "before",
            "segment.json",
        ]
        assert any(plane["closed"] for plane in document["planes"]) == isClosed
        volumes.append(document["before"]["volume"])
    assert volumes[1] < volumes[0]
    # A script has the same of the logic.
    assert (
        aSegment.logic.extractSegment(aSegment._parameterNode, tmp_path) == tmp_path / "segment 3"
    )
    walls = [exterior(tmp_path / f"segment {number}" / "before").points for number in (2, 3)]
    np.testing.assert_array_equal(*walls)


def test_with_no_markups_it_is_the_vessel_round_the_selected_stent(host, aSegment, tmp_path):
    ui, parameters = aSegment.ui, aSegment._parameterNode
    ui.segmentEndsSelector.setCurrentNode(None)
    assert ui.segmentEndsSelector.noneDisplay == "Round the selected stent"
    written(host, aSegment, tmp_path)
    assert ui.statusLabel.text.startswith("Segment: expected two places, got none; choose markups")
    parameters.stent.length = 6.0
    deploy(host, aSegment)
    written(host, aSegment, tmp_path)
    assert "Wrote" in ui.statusLabel.text
    document = json.loads((tmp_path / "segment" / "segment.json").read_text(encoding="utf-8"))
    (treated,) = aSegment.logic.lastRun(parameters).result.stents
    at = treated.around_before.arc_length
    tree = aSegment.logic.centerlineOf(parameters)
    ends = [tree.project(10 * np.array(plane["origin"])).arc_length for plane in document["planes"]]
    assert ends[1] - ends[0] == pytest.approx(at[-1] - at[0], abs=1.0)


@pytest.mark.parametrize(
    ("place", "isClosed"),
    [("the sample's first stent", True), ("near the inlet", False), ("near an outlet", False)],
)
def test_round_a_stent_the_ends_are_where_a_plane_meets_only_the_vessel(
    host, aSegment, tmp_path, place, isClosed
):
    """Up to 20 mm beyond the stent the vessel may have ended: nobody has chosen these places."""
    ui, parameters = aSegment.ui, aSegment._parameterNode
    ui.segmentEndsSelector.setCurrentNode(None)
    ui.closeBranchesCheckBox.checked = isClosed
    if place == "the sample's first stent":
        host.click(ui.removeStentButton)
        host.click(ui.addStentButton)
    else:
        tree = aSegment.logic.centerlineOf(parameters)
        chain = tree.ancestry(tree.leaves[0])
        at = tree.arc_length[chain]
        goal = 12.0 if place == "near the inlet" else at[-1] - 12.0
        point = tree.points[chain[np.argmin(abs(at - goal))]]
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *point)
    deploy(host, aSegment)
    written(host, aSegment, tmp_path)
    assert ui.statusLabel.text.startswith(f"Wrote {tmp_path / 'segment'}, in cm;")
    assert "of the segment was moved" in ui.statusLabel.text
    assert exterior(tmp_path / "segment" / "after").surface.topology.is_closed


@pytest.mark.parametrize("wrong", ["one point", "one place", "outside", "at an end", "no folder"])
def test_what_cannot_be_cut_is_a_sentence_and_leaves_nothing(host, aSegment, tmp_path, wrong):
    node = aSegment._parameterNode.segmentEnds
    first, folder = node.GetNthControlPointPositionWorld(0), tmp_path
    said = {
        "one point": "Segment: expected at least two points in Ends, its first and its last one, got 1",
        "one place": "expected two places apart",
        "outside": "expected a place in the vessel",
        "at an end": " mm into the segment, to (",
        "no folder": "missing",
    }[wrong]
    if wrong == "one point":
        node.RemoveNthControlPoint(1)
    elif wrong == "one place":
        node.SetNthControlPointPositionWorld(1, *first)
    elif wrong == "outside":
        node.SetNthControlPointPositionWorld(1, 400.0, 0.0, 0.0)
    elif wrong == "at an end":
        tree = aSegment.logic.centerlineOf(aSegment._parameterNode)
        node.SetNthControlPointPositionWorld(0, *tree.points[tree.roots[0]])
    else:
        folder = tmp_path / "missing" / "folder"
    written(host, aSegment, folder)
    assert said in aSegment.ui.statusLabel.text
    assert list(tmp_path.iterdir()) == []
