"""Where the numbers of lesions stand in the view, as it is seen."""

from types import SimpleNamespace

import numpy as np
import pytest
import slicer
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter


def aLesion(point, along, diameter):
    """As much of one as its number is placed by."""
    from SDFStentLib.geometry import Line

    points = np.add(point, np.outer([-4.0, 0.0, 4.0], along / np.linalg.norm(along)))
    return SimpleNamespace(point=point, line=Line(points), reference_diameter=diameter)


@pytest.mark.parametrize("seed", range(6))
def test_numbers_of_lesions_do_not_lie_on_each_other_or_on_the_vessel(theModule, seed):
    from SDFStentSlicer.SignPlaces import besides

    rng = np.random.default_rng(seed)
    lesions = [
        aLesion(rng.uniform(-15, 15, 3), rng.normal(size=3), rng.uniform(4, 9)) for _n in range(8)
    ]
    lesions.append(aLesion(np.zeros(3), np.array([0.0, 1.0, 0.0]), 6.0))  # toward who looks
    places = besides(lesions)
    for number, (place, lesion) in enumerate(zip(places, lesions, strict=True)):
        off = lesion.line.nearest(place[None]).distances[0]
        assert off >= 0.9 * lesion.reference_diameter
        others = [np.linalg.norm(place - other) for other in places[:number]]
        assert not others or min(others) > 3.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [(392, 310), (1400, 700)])
def test_signs_of_lesions_do_not_lie_on_each_other_as_they_are_seen(theModule, seed, size):
    """Eight in a lung, held against pixels of VTK's own projection in views of two sizes."""
    import vtk
    from SDFStentSlicer.SignPlaces import besides

    rng = np.random.default_rng(seed)
    lesions = [
        aLesion(rng.uniform(-15, 15, 3), rng.normal(size=3), rng.uniform(3, 5)) for _n in range(8)
    ]
    window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
    window.SetSize(*size)
    window.SetOffScreenRendering(True)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(0.0, 164.0, 0.0)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    camera.SetViewUp(0.0, 0.0, 1.0)
    pixels = []
    for place in besides(lesions, renderer):
        renderer.SetWorldPoint(*place, 1.0)
        renderer.WorldToDisplay()
        pixels.append(renderer.GetDisplayPoint()[:2])
    high = 0.04 * np.hypot(*size)  # of the text: 4 % of a view, as the display node is told
    for number, first in enumerate(pixels):
        for other, second in enumerate(pixels[:number]):
            across, up = np.abs(np.subtract(first, second))
            letters = sum(len(str(one + 1)) for one in (number, other)) / 2 + 1
            assert across >= 0.6 * high * letters or up >= high


@pytest.fixture
def marks(host):
    """Of lesions in the view of the application, of one size, which shows no line of text yet."""
    from SDFStentSlicer.LesionMarks import LesionMarks
    from SDFStentSlicer.PanelState import AtHand

    slicer.app.showMainWindow(True)
    window = host.application.view.window
    former = window.GetSize()
    window.SetSize(900, 675)
    made = LesionMarks()
    yield made
    window.SetSize(*former)
    made.show(())
    AtHand().show("")
    slicer.app.showMainWindow(False)


def rest(host, marks):
    """Draw until the signs have their places."""
    host.application.view.window.Render()
    host.processUntil(lambda: not marks._view._timer.isActive())


def signsIn(view, marks):
    """Where the signs are seen: left, right, bottom and top of each, pixels."""
    text = 0.04 * np.hypot(*view.renderer.GetSize())
    boxes = []
    for index in range(marks._numbers.GetNumberOfControlPoints()):
        x, y = view.pixel(marks._numbers.GetNthControlPointPositionWorld(index))
        high, wide = 1.15 * text, 0.63 * text * (len(str(index + 1)) + 1)  # as in the application
        boxes.append((x - wide / 2, x + wide / 2, y - high / 2, y + high / 2))
    return np.array(boxes)


def areApart(one, other):
    return one[0] >= other[1] or other[0] >= one[1] or one[2] >= other[3] or other[2] >= one[3]


DIRECTIONS = [(0.0, -1.0, 0.15), (1.0, 0.2, 0.1), (-0.4, 1.0, 0.3), (0.6, -0.6, -0.5)]


