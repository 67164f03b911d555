"""Faces of a model by which branches are named, in the panel as in the shell, whatever Slicer's readers take of them."""

import numpy as np
import pytest
from panel_helpers import saveAsFile

NAMES = {2: "trunk", 3: "left vein", 4: "right vein"}


def readAgain(node, path):
    """A model as Slicer reads it from a file."""
    import slicer

    storage = slicer.vtkMRMLModelStorageNode()
    slicer.mrmlScene.AddNode(storage)
    node.SetAndObserveStorageNodeID(storage.GetID())
    storage.SetFileName(str(path))
    assert storage.ReadData(node)


def solids(path, frame):
    from SDFStentLib.files import read_surface
    from SDFStentLib.files.plain.stl import encode_solids

    surface = read_surface(path)
    tag = f"SPACE={frame}"
    return encode_solids(surface.points, surface.triangles, surface.faces.ids, NAMES, tag)


def model(path):
    rows = "".join(f'<face id="{number}" name="{name}" />' for number, name in NAMES.items())
    path.write_text(
        '<?xml version="1.0" encoding="UTF-8" ?>\n<format version="1.0" />\n<model type="PolyData"><timestep id="0">'
        f'<model_element type="PolyData"><faces>{rows}</faces></model_element></timestep></model>\n',
        encoding="utf-8",
    )


@pytest.mark.parametrize("frame", ["RAS", "LPS"])
@pytest.mark.parametrize("suffix", [".stl", ".ply", ".vtp"])
def test_faces_of_the_file_name_branches_in_the_panel_as_in_the_shell(
    aLogic, theParameters, tmp_path, frame, suffix
):
    from SDFStentLib.files import read_surface, write_surface

    node, path = theParameters.vessel, tmp_path / f"artery{suffix}"
    node.GetPolyData().GetFieldData().RemoveArray("ModelFaceNames")
    saveAsFile(node, tmp_path / "artery.vtp", frame)
    if suffix == ".stl":
        path.write_bytes(solids(tmp_path / "artery.vtp", frame))
    else:
        model(tmp_path / "artery.mdl")
        surface = read_surface(tmp_path / "artery.vtp")
        ids = {"ModelFaceID": surface.faces.ids.astype(np.int32)}  # PLY has no longer ones
        write_surface(path, surface, surface.points, cell_arrays=ids)
    readAgain(node, path)
    ours, theirs = aLogic._inputs.vessel(theParameters).faces, read_surface(path).faces
    assert [ours.names.get(number) for number in ours.ids.tolist()] == [
        theirs.names.get(number) for number in theirs.ids.tolist()
    ]
    assert set(ours.names.values()) == set(NAMES.values())


def test_a_model_that_is_no_longer_as_in_its_file_has_no_faces_from_there(
    aLogic, theParameters, tmp_path
):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    node, path = theParameters.vessel, tmp_path / "artery.stl"
    saveAsFile(node, tmp_path / "artery.vtp", "RAS")
    path.write_bytes(solids(tmp_path / "artery.vtp", "RAS"))
    readAgain(node, path)
    moved = vtkPolyData()
    moved.DeepCopy(node.GetPolyData())
    moved.GetPoints().SetPoint(5, *np.add(moved.GetPoints().GetPoint(5), 0.1))
    node.SetAndObservePolyData(moved)
    assert aLogic._inputs.vessel(theParameters).faces is None
    # Neither where the file is another by now.
    readAgain(node, path)
    path.write_bytes(path.read_bytes().replace(b"vertex ", b"vertex 1"))
    assert aLogic._inputs.vessel(theParameters).faces is None
