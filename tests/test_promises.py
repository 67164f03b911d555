"""What is promised to whoever types `sdfstent deploy`, as far as no other file shows it."""

from __future__ import annotations

import numpy as np
import pytest
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringArray

from SDFStentLib.field import CapsuleChain
from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
)
from SDFStentLib.phantoms import stenosed_tube

REACH = 3.0 + 6.5 + 0.4
"""Radius of the stent, influence distance and tissue gap, mm."""


@pytest.fixture(scope="module")
def a_vessel(tmp_path_factory):
    """A file as SimVascular writes it: cm, single precision, ids of nodes, elements and faces."""
    folder = tmp_path_factory.mktemp("Gefäß im Ordner")
    made = stenosed_tube(edge_length=0.8)
    # Away from the origin, so that single precision shows.
    shift = np.array([11.0, -7.0, 130.0])
    points = ((made.points + shift) / 10).astype(np.float32)
    data = polydata_from_arrays(
        points,
        made.triangles,
        point_arrays={
            "GlobalNodeID": np.arange(1, len(points) + 1, dtype=np.int32),
            "pressure_avg": np.random.default_rng(5).normal(size=len(points)),
            "wss": np.random.default_rng(6).normal(size=(len(points), 3)).astype(np.float32),
        },
        cell_arrays={
            "ModelFaceID": made.face_ids.astype(np.int32),
            "GlobalElementID": np.arange(len(made.triangles), dtype=np.int64)[::-1] + 2**40,
            "CapID": (made.face_ids > 1).astype(np.uint8),
        },
    )
    name, when = vtkStringArray(), numpy_to_vtk(np.array([0.1, 0.2]), deep=True)
    name.SetName("patient")
    name.InsertNextValue("Müller, Jörg")
    when.SetName("TimeValue")
    data.GetFieldData().AddArray(name)
    data.GetFieldData().AddArray(when)
    (folder / "vessel.vtp").write_bytes(encode_vtp(data))
    tree = made.centerline
    line = polydata_from_lines((tree.points + shift) / 10, [np.arange(len(tree.points))])
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius / 10}, {})
    (folder / "line.vtp").write_bytes(encode_vtp(line))
    return folder


def deploy(diameter, out, *more):
    return (
        "deploy", "vessel.vtp", "--units", "cm", "--centerline", "line.vtp",
        "--center", 1.1, -0.7, 15, "--length", 20, "--diameter", diameter, "-o", out, *more,
    )  # fmt: skip


def arrays_of(data):
    """Every array by where it is: its type, its shape and its bits."""
    found = {}
    for part in ("PointData", "CellData", "FieldData"):
        attributes = getattr(data, f"Get{part}")()
        for index in range(attributes.GetNumberOfArrays()):
            array = attributes.GetAbstractArray(index)
            if array.IsNumeric():
                values = vtk_to_numpy(array)
                bits = (values.shape, values.tobytes())
            else:
                bits = tuple(array.GetValue(i) for i in range(array.GetNumberOfValues()))
            found[part, array.GetName()] = (array.GetDataTypeAsString(), bits)
    return found


def coordinates(data):
    return vtk_to_numpy(data.GetPoints().GetData())


@pytest.mark.parametrize("more", [(), ("--arrays",)])
def test_deploying_keeps_arrays_ids_and_untouched_points_bit_by_bit(
    shell, a_vessel, tmp_path, more
):
    out = tmp_path / "out.vtp"
    done = shell(*deploy(6, out, *more), folder=a_vessel)
    assert done.returncode == 0, done.stderr
    before = read_surface(a_vessel / "vessel.vtp", "cm")
    after = read_surface(out, "cm")
    old, new = coordinates(before.polydata()), coordinates(after.polydata())

    assert new.dtype == np.float32
    assert new.shape == old.shape
    np.testing.assert_array_equal(after.triangles, before.triangles)
    kept = arrays_of(after.polydata())
    added = set(kept) - set(arrays_of(before.polydata()))
    assert {key: kept[key] for key in kept if key not in added} == arrays_of(before.polydata())
    assert {name for _, name in added} == (
        {"Displacement", "AreaStretch", "PrincipalStretchMax", "PrincipalStretchMin"}
        if more
        else set()
    )

    # The stent of 20 mm loses a tenth of its length; its middle is the throat.
    axis = np.array([[11.0, -7, 141], [11, -7, 159]])
    away = CapsuleChain.along(axis).axis_distance(before.points)
    assert new[away > REACH].tobytes() == old[away > REACH].tobytes()
    changed = (new != old).any(axis=1)
    assert 0 < changed.sum() < len(old)
    if more:
        displacement = vtk_to_numpy(after.polydata().GetPointData().GetArray("Displacement"))
        # Points that the array does not name have their bits, and the others went where it says.
        assert not displacement[~changed].any() or np.abs(displacement[~changed]).max() < 1e-5
        stored = (before.points + displacement) / 10
        # Half a unit in the last place of single precision at 16 cm.
        assert np.abs(stored - new).max() < 1e-6
