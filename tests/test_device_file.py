"""The stents as a file: struts, or the user's straight mesh, where the plan puts them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from polydata_cases import read_by_vtk
from tube_files import deploy, plan_of
from vtkmodules.util.numpy_support import vtk_to_numpy

from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, read_surface
from SDFStentLib.phantoms import straight_tube


def read(path):
    data = read_by_vtk(Path(path))
    cells = data.GetCellData()
    arrays = {
        cells.GetArrayName(number): vtk_to_numpy(cells.GetArray(number))
        for number in range(cells.GetNumberOfArrays())
    }
    return data, vtk_to_numpy(data.GetPoints().GetData()), arrays


def test_the_stents_of_a_plan_are_told_apart_and_open_cells_drawn_open(a_folder):
    device = {"name": "mine", "cell": "open", "generic": True, "foreshortening_fraction": 0.0}
    stents = [
        {"diameter": 6, "length": 8, "placement": {"center": [0, 0, 1.2]}, "enabled": False},
        {"diameter": 6, "length": 8, "placement": {"center": [0, 0, 1.7]}},
        {"diameter": 6.5, "length": 8, "placement": {"center": [0, 0, 2.4]}, "device": device},
    ]
    Path("plan.json").write_text(json.dumps(plan_of(*stents)), encoding="utf-8")
    assert main(["run", "plan.json", "-o", "out", "--export-device", "d.vtp", "--quiet"]) == 0
    data, points, arrays = read("d.vtp")
    assert np.unique(arrays["Stent"]).tolist() == [2, 3]
    assert np.unique(arrays["Stent"][arrays["IsLink"] == 1]).tolist() == [3]
    for number, radius, middle in ((2, 0.3, 1.7), (3, 0.325, 2.4)):
        own = [
            data.GetCell(int(cell)).GetPointId(place)
            for cell in np.flatnonzero(arrays["Stent"] == number)
            for place in range(data.GetCell(int(cell)).GetNumberOfPoints())
        ]
        np.testing.assert_allclose(np.hypot(*points[own, :2].T), radius, atol=1e-7)
        assert np.mean([points[own, 2].min(), points[own, 2].max()]) == pytest.approx(middle)


def test_a_straight_mesh_of_ones_own_is_laid_where_the_stent_is(a_folder):
    body = straight_tube(radius=2.0, length=16.0, edge_length=1.0)
    centered = body.points - [0, 0, 8]
    data = polydata_from_arrays(centered / 10, body.triangles)
    Path("mesh.vtp").write_bytes(encode_vtp(data))
    assert deploy("--export-device", "d.vtp", "--device-mesh", "mesh.vtp", "--quiet") == 0
    made = read_surface("d.vtp", "cm")
    np.testing.assert_array_equal(made.surface.triangles, body.triangles)
    # The axis is z, upwards or downwards; the middle of the stent is at 20 mm.
    np.testing.assert_allclose(np.abs(made.points[:, 2] - 20), np.abs(centered[:, 2]), atol=1e-6)
    np.testing.assert_allclose(
        np.hypot(*made.points[:, :2].T), np.hypot(*centered[:, :2].T), atol=1e-6
    )
