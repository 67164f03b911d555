"""A case of the bench: a tree's surface, its centerline, and the truth about its narrowings."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from .layout import VesselTree, read_tree, turned, with_some_ends
from .narrowing import SHAPES, narrowed, narrowings
from .surface import ENDS, Wall, wall_near, wall_of
from .synthetic import random_tree
from .truth import Truth, truths

NONE = "none"
"""The shape of a case without a narrowing."""

MEASURED = "pulmonary_tree_radii_cm.vtp"


@dataclass(frozen=True)
class TreeCase:
    """A tree with its wall, the truth about its narrowings, and facts about how it was made."""

    name: str
    tree: VesselTree
    wall: Wall
    truths: list[Truth]
    facts: dict[str, Any]

    @property
    def shapes(self) -> list[str]:
        return [one.shape for one in self.truths] or [NONE]


def made_case(seed: int, number: int, data: Path, only: str | None = None) -> TreeCase:
    """The case of a number; every tenth, the fourth first, has no narrowing."""
    random = np.random.default_rng([seed, number])
    tree, kind = bare_tree(random, number, data)
    ends = ENDS[int(random.integers(len(ENDS)))]
    box = float(np.prod(np.ptp(tree.points, axis=0) + 2 * tree.radius.max()))
    step = max(0.4, (box / 45e6) ** (1 / 3))
    has_none = only == NONE or (only is None and number % 10 == 4)
    shapes = [] if has_none else [only] * 4 if only else list(random.permutation(SHAPES)[:4])
    after = narrowed(tree, chosen := narrowings(tree, shapes, random))
    try:
        wall = wall_of(after, step, ends)
    except ValueError:
        # Where vessels touch at an end, it cannot be cut flat.
        ends = "round"
        wall = wall_of(after, step, ends)
    found: list[Truth] = []
    refused: list[str] = []
    for one in chosen:
        place = tree.points[one.vessel[one.factor < 1]]
        healthy = wall_near(tree, step, place)
        try:
            found += truths((tree, healthy), (after, wall), one)
        except ValueError as error:
            # It stays in the surface; what is reported about it is not judged.
            refused.append(str(error))
    facts = {
        "tree": kind, "ends": ends, "step": round(step, 3), "seed": seed, "number": number,
        "outlets": len(tree.leaves), "triangles": len(wall.triangles), "refused": refused,
        "wander": float(random.choice([0.0, 0.08])), "has_radius": bool(random.uniform() < 0.7),
    }  # fmt: skip
    return TreeCase(f"{number:04d}", after, wall, found, facts)


def bare_tree(random: np.random.Generator, number: int, data: Path) -> tuple[VesselTree, str]:
    """The tree of a number before it is narrowed, and its kind."""
    if number % 2 and (data / MEASURED).is_file():
        tree = read_tree(data / MEASURED, 1.6 if random.uniform() < 0.85 else 1.0)
        kind = "pulmonary"
        if random.uniform() < 0.7:
            tree = with_some_ends(tree, int(random.integers(20, 70)), random)
        return turned(tree, random), kind
    outlets = int(random.integers(20, 101))
    tree = random_tree(random, outlets)
    while len(tree.leaves) < 20:
        tree = random_tree(random, outlets)
    return turned(tree, random), "random"


def save(case: TreeCase, folder: Path) -> None:
    """Write `surface.vtp`, `centerline.vtp` (a line from the inlet to every end), `truth.json`, in
    mm."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(_surface(case.wall), folder / "surface.vtp")
    _write(_lines(case), folder / "centerline.vtp")
    document = {
        **case.facts,
        "units": "mm",
        "narrowings": [one.as_dict() for one in case.truths],
        "tree_points": case.tree.points.round(4).tolist(),
        "tree_radius": case.tree.radius.round(4).tolist(),
        "tree_parent": case.tree.parent.tolist(),
    }
    (folder / "truth.json").write_text(json.dumps(document) + "\n", encoding="utf-8")


def load(folder: Path) -> tuple[VesselTree, list[Truth], dict[str, Any]]:
    """The tree, the truth about its narrowings, and the facts of a saved case."""
    document = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    tree = VesselTree(
        np.array(document.pop("tree_points")),
        np.array(document.pop("tree_radius")),
        np.array(document.pop("tree_parent")),
    )
    known = []
    for one in document.pop("narrowings"):
        one.pop("length")
        known.append(Truth(**one))
    return tree, known, document


def read_wall(path: Path) -> Wall:
    """A surface of triangles from a VTP file, as wall."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return Wall(points, triangles, np.ones(len(triangles), dtype=int))


def _surface(wall: Wall) -> Any:
    from vtk.util.numpy_support import numpy_to_vtk

    data = _polydata(wall.points)
    data.SetPolys(_cells([*wall.triangles]))
    if wall.faces.max() > 1:
        faces = numpy_to_vtk(wall.faces.astype(np.int32), deep=True)
        faces.SetName("ModelFaceID")
        data.GetCellData().AddArray(faces)
    return data


def _lines(case: TreeCase) -> Any:
    """Lines from the root to every end; they coincide only nearly, as extracted lines do."""
    from vtk.util.numpy_support import numpy_to_vtk

    random = np.random.default_rng(case.facts["number"])
    tree, wall = case.tree, cKDTree(case.wall.points)
    pieces, cells, count = [], [], 0
    for leaf in tree.leaves:
        path = tree.path_to(leaf)
        line = tree.points[path]
        if case.facts["wander"]:
            wave = np.cumsum(random.normal(size=(len(line), 3)), axis=0)
            wave = np.stack([np.convolve(x, np.ones(15) / 15, mode="same") for x in wave.T], axis=1)
            wave /= max(np.abs(wave).max(), 1e-9)
            line = line + case.facts["wander"] * tree.radius[path][:, None] * wave
        pieces.append(line)
        cells.append(np.arange(count, count + len(line)))
        count += len(line)
    points = np.vstack(pieces)
    data = _polydata(points)
    data.SetLines(_cells(cells))
    if case.facts["has_radius"]:
        radius = numpy_to_vtk(wall.query(points)[0], deep=True)
        radius.SetName("MaximumInscribedSphereRadius")
        data.GetPointData().AddArray(radius)
    return data


def _polydata(points: np.ndarray) -> Any:
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    data, made = vtk.vtkPolyData(), vtk.vtkPoints()
    made.SetDataTypeToDouble()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    data.SetPoints(made)
    return data


def _cells(cells: list[np.ndarray]) -> Any:
    import vtk
    from vtk.util.numpy_support import numpy_to_vtkIdTypeArray

    offsets = np.r_[0, np.cumsum([len(cell) for cell in cells])].astype(np.int64)
    made = vtk.vtkCellArray()
    made.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.concatenate(cells).astype(np.int64), deep=True),
    )
    return made


def _write(data: Any, path: Path) -> None:
    import vtk

    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.Write()
