"""Views of a stent: the library's sight of it, and what an X-ray would show there just now."""

from slicer.i18n import tr as _

from SDFStentLib.report import Sight, lesion_stretch, stent_stretch
from SDFStentLib.validation import InputError

from . import Results

NOTHING = _(
    "Working view: expected a stent or a lesion to look at, got none; add a stent, and put it on the vessel."
)


class Sighting:
    """A part of `SDFStentLogic`. Angles are of the scene, whose frame is RAS: Slicer takes a file that names none for LPS."""

    _sight = (None, None)

    def sightInPortions(self, parameterNode):
        """The library's `Sight` of the selected stent, or without one of the first lesion: a generator that yields None until it is known.

        Raises `InputError` where there is neither, and without a vessel or its centerline.
        """
        key = self.sightKey(parameterNode)
        if key != self._sight[0]:
            self._sight = key, (yield from self._newSight(parameterNode))
        return self._sight[1]

    def sightKey(self, parameterNode):
        """A value that differs whenever that would."""
        standing = self.standing(parameterNode)
        return standing.signature, parameterNode.selected, self._resultNow(parameterNode, standing)

    def _newSight(self, parameterNode):
        search = self.lesionSearch(parameterNode)
        if search is None:
            raise InputError(
                _("Working view: expected a vessel and its centerline, choose both in Vessel.")
            )
        yield from search.portions()
        if search.vessel is None or search.sentence:
            raise InputError(search.sentence)
        run, result = self.lastRun(parameterNode), self._resultNow(parameterNode)
        if result is not None:
            treated = result.stents[Results.selectedStent(parameterNode, run)]
            stretch = stent_stretch(treated, run.lesions)
        elif lying := self.lying(parameterNode, search.vessel.centerline):
            stretch = stent_stretch(lying, None)
        elif search.found:
            stretch = lesion_stretch(1, search.found[0])
        else:
            raise InputError(NOTHING)
        return Sight(stretch, search.vessel, "RAS")

    def wallNow(self, parameterNode):
        """Surface as it is shown, of the library, and the curves of the struts in it; the sight has to be known."""
        wall, run = self._sight[1].vessel.surface, self.lastRun(parameterNode)
        if run is None or run.surface is not wall:
            return wall, []
        points, stents = run.at(parameterNode.expansion)
        return wall.with_points(points), [one.placed.lattice(one.radius).curves for one in stents]

    def _resultNow(self, parameterNode, standing=None):
        """Result that was measured of the plan as it is now, else None."""
        run = self.lastRun(parameterNode)
        isOld = run is None or run.result is None or self.hasChanged(parameterNode, standing)
        return None if isOld else run.result
