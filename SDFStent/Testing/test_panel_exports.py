"""Files of the last deployment: the device, a mesh of the user's own in its place, networks for a 0D solver."""

import json

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, saveAsFile, settle
from vtk.util.numpy_support import vtk_to_numpy


@pytest.fixture
def theFiles(aStent, tmp_path):
    """The panel with a stent, its inputs in files, and a straight mesh of 8 mm and 12 mm as a file."""
    from benchmarks.phantoms import straight_tube
    from SDFStentLib.files import encode_vtp, polydata_from_arrays

    parameters = aStent._parameterNode
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "RAS")
    body = straight_tube(radius=4.0, length=12.0, edge_length=2.0)
    centered = polydata_from_arrays(body.points - [0, 0, 6], body.triangles)
    (tmp_path / "mesh.vtp").write_bytes(encode_vtp(centered))
    return aStent


def written(host, panel, button, path):
    host.files.append(str(path))
    host.click(button)
    return path


def ofShell(panel, folder, *options):
    """What `sdfstent run` writes for the plan of the panel."""
    from SDFStentLib.cli import main

    panel.logic.savePlan(folder / "plan.json", panel._parameterNode)
    words = ["run", str(folder / "plan.json"), "-o", str(folder / "out"), *map(str, options)]
    assert main([*words, "--quiet"]) == 0


def content(path):
    """Points, cells and the numbers of the stents of a file."""
    import vtk

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    numbers = vtk_to_numpy(data.GetCellData().GetArray("Stent"))
    return vtk_to_numpy(data.GetPoints().GetData()), data.GetNumberOfCells(), numbers


def test_device_and_networks_are_those_of_the_shell(host, theFiles, tmp_path):
    ui = theFiles.ui
    assert not ui.saveDeviceButton.enabled
    assert not ui.write0DButton.enabled
    deploy(host, theFiles)
    ours = content(written(host, theFiles, ui.saveDeviceButton, tmp_path / "ours.vtp"))
    assert ui.statusLabel.text == f"Wrote {tmp_path / 'ours.vtp'}."
    # The button may be far below that.
    assert slicer.util.shownMessages[-1] == ui.statusLabel.text
    host.files.append(str(tmp_path / "ours.json"))
    host.click(ui.write0DButton)
    assert "expected a flow, without which there is no network" in ui.statusLabel.text
    ui.flowMeanSpinBox.value = 3.0
    settle(host, theFiles)
    written(host, theFiles, ui.write0DButton, tmp_path / "ours.json")
    assert ui.statusLabel.text == f"Wrote {tmp_path / 'ours.json'}."
    options = ("--export-device", tmp_path / "d.vtp", "--export-0d", tmp_path / "nets")
    ofShell(theFiles, tmp_path, *options)
    theirs = content(tmp_path / "d.vtp")
    np.testing.assert_allclose(ours[0], theirs[0], atol=1e-5)  # of a wall in single precision
    assert ours[1] == theirs[1] > 50
    assert (ours[2] == theirs[2]).all()
    for own, name in (("ours_before", "before"), ("ours", "after")):
        mine, other = (
            json.loads((tmp_path / f"{path}.json").read_text(encoding="utf-8"))["vessels"]
            for path in (own, f"nets/{name}")
        )
        for one, two in zip(mine, other, strict=True):
            assert one["vessel_name"] == two["vessel_name"]
            values = [vessel["zero_d_element_values"] for vessel in (one, two)]
            assert values[0] == pytest.approx(values[1], rel=1e-3)


