"""Painting by VTK; runs in a process of its own, started by `painting`."""

from __future__ import annotations

import pickle
import sys

import numpy as np
import vtkmodules.vtkRenderingContextOpenGL2
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints2D
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkRectf
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkImagingCore import vtkImageShrink3D
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkPythonContext2D import vtkPythonItem
from vtkmodules.vtkRenderingContext2D import vtkContext2D, vtkContextActor, vtkPen
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

from ...files import polydata_from_arrays, polydata_from_lines
from ...geometry import Line
from ...validation import Floats, Points, one_line
from .drawing import Box, Disc, Drawing, Photo, Stroke, Words
from .shapes import Panel
from .view import BOTTOM, HEIGHT, TOP

LAYERS = 8
"""Number of walls in front of each other that are drawn apart."""

STEEL = (0.30, 0.34, 0.40)

STRUT_PIXELS = 2.0
"""Width of a strut in the picture, whatever its scale."""


def seen(panel: Panel, columns: int) -> vtkRenderer:
    """Renderer of a panel in its part of a picture of so many columns."""
    data = polydata_from_arrays(panel.points, panel.triangles)
    data.GetPointData().SetScalars(numpy_to_vtk((255 * panel.colors).astype(np.uint8), deep=1))
    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(60)
    normals.ConsistencyOff()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.ForceTranslucentOn()
    look = actor.GetProperty()
    look.SetAmbient(0.35)
    look.SetDiffuse(0.65)
    look.SetSpecular(0.15)
    look.SetSpecularPower(30)
    renderer = vtkRenderer()
    renderer.AddActor(actor)
    for curves in panel.struts:
        renderer.AddActor(_tubes(curves, STRUT_PIXELS / 2 / panel.view.per_mm))
    renderer.SetUseDepthPeeling(1)
    renderer.SetMaximumNumberOfPeels(LAYERS)
    renderer.SetOcclusionRatio(0.0)
    low, high = 1 - BOTTOM / HEIGHT, 1 - TOP / HEIGHT
    renderer.SetViewport(panel.column / columns, low, (panel.column + 1) / columns, high)
    camera, view = renderer.GetActiveCamera(), panel.view
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*view.focus)
    camera.SetPosition(*(view.focus + 1000 * view.toward_camera))
    camera.SetViewUp(*view.up)
    camera.SetParallelScale(view.half_height)
    renderer.ResetCameraClippingRange()
    return renderer


def _tubes(curves: Floats, radius: float) -> vtkActor:
    """Curves (m, p, 3) as round wires, mm."""
    count, each, _ = curves.shape
    indices = np.arange(count * each).reshape(count, each)
    tubes = vtkTubeFilter()
    tubes.SetInputData(polydata_from_lines(curves.reshape(-1, 3), [*indices]))
    tubes.SetRadius(radius)
    tubes.SetNumberOfSides(8)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(tubes.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*STEEL)
    look.SetAmbient(0.3)
    look.SetSpecular(0.4)
    look.SetSpecularPower(20)
    return actor


OVERSAMPLING = 2
"""Drawn this many times larger and averaged: depth peeling does not go with multisampling."""


def main() -> None:
    """Read a pickled drawing and its panels from stdin, write the PNG to stdout."""
    sys.stdout.buffer.write(png(*pickle.load(sys.stdin.buffer)))


def png(drawing: Drawing, panels: tuple[Panel, ...]) -> bytes:
    """The panels side by side, with the drawing over them, as the bytes of a PNG file.

    A drawing alone stays as large as it is drawn, which prints well.
    """
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(OVERSAMPLING * drawing.width, OVERSAMPLING * drawing.height)
    paper = vtkRenderer()
    paper.SetBackground(1, 1, 1)
    renderers = [paper, *(seen(panel, len(panels)) for panel in panels), _overlay(drawing)]
    window.SetNumberOfLayers(len(renderers))
    for layer, renderer in enumerate(renderers):
        renderer.SetLayer(layer)
        window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()  # it is rendered
    shrink = vtkImageShrink3D()
    shrink.SetInputConnection(grab.GetOutputPort())
    shrink.SetShrinkFactors(*((OVERSAMPLING, OVERSAMPLING, 1) if panels else (1, 1, 1)))
    writer = vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputConnection(shrink.GetOutputPort())
    writer.Write()
    return bytes(vtk_to_numpy(writer.GetResult()))


