"""The 3D view: Slicer's own displayable managers draw the scene off screen; it is sent as frames,
and receives clicks on the centerline."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import slicer
from trame_rca.rca import VtkRemoteControlledArea
from vtkmodules.vtkCommonCore import vtkCommand
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

from SDFStentLib.validation import InputError

from .application import ThreeDView
from .browser_input import BrowserInput
from .frames import FrameScheduler

NAME = "view"
MOST_PIXELS = 700_000
"""Largest number of pixels of a frame, however large and fine the screen is: each takes 60 bytes of
the window's buffers."""

MOVING_SCALE = 0.6
"""Scale of the frames while something moves, relative to the page."""

FILLED = 0.92
"""Part of the view that the scene fills."""

NEAR_PX = 24.0
"""Largest distance of a click from the centerline that it is meant for."""

SIDES = ("Anterior", "Posterior", "Left", "Right", "Superior", "Inferior")
"""Sides of the patient, with Slicer's names: the scene has the patient's axes, whatever the axes of
the files."""

MARK = (0.95, 0.75, 0.1)
"""Color of the mark for the place at which the user points in the plot."""

IN_FRONT = -66_000
"""Depth offset of the mark, the same that Slicer uses for objects that are seen through everything
in front of them."""

BACKGROUNDS = {
    "light": ((0.97, 0.97, 0.98), (0.86, 0.89, 0.93)),
    "dark": ((0.10, 0.11, 0.13), (0.16, 0.18, 0.22)),
}


class PageView(ThreeDView):
    """The off-screen view of a page's scene. `on_click(x, y)` receives every click first; if it
    returns true, the scene does not."""

    def __init__(self, application: Any, on_click: Callable[[float, float], bool]) -> None:
        super().__init__(application, vtkGenericRenderWindowInteractor())
        self.window.ShowWindowOff()
        self.node.SetBoxVisible(False)
        self.node.SetAxisLabelsVisible(False)
        self.node.SetOrientationMarkerType(self.node.OrientationMarkerTypeAxes)
        self.node.SetOrientationMarkerSize(self.node.OrientationMarkerSizeSmall)
        self.node.SetRenderMode(self.node.Orthographic)  # else a scale is true at one depth only
        self.node.SetRulerType(self.node.RulerTypeThin)
        self.area = _Area(self.window, on_click, self._take_size)
        self._frames: FrameScheduler | None = None
        self._whole: tuple[Any, ...] | None = None
        self._ball, self._mark = vtkSphereSource(), vtkActor()
        self._ball.SetThetaResolution(32)
        self._ball.SetPhiResolution(16)
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(self._ball.GetOutputPort())
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0, IN_FRONT)
        self._mark.SetMapper(mapper)
        self._mark.GetProperty().SetColor(*MARK)
        self._mark.VisibilityOff()
        self.renderer.AddActor(self._mark)

    def serve(self, on_frame: Callable[[], None]) -> BrowserInput:
        """The adapter that sends the frames from now on; needs a running event loop. `on_frame()`
        is called before each moving frame."""
        self._frames = FrameScheduler(self.area, on_frame)
        self.group.AddObserver(vtkCommand.UpdateEvent, lambda *_: self.draw())
        adapter = BrowserInput(
            self.area, NAME, scheduler=self._frames, do_schedule_render_on_interaction=False
        )
        adapter.max_pixel_count = MOST_PIXELS
        return adapter

    def draw(self) -> None:
        """Send a frame soon."""
        if self._frames is not None:
            self._frames.schedule_render()

    @property
    def frames(self) -> int:
        """The number of frames begun while something moved."""
        return 0 if self._frames is None else self._frames.count

    @property
    def isBehind(self) -> bool:
        """Whether the browser has not yet been sent the latest picture."""
        return self._frames is not None and self._frames.isBehind

    def paint(self, theme: str) -> None:
        """Set the background for a `light` or a `dark` page."""
        isDark, camera = theme == "dark", self.renderer.GetActiveCamera()
        seen = camera.GetParallelScale()
        below, above = BACKGROUNDS["dark" if isDark else "light"]
        self.node.SetBackgroundColor(*below)
        self.node.SetBackgroundColor2(*above)
        self.node.SetRulerColor(self.node.RulerColorWhite if isDark else self.node.RulerColorBlack)
        # Any change of a view node without perspective resets the scale to its whole field of view.
        camera.SetParallelScale(seen)

    def look_at_all(self) -> None:
        """Show everything from the front, as Slicer does."""
        camera = self._camera()
        camera.RotateTo(slicer.vtkMRMLCameraNode.Anterior)
        self.renderer.ResetCamera()
        self.renderer.ResetCameraScreenSpace(FILLED)
        self.renderer.ResetCameraClippingRange()
        self._whole = self._looks()
        self.draw()

    def _take_size(self) -> None:
        """Let the scene fill a new size, unless the user has changed the camera."""
        if self._whole in (None, self._looks()):
            self.look_at_all()

    def _looks(self) -> tuple[Any, ...]:
        """The state of the camera: its position, focal point, up direction and scale."""
        camera = self.renderer.GetActiveCamera()
        way = (*camera.GetPosition(), *camera.GetFocalPoint(), *camera.GetViewUp())
        return (*way, camera.GetParallelScale())

    def look_from(self, side: str) -> None:
        """Show the present center of the view from one of the `SIDES`."""
        if side in SIDES:
            self._camera().RotateTo(getattr(slicer.vtkMRMLCameraNode, side))
            self.renderer.ResetCameraClippingRange()
            self.draw()

    def mark(self, center: np.ndarray | None, diameter: float) -> None:
        """Show a ball of this diameter, in mm, around a point in space (3,); with None hide it."""
        self._mark.SetVisibility(center is not None)
        if center is not None:
            self._ball.SetCenter(*center)
            self._ball.SetRadius(diameter / 2)
        self.draw()

    def picture(self) -> tuple[np.ndarray, int, int]:
        """Colors (rows, columns, 3), number of columns and number of rows of the picture that is
        seen."""
        return self.area.picture(isCoarse=False)

    def _camera(self) -> Any:
        manager = self.group.GetDisplayableManagerByClassName("vtkMRMLCameraDisplayableManager")
        return manager.GetCameraNode()

    def nearest(self, points: np.ndarray, x: float, y: float) -> np.ndarray:
        """The point, among points in space (n, 3), that is seen nearest to a pixel; raises
        `InputError` if none is near."""
        seen = self.pixels(points)
        distance = np.linalg.norm(seen - (x, y), axis=1)
        index = int(np.argmin(distance))
        if not distance[index] <= NEAR_PX:
            raise InputError(
                "Placing: expected a click on the centerline, got one beside it; click on the line in the vessel."
            )
        return points[index]

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """The places on the screen of points in space (n, 3), in pixels from the lower left corner
        (n, 2)."""
        matrix = self.renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(
            self.renderer.GetTiledAspectRatio(), -1, 1
        )
        rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        clip = np.column_stack([points, np.ones(len(points))]) @ rows.T
        size = np.array(self.window.GetSize())
        return (clip[:, :2] / clip[:, 3:] + 1) / 2 * size


