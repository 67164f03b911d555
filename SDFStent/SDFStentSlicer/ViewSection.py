"""The section Working view of the panel: the 3D view as a C-arm that turns to where a stent is seen best, and an X-ray there."""

import numpy as np
from slicer.i18n import tr as _
from slicer.util import VTKObservationMixin
from vtkmodules.vtkCommonCore import vtkCommand

from SDFStentLib.plan import views_of
from SDFStentLib.report import view_axes, view_toward
from SDFStentLib.validation import InputError

from . import Camera
from .Portions import RestedRun, SteppedRun, inPortions, working

REST_MS = 250
"""A plan and a view have to rest so long before it is worked out how they are seen."""

NO_SECOND = _(
    "Second view: expected one that is far enough from the best one, the arm reaches none; let it turn farther in the plan."
)

SAME = 1e-6
"""Difference up to which two directions, as unit vectors, are one."""


class ViewSection(VTKObservationMixin):
    """Turns the camera to the view of the plan, and shows and describes the X-ray from its present place.

    `attempt(action)` does what is asked for and says why when it cannot be done; `showAngles(text)` shows lines in the 3D view.
    """

    def __init__(self, ui, logic, attempt, showAngles):
        VTKObservationMixin.__init__(self)
        self.ui, self._logic, self._attempt, self._showAngles = ui, logic, attempt, showAngles
        self._parameterNode = self._camera = self._turnedTo = self._view = self._seen = None
        self._film = Camera.FilmNode()
        self._rest = RestedRun(self._look, self._onLooked, REST_MS)
        self._rest.follow(self, None)
        self._searching = SteppedRun(lambda _value: None, self._onFound)
        ui.viewsCollapsibleButton.connect(
            "contentsCollapsed(bool)", lambda _isClosed: self._follow()
        )
        ui.workingViewButton.connect("clicked()", lambda: self._onWorkingView("best"))
        ui.secondViewButton.connect("clicked()", lambda: self._onWorkingView("second"))

    @property
    def isBusy(self):
        """Whether something is worked out, or about to be."""
        return self._rest.isBusy or self._searching.isRunning

    @property
    def isXrayShown(self):
        """Whether a film of the present stents is shown."""
        return self._film.isShown

    def show(self, parameterNode):
        """Show a parameter node, which may have changed; None for none."""
        if parameterNode is None:
            self.leave()
            return
        isAnother = parameterNode is not self._parameterNode
        if isAnother:
            self._searching.cancel()
        self._parameterNode = parameterNode
        chosen = self._chosen()
        if isAnother:
            self._turnedTo = chosen  # what is seen stays as it is
        self._watch()
        if chosen not in (None, self._turnedTo) and self._camera is not None:
            self._turnedTo = chosen
            Camera.turn(self._camera, view_axes(chosen, "RAS"))
        self._turnedTo = chosen
        self._follow()

    def leave(self):
        """Leave nothing in the views."""
        self._searching.cancel()
        self._parameterNode = None
        self._rest.follow(self, None)
        self._film.remove()
        self._showAngles("")
        self.removeObservers()
        self._camera = None

    def _chosen(self):
        """The view of the plan, or None."""
        wishes = views_of(self._parameterNode.get("views"))
        return None if wishes is None else wishes.view

    def _watch(self):
        camera = Camera.first()
        if camera is not self._camera:
            self.removeObservers()
            self._camera = camera
            if camera is not None:
                self.addObserver(camera, vtkCommand.ModifiedEvent, self._onCamera)

    def _onCamera(self, _caller=None, _event=None):
        if self._parameterNode is not None:
            self._film.follow(self._camera)
            self._follow()

    def _follow(self):
        """Follow what is seen, which may be another thing now: an old film goes at once, and what is told of it; a new one comes at rest."""
        what = self._what()
        if what != self._seen:
            self._seen = what
            self._film.hide()
            self._view = None if what is None else view_toward(Camera.toward(self._camera), "RAS")
            words = "" if self._view is None else self._view.words
            self._showAngles(words)
            self._say(words)
        self._rest.follow(self, what)

    def _what(self):
        """Key of the film's content; None while nobody wants to see it."""
        node = self._parameterNode
        if node is None or self._camera is None:
            return None
        if self.ui.viewsCollapsibleButton.collapsed and not node.showXray:
            return None
        direction = tuple(np.round(Camera.toward(self._camera) / SAME).tolist())
        shown = (self._logic.lastRun(node), node.expansion) if node.showXray else ()
        return self._logic.sightKey(node), direction, node.showXray, shown

    def _look(self):
        node, view = self._parameterNode, self._view
        sight = yield from self._logic.sightInPortions(node)
        facts = yield from inPortions(lambda: sight.facts_from(view))
        film = None
        if node.showXray:
            wall, struts = self._logic.wallNow(node)
            film = yield from inPortions(lambda: sight.film(wall, view, struts))
        self._tell(view, facts, film)

    def _tell(self, view, facts, film):
        told = map(facts.named, ("foreshortening_percent", "covered_percent"))
        lines = [view.words, *(f"{one.label.lower()} {one.words}" for one in told)]
        if film is not None:
            self._film.show(film, self._camera)
            isOld = self._logic.hasChanged(self._parameterNode)
            words = _("X-ray, bar {length:g} mm").format(length=film.bar)
            lines += [words, *([_("before the last change")] if isOld else [])]
        self._showAngles("\n".join(lines))
        self._say(facts.named("_sentence").words)

    def _say(self, text):
        self.ui.viewLabel.text = text
        self.ui.viewLabel.visible = bool(text)

    def _onLooked(self, error):
        if error is not None:
            self._logic.log(error)
            self._say(self._logic.sentence(error))

    def _onWorkingView(self, which):
        if self._parameterNode is not None and not self._searching.isRunning:
            self._attempt(lambda: self._searching.start(working(self._found(which))))

    def _found(self, which):
        """Work out the views, and have one of them in the plan."""
        node = self._parameterNode
        sight = yield from self._logic.sightInPortions(node)
        wishes = views_of(node.get("views"))
        told = yield from inPortions(lambda: sight.told(wishes))
        seen = getattr(told.found, which)
        if seen is None:
            raise InputError(NO_SECOND)
        if self._camera is not None:
            beam = sight.beam(seen.view)
            Camera.look(self._camera, beam.isocenter, beam.axes, beam.side)
        node.change({"views.lao": seen.view.primary, "views.cra": seen.view.secondary})

    def _onFound(self, error):
        if error is not None:
            self._attempt(lambda: _raise(error))


def _raise(error):
    raise error
