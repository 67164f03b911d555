"""What the panel says of a handle that is let go beside the centerline."""

import re

import numpy as np
import pytest
from panel_helpers import settle, theThroat


def letGo(host, panel, point):
    """Drag the handle of the selected stent somewhere and let go."""
    handle = panel._parameterNode.stent.handle
    handle.SetNthControlPointPositionWorld(0, *point)
    handle.InvokeEvent(handle.PointEndInteractionEvent)
    host.process()


def positionOf(panel):
    return np.array(panel._parameterNode.stent.handle.GetNthControlPointPositionWorld(0))


@pytest.fixture
def besideThroat(aStent):
    """Points at a distance, in inscribed radii there, square to the centerline at a wide place of it, and that radius."""
    from SDFStentSlicer import Conversion

    tree = Conversion.centerlineOf(aStent._parameterNode.centerline)
    path = tree.path_around(theThroat(), 30.0)
    middle = len(path.points) // 5
    along = path.points[middle + 1] - path.points[middle - 1]
    across = np.cross(along, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across)
    radius = path.inscribed_radius[middle]
    return lambda radii: (path.points[middle] + radii * radius * across, radii * radius)


def test_a_handle_let_go_far_beside_the_centerline_is_told_from_how_far(host, aStent, besideThroat):
    point, distance = besideThroat(0.8)
    letGo(host, aStent, point)
    told = re.search(
        r"The center lies ([\d.]+) mm beside the centerline", aStent.ui.statusLabel.text
    )
    assert float(told[1]) == pytest.approx(distance, abs=0.1)
    assert float(told[1]) == pytest.approx(np.linalg.norm(positionOf(aStent) - point), abs=0.051)
    assert aStent.ui.statusLabel.visible


def test_a_handle_let_go_outside_of_the_lumen_stays_there_and_nothing_is_deployed(
    host, aStent, besideThroat
):
    outside, _distance = besideThroat(1.6)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    letGo(host, aStent, outside)
    settle(host, aStent)
    np.testing.assert_allclose(positionOf(aStent), outside, atol=1e-6)
    assert "expected a point in the lumen" in aStent.ui.statusLabel.text
    assert aStent.ui.lumenLabel.text == "Shown: the vessel before treatment."
    assert aStent._parameterNode.certificateSummary == ""
    letGo(host, aStent, theThroat())
    settle(host, aStent)
    assert aStent.ui.statusLabel.text == ""
