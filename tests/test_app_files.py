"""Surfaces that Slicer does not read, or not with their faces, in the scene of a page."""

import json

import numpy as np
import pytest
from app_server import IS_APP_INSTALLED
from child_processes import PROJECT, python
from mesh_files import octahedron
from test_given_names import a_model
from vtkmodules.vtkIOHDF import vtkHDFWriter

from SDFStentLib.files import (
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
    set_face_names,
    set_frame_of_polydata,
)
from SDFStentLib.files.plain.stl import encode_solids

pytestmark = pytest.mark.skipif(not IS_APP_INSTALLED, reason="the extra app is not installed")

OPEN = """
import json, sys
import numpy as np
import slicer
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from vtkmodules.util.numpy_support import vtk_to_numpy
from SDFStentApp.files import open_vessel
from SDFStentLib.files import faces_of_polydata, surface_from_polydata, triangulated_polydata
from SDFStentSlicer import Conversion
scene, told = slicer.vtkMRMLScene(), []
for path in sys.argv[3:]:
    node = open_vessel(scene, Path(path), None, sys.argv[2]).vessel
    data = triangulated_polydata(node.GetPolyData()).polydata
    faces = faces_of_polydata(data, surface_from_polydata(data))
    told.append({
        "points": vtk_to_numpy(data.GetPoints().GetData()).tolist(),
        "names": [faces.names.get(number) for number in faces.ids.tolist()],
        "file": node.GetStorageNode().GetFileName(),
        "frame": Conversion.fileFrame(node),
        "isChanged": bool(node.GetModifiedSinceRead()),
    })
print(json.dumps(told))
"""


@pytest.mark.parametrize(("frame", "units"), [("LPS", "cm"), ("RAS", "mm"), (None, "mm")])
def test_a_page_has_the_faces_of_every_format_and_they_are_as_in_their_file(tmp_path, frame, units):
    points, triangles = octahedron()
    points = (points / (10 if units == "cm" else 1)).astype(np.float32)
    ids, names = 1 + np.arange(len(triangles), dtype=np.int32) % 3, {2: "rechter Ast", 3: "cap"}
    polydata = polydata_from_arrays(points, triangles, cell_arrays={"ModelFaceID": ids})
    writer = vtkHDFWriter()
    writer.SetFileName(str(tmp_path / "a.vtkhdf"))
    writer.SetInputData(polydata)
    assert writer.Write()
    set_frame_of_polydata(polydata, frame)
    (tmp_path / "model.vtp").write_bytes(encode_vtp(polydata))
    for name in ("model.mdl", "a.mdl"):
        (tmp_path / name).write_text(a_model(names), encoding="utf-8")
    tag = f"SPACE={frame}" if frame else ""
    (tmp_path / "solids.stl").write_bytes(encode_solids(points, triangles, ids, names, tag))
    set_face_names(polydata, names)
    (tmp_path / "a.vtp").write_bytes(encode_vtp(polydata))

    files = [tmp_path / name for name in ("model.vtp", "a.vtp", "a.vtkhdf", "solids.stl")]
    done = python(OPEN, PROJECT / "SDFStent", units, *files)
    said = json.loads(done.stdout.splitlines()[-1])
    for path, told in zip(files, said, strict=True):
        read = read_surface(path, units)
        file_frame = read.frame or "LPS"
        turn = [1, 1, 1] if file_frame == "RAS" else [-1, -1, 1]
        np.testing.assert_allclose(np.array(told["points"]), read.points * turn, rtol=0, atol=1e-5)
        expected = [read.faces.names.get(number) for number in read.faces.ids.tolist()]
        assert told["names"] == expected
        assert set(expected) - {None} == set(names.values())
        assert told["file"] == str(path)
        assert told["frame"] == file_frame
        assert not told["isChanged"]


OPEN_LINES = """
import json, sys
import slicer
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from SDFStentApp.files import has_lines, open_vessel
from SDFStentSlicer import Conversion
scene, told = slicer.vtkMRMLScene(), []
for path in map(Path, sys.argv[4:]):
    node = open_vessel(scene, Path(sys.argv[3]), path, sys.argv[2]).centerline
    points, lines, _ = Conversion.centerlineLines(node)
    told.append({
        "hasLines": has_lines(path),
        "points": [points[line].tolist() for line in lines],
        "file": node.GetStorageNode().GetFileName(),
        "isChanged": bool(node.GetModifiedSinceRead()),
    })
print(json.dumps(told))
"""


def line_files(folder, points, frame):
    """The same line in every format, in the files' unit; SimVascular's names no frame."""
    lines = polydata_from_lines(points, [np.arange(len(points))])
    set_frame_of_polydata(lines, frame)
    (folder / "line.vtp").write_bytes(encode_vtp(lines))
    places = "".join(f"<pos x='{x}' y='{y}' z='{z}'/>" for x, y, z in points.tolist())
    text = f"<format version='1.0'/><path><path_points>{places}</path_points></path>"
    (folder / "line.pth").write_text(text, encoding="utf-8")
    rows = [f"{n},{x},{y},{z}" for n, (x, y, z) in enumerate(points.tolist())]
    head = [f"# CoordinateSystem = {frame or 'LPS'}", "# columns = id,x,y,z"]
    (folder / "line.fcsv").write_text("\n".join([*head, *rows]), encoding="utf-8")
    return [str(folder / f"line.{suffix}") for suffix in ("vtp", "pth", "fcsv")]


@pytest.mark.parametrize(("frame", "units"), [("LPS", "cm"), ("RAS", "mm"), (None, "mm")])
def test_a_page_opens_lines_of_every_format_where_their_surface_is(tmp_path, frame, units):
    points, triangles = octahedron()
    scale = 0.1 if units == "cm" else 1.0
    line = np.linspace((-18, 2, -9), (18, 2, 9), 7)
    wall = polydata_from_arrays(scale * points, triangles)
    set_frame_of_polydata(wall, frame)
    (tmp_path / "wall.vtp").write_bytes(encode_vtp(wall))
    files = line_files(tmp_path, scale * line, frame)
    done = python(OPEN_LINES, PROJECT / "SDFStent", units, tmp_path / "wall.vtp", *files)
    wanted = line if frame == "RAS" else line * (-1, -1, 1)
    for path, told in zip(files, json.loads(done.stdout.splitlines()[-1]), strict=True):
        assert told["hasLines"]
        assert (told["file"], told["isChanged"]) == (path, False)
        np.testing.assert_allclose(told["points"], [wanted], atol=1e-4)