class _Area(VtkRemoteControlledArea):
    """Sends frames and receives mouse and keys. Moving frames are drawn coarser: without a GPU,
    pixels take the time."""

    def __init__(
        self,
        window: Any,
        on_click: Callable[[float, float], bool],
        on_new_size: Callable[[], None],
    ) -> None:
        super().__init__(window)
        self._window = window
        self._on_click, self._is_taken = on_click, False
        self._on_new_size = on_new_size

    def picture(self, isCoarse: bool) -> tuple[np.ndarray, int, int]:
        """Colors (rows, columns, 3), number of columns and number of rows of a frame."""
        if not isCoarse:
            return self.img_cols_rows
        size = self._window.GetSize()
        self._window.SetSize(*(max(10, round(MOVING_SCALE * side)) for side in size))
        try:
            return self.img_cols_rows
        finally:
            self._window.SetSize(*size)

    def process_resize_event(self, width: int, height: int) -> None:
        super().process_resize_event(width, height)
        self._on_new_size()

    def process_interaction_event(self, event: dict[str, Any]) -> None:
        kind = event.get("type", "")
        if kind == "LeftButtonPress" and self._on_click(event.get("x", 0), event.get("y", 0)):
            self._is_taken = True
        elif self._is_taken:  # the scene has not heard of the press, so nothing of the rest
            self._is_taken = kind != "LeftButtonRelease"
        else:
            if kind == "LeftButtonPress":  # a finger comes to a handle without a move before
                super().process_interaction_event({**event, "type": "MouseMove"})
            super().process_interaction_event(event)
