"""Stents while they are dragged: the library's preview, off the application's thread. No nodes in here."""

import threading

from SDFStentLib.measure import displacements, face_stretches
from SDFStentLib.treatment import Preview

from .Portions import inPortions


class PreviewedVessel:
    """One vessel on which plans are tried out. What is made for it once is made once, whoever waits for it."""

    def __init__(self, surface, centerline):
        self.surface = surface
        self._preview, self._lock = Preview(surface, centerline), threading.Lock()

    def portions(self, planned, settings, straightening, places):
        """Preview a plan; yields None until it is done, then returns its `PreviewRun`."""
        return (
            yield from self._inTurn(
                lambda: PreviewRun(
                    self.surface,
                    self._preview.of(planned, settings, straightening_fraction=straightening),
                    places,
                )
            )
        )

    def prepared(self):
        """Make what the first preview needs, wherever it will be; yields None until it is done."""
        yield from self._inTurn(self._preview.prepare)

    def _inTurn(self, function):
        """Run a function after those before it; not at all when nobody waits for it any more."""
        isWanted = [True]

        def run():
            with self._lock:
                return function() if isWanted[0] else None

        try:
            return (yield from inPortions(run))
        finally:
            isWanted[0] = False


class PreviewRun:
    """What a preview shows, in the words of `Stenting`; it has no steps to go back to."""

    recorded = ()
    result = lesions = centerline = None

    def __init__(self, surface, state, places):
        self.surface, self.state, self.places = surface, state, list(places)
        self.shownMap = self.shownStent = None

    @property
    def points(self):
        """All points of the vessel."""
        points = self.surface.points.copy()
        points[self.state.indices] = self.state.coordinates
        return points

    def lumens(self):
        """Measure the minimum lumen of every stent, mm; yields None until it is done, then returns a list."""
        return (yield from inPortions(lambda: [one.minimum_lumen() for one in self.state.stents]))

    def tubes(self):
        """(axis points, radius) of every stent."""
        return [(one.axis.points, one.stent.radius) for one in self.state.stents]

    def at(self, percent):
        """The points before or after the stents, and the stents that are there."""
        return self.end() if percent > 0 else (self.surface.points, [])

    def end(self):
        """The points after the stents, and (axis points, radius) of every stent."""
        return self.points, self.tubes()

    def map(self, name):
        """Values of a surface map and whether they belong to the cells."""
        if name == "Displacement":
            return displacements(self.surface.points, self.points), False
        return face_stretches(self.surface, self.points).area, True