def test_a_mesh_of_ones_own_is_shown_and_saved_in_place_of_struts(host, theFiles, tmp_path, aScene):
    ui, parameters = theFiles.ui, theFiles._parameterNode
    written(host, theFiles, ui.loadMeshButton, tmp_path / "mesh.vtp")
    mesh = parameters.deviceMesh
    assert mesh.GetName() == "mesh"
    assert not mesh.GetDisplayNode().GetVisibility()
    deploy(host, theFiles)
    shown = slicer.util.arrayFromModelPoints(parameters.outputStents)
    saved = content(written(host, theFiles, ui.saveDeviceButton, tmp_path / "ours.vtp"))
    ofShell(
        theFiles,
        tmp_path,
        "--export-device",
        tmp_path / "d.vtp",
        "--device-mesh",
        tmp_path / "mesh.vtp",
    )
    np.testing.assert_allclose(shown, saved[0], atol=1e-5)
    np.testing.assert_allclose(saved[0], content(tmp_path / "d.vtp")[0], atol=1e-5)
    parameters.expansion = 60.0  # not yet as wide as the mesh
    host.process()
    assert len(slicer.util.arrayFromModelPoints(parameters.outputStents)) != len(shown)
    parameters.expansion = 100.0
    host.process()
    np.testing.assert_array_equal(slicer.util.arrayFromModelPoints(parameters.outputStents), shown)
    copy = theFiles.logic.duplicatePlan(parameters)
    assert copy.deviceMesh is mesh
    aScene.RemoveNode(mesh)
    assert parameters.deviceMesh is None
    host.process()
    assert len(slicer.util.arrayFromModelPoints(parameters.outputStents)) != len(shown)


def test_a_mesh_that_cannot_be_used_is_said_and_the_stents_stay(host, theFiles, aScene):
    ui, parameters = theFiles.ui, theFiles._parameterNode
    deploy(host, theFiles)
    count = parameters.outputStents.GetPolyData().GetNumberOfPoints()
    parameters.deviceMesh = parameters.outputVessel  # is not offered
    host.process()
    sentence = "expected a surface of your own, got a result of this module; select another model."
    assert sentence in ui.statusLabel.text
    assert parameters.outputStents.GetPolyData().GetNumberOfPoints() == count
    parameters.deviceMesh = parameters.centerline  # nor is this
    host.process()
    assert "expected a surface of your own, got none" in ui.statusLabel.text


def test_what_was_written_is_said_until_the_plan_is_changed_or_left(host, theFiles, tmp_path):
    ui, parameters = theFiles.ui, theFiles._parameterNode
    path = tmp_path / "plan.json"

    def change():
        ui.diameterSlider.value += 0.5

    def flow():
        ui.flowMeanSpinBox.value = 3.0

    def leave():
        host.leave(theFiles)
        host.enter(theFiles)

    for edit in (change, flow, leave):
        theFiles.logic.savePlan(path, parameters)
        parameters.status = parameters.status or f"Wrote {path}."
        assert ui.statusLabel.text.startswith(parameters.status)
        ui.expansionSlider.value = 50.0  # which is only looked at
        assert parameters.status
        edit()
        assert parameters.status == ui.statusLabel.text == ""


def test_nothing_is_written_of_a_plan_that_was_changed_or_under_a_wrong_name(
    host, theFiles, tmp_path
):
    ui = theFiles.ui
    deploy(host, theFiles)
    written(host, theFiles, ui.saveDeviceButton, tmp_path / "device.stl")
    assert "device.stl: expected a device that ends in .vtp, got '.stl'" in ui.statusLabel.text
    ui.diameterSlider.value = 7.0
    for button, name in ((ui.saveDeviceButton, "a.vtp"), (ui.write0DButton, "a.json")):
        written(host, theFiles, button, tmp_path / name)
        assert "expected the plan deployed as it is now, it is not" in ui.statusLabel.text
        assert not (tmp_path / name).exists()


def test_a_stent_that_is_dilated_again_is_drawn_once_as_it_is_in_the_end(host, theFiles):
    """Also with the cells of its device, and at first as it was while it is being dilated again."""
    from SDFStentLib.stent import Device

    ui, parameters = theFiles.ui, theFiles._parameterNode
    device = Device("own", cell="open", foreshortening_fraction=0.1, generic=True)
    theFiles.logic.setDevice(parameters, device)
    ui.showDeviceCheckBox.checked = True
    deploy(host, theFiles)
    first = parameters.outputStents.GetPolyData()
    lines = [first.GetNumberOfLines()]
    ui.redilationSpinBox.value = parameters.stent.diameter + 1.0
    deploy(host, theFiles)
    run = theFiles.logic.lastRun(parameters)
    (drawn,) = run.end()[1]
    assert drawn.radius == pytest.approx(parameters.stent.redilation / 2)
    assert drawn.stent.device.cell == "open"
    (earlier,) = run.at(50.0)[1]
    assert earlier.radius == pytest.approx(parameters.stent.diameter / 2)
    assert len(run.at(51.0)[1]) <= 2
    assert parameters.outputStents.GetPolyData().GetNumberOfLines() < 1.5 * lines[0]
