"""The drawing of a picture by VTK; runs in a process of its own, started by `picture`."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

# These two register the OpenGL back end and the font renderer with VTK's factories.
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkActor2D,
    vtkCoordinate,
    vtkPolyDataMapper,
    vtkPolyDataMapper2D,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)

Array = NDArray[Any]
Color = tuple[float, float, float]

OVERSAMPLING = 2
"""Drawn this many times larger and averaged: depth peeling does not go with multisampling."""

INK: Color = (0.13, 0.16, 0.20)
GREY: Color = (0.42, 0.46, 0.50)
STEEL: Color = (0.30, 0.34, 0.40)
MARK: Color = (0.80, 0.05, 0.20)

FOOT = 0.14
"""Fraction of the height below the panels, for scales and small print."""

HEAD = 0.15
"""Fraction of the height above the panels, for words."""


def draw(scene_file: str, picture_file: str) -> None:
    """Draw the scene of an npz file, as `picture` writes it, into a PNG file."""
    with np.load(scene_file, allow_pickle=False) as scene:
        words = json.loads(str(scene["words"]))
        window = vtkRenderWindow()
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetAlphaBitPlanes(1)
        window.SetSize(*(OVERSAMPLING * side for side in words["size"]))
        window.SetNumberOfLayers(3)
        window.AddRenderer(_paper())
        for number, name in enumerate(("before", "after")):
            window.AddRenderer(_panel(scene, words, name, number))
        window.AddRenderer(_overlay(words, scene["colormap"]))
        window.Render()
        _save(window, picture_file)


def _paper() -> vtkRenderer:
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    return renderer


def _panel(scene: Any, words: dict[str, Any], name: str, number: int) -> vtkRenderer:
    renderer = vtkRenderer()
    renderer.SetLayer(1)
    renderer.SetViewport(number / 2, FOOT, (number + 1) / 2, 1 - HEAD)
    renderer.SetUseDepthPeeling(1)
    renderer.SetMaximumNumberOfPeels(12)
    renderer.SetOcclusionRatio(0.0)
    renderer.AddActor(_wall(scene[f"points_{name}"], scene["triangles"], scene[f"colors_{name}"]))
    strut = words["strut"]
    if name == "after":
        renderer.AddActor(_tubes(scene["lattice"], strut, STEEL))
    else:
        renderer.AddActor(_tubes(scene["axis"][None], 1.3 * strut, INK))
    renderer.AddActor(_tubes(scene[f"ring_{name}"][None], 1.4 * strut, MARK))
    _aim(renderer, words)
    return renderer


def _aim(renderer: vtkRenderer, words: dict[str, Any]) -> None:
    camera = renderer.GetActiveCamera()
    focus, direction = np.array(words["focus"]), np.array(words["toward_camera"])
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + 1000 * direction))
    camera.SetViewUp(*words["up"])
    camera.SetParallelScale(words["half_height"])
    renderer.ResetCameraClippingRange()


def _wall(points: Array, triangles: Array, colors: Array) -> vtkActor:
    data = vtkPolyData()
    data.SetPoints(_points(points))
    cells = vtkCellArray()
    offsets = np.arange(0, 3 * len(triangles) + 1, 3)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=1), _ids(triangles.ravel()))
    data.SetPolys(cells)
    bytes_ = np.clip(255 * colors, 0, 255).astype(np.uint8)
    data.GetPointData().SetScalars(numpy_to_vtk(bytes_, deep=1))
    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(60)
    normals.ConsistencyOff()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.ForceTranslucentOn()
    shine = actor.GetProperty()
    shine.SetAmbient(0.35)
    shine.SetDiffuse(0.65)
    shine.SetSpecular(0.15)
    shine.SetSpecularPower(30)
    return actor


def _tubes(lines: Array, radius: float, color: Color) -> vtkActor:
    """Lines (l, p, 3) as round bars."""
    data = vtkPolyData()
    count, size = lines.shape[:2]
    data.SetPoints(_points(lines.reshape(-1, 3)))
    cells = vtkCellArray()
    offsets = np.arange(0, count * size + 1, size)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=1), _ids(np.arange(count * size)))
    data.SetLines(cells)
    tube = vtkTubeFilter()
    tube.SetInputData(data)
    tube.SetRadius(radius)
    tube.SetNumberOfSides(10)
    tube.CappingOn()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(tube.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*color)
    actor.GetProperty().SetSpecular(0.5)
    actor.GetProperty().SetSpecularPower(25)
    return actor


def _overlay(words: dict[str, Any], colormap: Array) -> vtkRenderer:
    """Words and scales, in fractions of the whole picture."""
    renderer = vtkRenderer()
    renderer.SetLayer(2)
    renderer.InteractiveOff()
    size = 23 * OVERSAMPLING
    for number, (heading, note) in enumerate(zip(words["headings"], words["notes"], strict=True)):
        middle = 0.25 + 0.5 * number
        renderer.AddViewProp(_text(heading, middle, 0.90, size, INK, bold=True))
        renderer.AddViewProp(_text(note, middle, 0.862, 15 * OVERSAMPLING, GREY))
    renderer.AddViewProp(_text(words["title"], 0.5, 0.955, 17 * OVERSAMPLING, INK))
    renderer.AddViewProp(_text(words["small_print"], 0.82, 0.035, 12 * OVERSAMPLING, GREY))
    renderer.AddViewProp(_lines([(0.5, FOOT), (0.5, 1 - 0.07)], (0.85, 0.87, 0.89), 1.5))

    bar, unit = _length_scale(words)
    y = 0.065
    ticks = [(0.05, y - 0.010), (0.05, y + 0.010), (0.05, y), (0.05 + bar, y)]
    ticks += [(0.05 + bar, y - 0.010), (0.05 + bar, y + 0.010)]
    renderer.AddViewProp(_lines(ticks, INK, 2.5))
    renderer.AddViewProp(_text(unit, 0.05 + bar / 2, 0.02, 16 * OVERSAMPLING, INK))
    for actor in [*_color_scale(words, colormap), *_marks(words)]:
        renderer.AddViewProp(actor)
    return renderer


def _length_scale(words: dict[str, Any]) -> tuple[float, str]:
    """Width of the length bar as a fraction of the picture, and its words."""
    width, height = words["size"]
    panel_height = height * (1 - HEAD - FOOT)
    per_mm = panel_height / (2 * words["half_height"]) / width
    longest = 0.16 / per_mm
    nice = max(step for step in (0.5, 1, 2, 5, 10, 20, 50, 100, 200) if step <= max(longest, 0.5))
    return nice * per_mm, f"{nice:g} mm"


def _color_scale(words: dict[str, Any], colormap: Array) -> list[vtkActor2D]:
    lower, upper = words["limits"]
    left, width, bottom, height = 0.34, 0.32, 0.05, 0.03
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colormap))
    for number, color in enumerate(colormap):
        table.SetTableValue(number, [*color, 1.0])
    table.SetRange(lower, upper)
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetOrientationToHorizontal()
    bar.SetNumberOfLabels(0)
    bar.SetTitle("")
    bar.SetMaximumNumberOfColors(256)
    bar.SetBarRatio(1.0)
    bar.SetPosition(left, bottom)
    bar.SetPosition2(width, height)
    actors: list[vtkActor2D] = [bar]
    steps = round(2 * (upper - lower))
    every = next(each for each in (1, 2, 4, 10, 20, 50, 100) if steps / each <= 7)
    for tick in range(0, steps + 1, every):
        x = left + width * tick / steps
        words_at = _text(f"{lower + tick / 2:g}", x, bottom - 0.034, 14 * OVERSAMPLING, INK)
        actors += [words_at, _lines([(x, bottom), (x, bottom - 0.008)], INK, 1.5)]
    title = _text(words["scale_title"], 0.5, bottom + 0.035, 15 * OVERSAMPLING, INK)
    return [*actors, title]


def _marks(words: dict[str, Any]) -> list[vtkActor2D]:
    """The diameter at the marked section beside it, in both panels."""
    actors: list[vtkActor2D] = []
    up = (1 - HEAD - FOOT) / (2 * words["half_height"])
    across = up * words["size"][1] / words["size"][0]
    for number, mark in enumerate(words["marks"]):
        start, end, leader = (
            (0.25 + 0.5 * number + across * x, FOOT + (1 - HEAD - FOOT) / 2 + up * y)
            for x, y in (words["marked"], words["label"], words["leader"])
        )
        actors.append(_lines([start, leader], MARK, 1.5))
        actors.append(_text(mark, end[0], end[1] - 0.013, 18 * OVERSAMPLING, MARK, bold=True))
    return actors


def _text(
    words: str, x: float, y: float, size: int, color: Color, bold: bool = False
) -> vtkTextActor:
    actor = vtkTextActor()
    actor.SetInput(words)
    actor.SetTextScaleModeToNone()
    look = actor.GetTextProperty()
    look.SetFontFamilyToArial()
    look.SetFontSize(size)
    look.SetColor(*color)
    look.SetBold(bold)
    look.SetJustificationToCentered()
    look.SetVerticalJustificationToBottom()
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(x, y)
    return actor


def _lines(corners: list[tuple[float, float]], color: Color, width: float) -> vtkActor2D:
    """A polyline in fractions of the picture."""
    data = vtkPolyData()
    data.SetPoints(_points(np.array([(x, y, 0.0) for x, y in corners])))
    cells = vtkCellArray()
    cells.InsertNextCell(len(corners))
    for number in range(len(corners)):
        cells.InsertCellPoint(number)
    data.SetLines(cells)
    place = vtkCoordinate()
    place.SetCoordinateSystemToNormalizedViewport()
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(data)
    mapper.SetTransformCoordinate(place)
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*color)
    actor.GetProperty().SetLineWidth(width * OVERSAMPLING)
    return actor


def _points(coordinates: Array) -> vtkPoints:
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(coordinates, dtype=np.float64), deep=1))
    return points


def _ids(numbers: Array) -> Any:
    return numpy_to_vtkIdTypeArray(np.ascontiguousarray(numbers, dtype=np.int64), deep=1)


def _save(window: vtkRenderWindow, picture_file: str) -> None:
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    shrink = vtkImageShrink3D()
    shrink.SetInputConnection(grab.GetOutputPort())
    shrink.SetShrinkFactors(OVERSAMPLING, OVERSAMPLING, 1)
    shrink.MeanOn()
    writer = vtkPNGWriter()
    writer.SetFileName(picture_file)
    writer.SetInputConnection(shrink.GetOutputPort())
    writer.Write()