def _overlay(drawing: Drawing) -> vtkRenderer:
    item, actor, renderer = vtkPythonItem(), vtkContextActor(), vtkRenderer()
    item.SetPythonObject(_Painter(drawing))
    actor.GetScene().AddItem(item)
    renderer.AddActor(actor)
    return renderer


class _Painter:
    """Paints marks when VTK calls; `at` is a place in its pixels, which count from below."""

    def __init__(self, drawing: Drawing) -> None:
        self.drawing = drawing

    def at(self, x: float, y: float) -> tuple[float, float]:
        return OVERSAMPLING * x, OVERSAMPLING * (self.drawing.height - y)

    def Initialize(self, _: vtkPythonItem) -> bool:
        return True

    def Paint(self, _: vtkPythonItem, context: vtkContext2D) -> bool:
        for mark in self.drawing.marks:
            if isinstance(mark, Photo):
                self.photo(context, mark)
                continue
            context.GetPen().SetColorF(*_rgb(mark.color))
            context.GetBrush().SetColorF(*_rgb(mark.color))
            if isinstance(mark, Words):
                self.words(context, mark)
            elif isinstance(mark, Stroke):
                self.line(context, mark)
            else:
                self.area(context, mark)
        return True

    def words(self, context: vtkContext2D, mark: Words) -> None:
        look = context.GetTextProp()
        look.SetFontFamilyToArial()
        look.SetFontSize(round(OVERSAMPLING * mark.size))
        look.SetColor(*_rgb(mark.color))
        look.SetBold(mark.is_bold)
        look.SetJustification(("start", "middle", "end").index(mark.anchor))
        look.SetVerticalJustificationToBottom()
        look.SetOrientation(90 if mark.is_upright else 0)
        drop = 0.22 * mark.size  # VTK places the depth of a g, SVG the line that letters stand on
        right, down = (drop, 0.0) if mark.is_upright else (0.0, drop)
        context.DrawString(*self.at(mark.x + right, mark.y + down), one_line(mark.text))

    def photo(self, context: vtkContext2D, mark: Photo) -> None:
        rows, columns = mark.gray.shape
        image = vtkImageData()
        image.SetDimensions(columns, rows, 1)
        colors = np.repeat(mark.gray[::-1].reshape(-1, 1), 3, axis=1)
        image.GetPointData().SetScalars(numpy_to_vtk(colors, deep=1))
        corner = self.at(mark.x, mark.y + mark.height)
        size = OVERSAMPLING * mark.width, OVERSAMPLING * mark.height
        context.GetBrush().SetColorF(1, 1, 1)
        context.DrawImage(vtkRectf(*corner, *size), image)

    def line(self, context: vtkContext2D, mark: Stroke) -> None:
        context.GetPen().SetLineType(vtkPen.SOLID_LINE)
        context.GetPen().SetWidth(OVERSAMPLING * mark.width)
        for piece in _dashes(mark):
            corners = vtkPoints2D()
            for x, y, _ in piece:
                corners.InsertNextPoint(*self.at(x, y))
            context.DrawPoly(corners)

    def area(self, context: vtkContext2D, mark: Box | Disc) -> None:
        context.GetPen().SetLineType(vtkPen.NO_PEN)
        if isinstance(mark, Disc):
            radius = OVERSAMPLING * mark.radius
            context.DrawEllipse(*self.at(mark.x, mark.y), radius, radius)
        else:
            corner = self.at(mark.x, mark.y + mark.height)
            context.DrawRect(*corner, OVERSAMPLING * mark.width, OVERSAMPLING * mark.height)


def _dashes(mark: Stroke) -> list[Points]:
    """The pieces of a line that are drawn: VTK's own dashes look unlike those of an SVG."""
    line = Line(np.pad(np.array(mark.points, dtype=np.float64), ((0, 0), (0, 1))))
    if not mark.dashes:
        return [line.points]
    whole, (dash, gap) = line.length, mark.dashes
    return [line.cut(at, min(at + dash, whole)).points for at in np.arange(0, whole, dash + gap)]


def _rgb(color: str) -> tuple[float, ...]:
    return tuple(part / 255 for part in bytes.fromhex(color[1:]))
