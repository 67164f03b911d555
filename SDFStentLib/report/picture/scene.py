"""Painting by VTK; runs in a process of its own, started by `process`."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

# These two register the OpenGL back end and the font renderer with VTK's factories.
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkPNGWriter
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

from ...files import polydata_from_arrays, polydata_from_lines
from ...geometry import cut, length
from ...validation import Floats
from ..drawing import Box, Disc, Drawing, Line, Mark, Words
from .shapes import Bars, Panel, Wall

OVERSAMPLING = 2
"""Drawn this many times larger and averaged: depth peeling does not go with multisampling."""

LAYERS = 8
"""Walls in front of each other that are told apart."""


def main() -> None:
    """Read a pickled drawing with its panels from stdin, write the PNG to stdout."""
    drawing, panels = pickle.load(sys.stdin.buffer)
    sys.stdout.buffer.write(png(drawing, panels))


def png(drawing: Drawing, panels: Sequence[Panel]) -> bytes:
    """The panels, with the drawing over them, as the bytes of a PNG file.

    A drawing alone stays as large as it is drawn, which prints well.
    """
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(OVERSAMPLING * drawing.width, OVERSAMPLING * drawing.height)
    paper, overlay = vtkRenderer(), vtkRenderer()
    paper.SetBackground(1, 1, 1)
    for mark in drawing.marks:
        overlay.AddViewProp(_flat(mark, drawing.height))
    renderers = [paper, *map(_panel, panels), overlay]
    window.SetNumberOfLayers(len(renderers))
    for layer, renderer in enumerate(renderers):
        renderer.SetLayer(layer)
        window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    shrink = vtkImageShrink3D()
    shrink.SetInputConnection(grab.GetOutputPort())
    shrink.SetShrinkFactors(*((OVERSAMPLING, OVERSAMPLING, 1) if panels else (1, 1, 1)))
    shrink.MeanOn()
    writer = vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputConnection(shrink.GetOutputPort())
    writer.Write()
    return bytes(vtk_to_numpy(writer.GetResult()))


def _panel(panel: Panel) -> vtkRenderer:
    renderer = vtkRenderer()
    renderer.SetViewport(*panel.place)
    renderer.SetUseDepthPeeling(1)
    renderer.SetMaximumNumberOfPeels(LAYERS)
    renderer.SetOcclusionRatio(0.0)
    for actor in [_wall(panel.wall), *map(_bars, panel.bars)]:
        renderer.AddActor(actor)
    view, camera = panel.view, renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*view.focus)
    camera.SetPosition(*(view.focus + 1000 * view.toward_camera))
    camera.SetViewUp(*view.up)
    camera.SetParallelScale(view.half_height)
    renderer.ResetCameraClippingRange()
    return renderer


def _wall(wall: Wall) -> vtkActor:
    data = polydata_from_arrays(wall.points, wall.triangles)
    colors = np.clip(255 * wall.colors, 0, 255).astype(np.uint8)
    data.GetPointData().SetScalars(numpy_to_vtk(colors, deep=1))
    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(60)
    normals.ConsistencyOff()
    actor = _shown(normals, 30)
    actor.ForceTranslucentOn()
    actor.GetProperty().SetAmbient(0.35)
    actor.GetProperty().SetDiffuse(0.65)
    actor.GetProperty().SetSpecular(0.15)
    return actor


def _bars(bars: Bars) -> vtkActor:
    tube = vtkTubeFilter()
    tube.SetInputData(_polylines(list(bars.lines)))
    tube.SetRadius(bars.radius)
    tube.SetNumberOfSides(10)
    tube.CappingOn()
    actor = _shown(tube, 25)
    actor.GetProperty().SetColor(*_rgb(bars.color))
    actor.GetProperty().SetSpecular(0.5)
    return actor


def _shown(source: Any, shine: float) -> vtkActor:
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetSpecularPower(shine)
    return actor


def _flat(mark: Mark, height: float) -> vtkActor2D:
    """A mark of the drawing; VTK counts pixels from below."""
    if isinstance(mark, Words):
        return _words(mark, height)
    if isinstance(mark, Line):
        corners = OVERSAMPLING * np.array([(x, height - y, 0.0) for x, y in mark.points])
        data = _polylines(_dashed(corners, mark.dashes) if mark.dashes else [corners])
    elif isinstance(mark, Box):
        sides = np.array([(0, 0), (1, 0), (1, -1), (0, -1)]) * (mark.width, mark.height)
        data = _area(sides, mark, height)
    else:
        angle = np.linspace(0, 2 * np.pi, 25)[:-1]
        around = mark.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        data = _area(around, mark, height)
    place = vtkCoordinate()
    place.SetCoordinateSystemToViewport()
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(data)
    mapper.SetTransformCoordinate(place)
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*_rgb(mark.color))
    if isinstance(mark, Line):
        actor.GetProperty().SetLineWidth(OVERSAMPLING * mark.width)
    return actor


def _dashed(corners: Floats, dashes: tuple[float, float]) -> list[Floats]:
    """The dashes of a polyline in enlarged pixels."""
    dash, gap = (OVERSAMPLING * part for part in dashes)
    whole = length(corners)
    return [cut(corners, at, min(at + dash, whole)) for at in np.arange(0, whole, dash + gap)]


def _words(words: Words, height: float) -> vtkTextActor:
    actor = vtkTextActor()
    actor.SetInput(words.text)
    actor.SetTextScaleModeToNone()
    look = actor.GetTextProperty()
    look.SetFontFamilyToArial()
    look.SetFontSize(round(OVERSAMPLING * words.size))
    look.SetColor(*_rgb(words.color))
    look.SetBold(words.is_bold)
    look.SetJustification(("start", "middle", "end").index(words.anchor))
    look.SetVerticalJustificationToBottom()
    look.SetOrientation(90 if words.is_upright else 0)
    drop = 0.22 * words.size  # VTK places the depth of a g, SVG the line that letters stand on
    x, y = (words.x + drop, words.y) if words.is_upright else (words.x, words.y + drop)
    actor.SetPosition(OVERSAMPLING * x, OVERSAMPLING * (height - y))
    return actor


def _polylines(lines: Sequence[Floats]) -> vtkPolyData:
    ends = np.cumsum([0, *map(len, lines)])
    numbers = np.split(np.arange(ends[-1]), ends[1:-1])
    return polydata_from_lines(np.concatenate(lines), [*numbers])


def _area(corners: Floats, mark: Box | Disc, height: float) -> vtkPolyData:
    """A convex area, its corners (n, 2) given from the place of a mark."""
    flat = OVERSAMPLING * (corners + np.array([mark.x, height - mark.y]))
    second = np.arange(1, len(flat) - 1)
    fan = np.stack([0 * second, second, second + 1], axis=1)
    return polydata_from_arrays(np.pad(flat, ((0, 0), (0, 1))), fan)


def _rgb(color: str) -> tuple[float, ...]:
    return tuple(part / 255 for part in bytes.fromhex(color[1:]))
