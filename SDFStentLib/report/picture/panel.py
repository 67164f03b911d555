"""One panel of a picture in VTK: the wall, colored and lit."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from ...files import polydata_from_arrays, polydata_from_lines
from ...validation import Floats
from .shapes import Panel
from .view import BOTTOM, HEIGHT, TOP

LAYERS = 8
"""Walls in front of each other that are told apart."""

STEEL = (0.30, 0.34, 0.40)

STRUT_PIXELS = 2.0
"""Width of a strut in the picture, whatever its scale."""


def seen(panel: Panel, columns: int) -> vtkRenderer:
    """A renderer in its part of a picture of so many columns."""
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