@pytest.mark.parametrize("size", [(900, 675), (392, 310)])
def test_signs_stay_apart_when_the_view_is_turned_and_resized(host, marks, size):
    view, rng = host.application.view, np.random.default_rng(5201)
    lesions = [
        aLesion(rng.uniform(-30, 30, 3), rng.normal(size=3), rng.uniform(3, 5)) for _n in range(8)
    ]
    marks.show(lesions)
    view.window.SetSize(*size)
    for direction in DIRECTIONS:
        view.look((-50, 50, -50, 50, -50, 50), direction, zoom=1.0)
        rest(host, marks)
        boxes = signsIn(view, marks)
        for number, box in enumerate(boxes):
            assert all(areApart(box, other) for other in boxes[:number]), (direction, number)


def test_signs_that_lie_on_nothing_stay(host, marks):
    view, rng = host.application.view, np.random.default_rng(5202)
    marks.show([aLesion(rng.uniform(-30, 30, 3), rng.normal(size=3), 4.0) for _n in range(5)])
    view.look((-50, 50, -50, 50, -50, 50), zoom=1.0)
    rest(host, marks)
    modified = marks._numbers.GetMTime()
    for zoom in (1.05, 0.98):
        view.renderer.GetActiveCamera().Zoom(zoom)
        rest(host, marks)
    assert marks._numbers.GetMTime() == modified


def test_signs_come_nearer_when_there_is_room_again(host, marks):
    """One that was put aside in a small view from afar stayed 60 mm from its lesion, beside another one."""
    from SDFStentSlicer.SignPlaces import besides

    view, rng = host.application.view, np.random.default_rng(5203)
    lesions = [aLesion(rng.uniform(-15, 15, 3), rng.normal(size=3), 5.0) for _n in range(13)]
    points = np.array([one.point for one in lesions])
    marks.show(lesions)
    view.window.SetSize(392, 310)
    view.look((-150, 150, -150, 150, -150, 150), zoom=1.0)
    rest(host, marks)
    view.window.SetSize(900, 675)
    view.look((-30, 30, -30, 30, -30, 30), zoom=1.0)
    rest(host, marks)
    signs = [marks._numbers.GetNthControlPointPositionWorld(n) for n in range(len(lesions))]
    away = np.linalg.norm(np.array(signs) - points, axis=1)
    anew = np.linalg.norm(np.array(besides(lesions, view.renderer)) - points, axis=1)
    assert away.max() < 1.5 * anew.max()
    assert away.mean() < 1.5 * anew.mean()
    boxes = signsIn(view, marks)
    for number, box in enumerate(boxes):
        assert all(areApart(box, other) for other in boxes[:number]), number


def linesIn(view, color):
    """Left, right, bottom and top of what is drawn in the color of the ground of the lines, pixels."""
    grabber = vtkWindowToImageFilter()
    grabber.SetInput(view.window)
    grabber.ReadFrontBufferOff()
    grabber.Update()
    image = grabber.GetOutput()
    width, height, _one = image.GetDimensions()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[..., :3]
    rows, columns = np.nonzero((np.abs(pixels - 255.0 * np.array(color)) < 1.5).all(axis=-1))
    return columns.min(), columns.max() + 1, rows.min(), rows.max() + 1


def test_no_sign_lies_on_the_lines_at_the_hand(host, marks):
    from SDFStentSlicer.PanelState import BACKGROUND, AtHand

    view = host.application.view
    view.look((-50, 50, -50, 50, -50, 50), (0.0, 1.0, 0.0), zoom=1.0)
    height, renderer = view.renderer.GetSize()[1], view.renderer
    view.pixel((0.0, 0.0, 0.0))
    depth, places = renderer.GetDisplayPoint()[2], []
    for x, y in ((30, 20), (120, 40), (60, 90), (500, 400)):  # the lines will be on three of them
        renderer.SetDisplayPoint(x, height - y, depth)
        renderer.DisplayToWorld()
        places.append(np.array(renderer.GetWorldPoint()[:3]) / renderer.GetWorldPoint()[3])
    marks.show([aLesion(one, np.array([1.0, 0.0, 0.4]), 6.0) for one in places])
    rest(host, marks)
    AtHand().show("\n".join(f"line {number} of what is told there" for number in range(6)))
    view.window.Render()
    lines = linesIn(view, BACKGROUND)
    assert not all(areApart(box, lines) for box in signsIn(view, marks))
    rest(host, marks)
    boxes, (width, height) = signsIn(view, marks), view.renderer.GetSize()
    assert (boxes[:, 0] >= 0).all()
    assert (boxes[:, 1] <= width).all()
    assert (boxes[:, 2] >= 0).all()
    assert (boxes[:, 3] <= height).all()
    assert all(areApart(box, lines) for box in boxes)
