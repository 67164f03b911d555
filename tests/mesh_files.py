"""Small meshes as polydata and files, shared by the tests of reading and writing."""

import numpy as np
import pytest
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

from SDFStentLib.validation import InputError


def octahedron(radius=30.0, rounds=2):
    """A closed surface of 8 * 4**rounds triangles on a sphere, oriented outward."""
    points = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )
    for _ in range(rounds):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, number = np.unique(edges, axis=0, return_inverse=True)
        middle = (len(points) + number).reshape(-1, 3)
        points = np.concatenate([points, points[unique].mean(axis=1)])
        a, b, c = triangles.T
        ab, bc, ca = middle.T
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
    return radius * points / np.linalg.norm(points, axis=1, keepdims=True), triangles


def open_tube(radius=5.0, length=60.0, around=24, along=30):
    """A tube along z from 0 to `length`, open at both ends, oriented outward."""
    angle = np.arange(around) * 2 * np.pi / around
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    heights = np.linspace(0, length, along + 1)
    points = np.array([[x, y, z] for z in heights for x, y in ring])
    k, i = np.divmod(np.arange(along * around), around)
    a, b = k * around + i, k * around + (i + 1) % around
    c, d = a + around, b + around
    return points, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def assert_refused_by_name(read, path, words):
    """Assert that reading fails with one sentence that has the file's name and these words."""
    with pytest.raises(InputError, match=words) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def read_vtk(path):
    """The file as VTK's own reader reads it, which the solvers use."""
    volume = path.suffix == ".vtu"
    reader = vtkXMLUnstructuredGridReader() if volume else vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()
