"""The camera of the first 3D view as a C-arm, and a film before everything that it sees."""

import math

import numpy as np
import slicer
from slicer.i18n import tr as _
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer

from . import Marks

BEFORE = 0.9
"""Part of the way to the camera where a film is: what lies behind it is not seen."""


def first():
    """The node of the camera of the first 3D view; None without one."""
    return slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLCameraNode")


def toward(camera):
    """The direction from what a camera looks at to where it is (3,), a unit vector."""
    back = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
    return back / np.linalg.norm(back)


def turn(camera, axes):
    """Look at the same place from elsewhere: `axes` (3, 3) are right, up, and toward the camera."""
    place = np.array(camera.GetFocalPoint())
    distance = np.linalg.norm(np.subtract(camera.GetPosition(), place))
    with slicer.util.NodeModify(camera):
        camera.SetPosition(*(place + distance * axes[2]))
        camera.SetViewUp(*axes[1])
    camera.ResetClippingRange()


def look(camera, middle, axes, size):
    """Look as `turn` does at another place (3,), of whose surroundings `size` mm fill the height of the view."""
    distance = size / 2 / math.tan(math.radians(camera.GetViewAngle()) / 2)
    with slicer.util.NodeModify(camera):
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(np.asarray(middle) + distance * axes[2]))
        camera.SetViewUp(*axes[1])
        camera.SetParallelScale(size / 2)
    camera.ResetClippingRange()


class FilmNode:
    """Node of one film of the library at a time, in front of all that the camera sees: nothing else is to be taken for a part of it."""

    def __init__(self):
        self._node = self._film = None
        # Kept: the display node does not hold who makes its picture.
        self._picture = vtkTrivialProducer()

    @property
    def isShown(self):
        """Whether a film is shown."""
        return self._film is not None

    def show(self, film, camera):
        """Show a film in the view of a camera that looks along its axes."""
        if self._node is None or self._node.GetScene() is None:
            self._node = slicer.mrmlScene.AddNode(Marks.newNode("vtkMRMLModelNode", _("X-ray")))
            self._node.CreateDefaultDisplayNodes()
            _asFilm(self._node.GetDisplayNode())
        self._film = film
        _inViewOf(camera, self._node.GetDisplayNode())
        self._picture.SetOutput(_image(film.gray))
        self._node.GetDisplayNode().SetTextureImageDataConnection(self._picture.GetOutputPort())
        self.follow(camera)
        self._node.GetDisplayNode().SetVisibility(True)

    def follow(self, camera):
        """Keep its size in the view: the nearer to the camera it is, the smaller."""
        if self._film is None:
            return
        film, position = self._film, np.array(camera.GetPosition())
        shift = BEFORE * (position - film.middle) @ film.axes[2] * film.axes[2]
        middle, scale = film.middle + shift, 1.0
        if not camera.GetParallelProjection():
            # Along the way to the camera, so that it covers the same in the view.
            middle = film.middle + BEFORE * (position - film.middle)
            scale = 1 - BEFORE
        half = scale * film.side / 2 * film.axes[:2]
        corners = [
            middle + x * half[0] + y * half[1] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        self._node.SetAndObservePolyData(_square(np.array(corners)))
        _letSee(camera, np.linalg.norm(position - film.middle))

    def hide(self):
        """Hide the film."""
        self._film = None
        if self._node is not None and self._node.GetScene() is not None:
            self._node.GetDisplayNode().SetVisibility(False)

    def remove(self):
        """Remove its nodes from the scene."""
        self.hide()
        Marks.removeMark(self._node)
        self._node = None


def _letSee(camera, distance):
    """Let a camera at that distance see a film: its range was chosen for what lies farther away."""
    near, far = camera.GetCamera().GetClippingRange()
    nearest = (1 - BEFORE) / 2 * distance
    if near > nearest:
        camera.GetCamera().SetClippingRange(nearest, far)


def _inViewOf(camera, display):
    """Show a node only in the view of its camera: another one looks from elsewhere."""
    views = slicer.util.getNodesByClass("vtkMRMLViewNode")
    own = [one.GetID() for one in views if one.GetLayoutName() == camera.GetLayoutName()]
    if own != [display.GetNthViewNodeID(n) for n in range(display.GetNumberOfViewNodeIDs())]:
        display.RemoveAllViewNodeIDs()
        for viewID in own:
            display.AddViewNodeID(viewID)


def _asFilm(display):
    display.SetSaveWithScene(False)
    display.SetColor(1.0, 1.0, 1.0)
    display.SetLighting(False)
    display.SetAmbient(1.0)
    display.SetDiffuse(0.0)
    display.SetSpecular(0.0)
    display.SetInterpolateTexture(True)
    display.SetBackfaceCulling(True)
    display.SetFrontfaceCulling(False)


def _image(gray):
    """A picture (n, m), whose first row is at the top."""
    rows, columns = gray.shape
    image = vtkImageData()
    image.SetDimensions(columns, rows, 1)
    pixels = np.repeat(np.ascontiguousarray(gray[::-1]).reshape(-1, 1), 3, axis=1)
    image.GetPointData().SetScalars(numpy_to_vtk(pixels, deep=True))
    return image


def _square(corners):
    """A square (4, 3) on which a picture lies with its edges."""
    points, cells, made = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(corners, deep=True))
    cells.InsertNextCell(4, range(4))
    made.SetPoints(points)
    made.SetPolys(cells)
    places = numpy_to_vtk(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), deep=True)
    places.SetName("TextureCoordinates")
    made.GetPointData().SetTCoords(places)
    return made
