"""A segment of the vessel for a flow solver, before treatment and after, as `sdfstent extract` writes it."""

import numpy as np
from slicer.i18n import tr as _

from SDFStentLib import treatment
from SDFStentLib.report import segment_sentences, write_segment
from SDFStentLib.validation import InputError

from . import Conversion, Plans, Results
from .NewFolders import inNewFolder
from .Portions import inPortions, untilDone, working


class Segments:
    """A part of `SDFStentLogic`: cuts a segment out of the vessel."""

    def extractSegment(self, parameterNode, folder):
        """Write the segment between the chosen places into a new folder in `folder`; returns that.

        What there is to say of it is in `status` afterwards. Raises `InputError` or `DeploymentError` with a sentence where no plane
        cuts only this vessel.
        """
        return untilDone(self.segmentSteps(parameterNode, folder))

    def segmentSteps(self, parameterNode, folder):
        """The same in portions: an iterator over the fraction that is done, which returns the folder."""
        if None in (parameterNode.vessel, parameterNode.centerline):
            raise InputError(
                _("Segment: expected a vessel and its centerline, choose both in Inputs.")
            )
        run = self.lastRun(parameterNode)
        isMeasured = run is not None and run.result is not None
        ends = _ends(parameterNode, run if isMeasured else None)
        vessel = self._inputs.vessel(parameterNode)
        line = self._inputs.centerline(parameterNode)
        given, _misfit = untilDone(self._inputs.givenNamesInPortions(parameterNode))
        names = Plans.namesOf(parameterNode) if given else ()
        before = treatment.Vessel(vessel.surface, line, faces=vessel.faces, names=names)
        after = None
        if isMeasured and not self.hasChanged(parameterNode):
            after = treatment.Vessel(run.result.surface, faces=vessel.faces)
        inputs = {
            "surface": _named(parameterNode.vessel),
            "centerline": _named(parameterNode.centerline),
        }
        wishes = treatment.SegmentWishes(
            close_branches=parameterNode.closeBranches,
            nearest=parameterNode.segmentEnds is None,  # nobody has chosen these places
        )

        def stepsInto(new):
            yield 0.0
            found = yield from working(
                inPortions(lambda: treatment.extract_segment(before, *ends, wishes, after=after))
            )
            write_segment(new, found, inputs, ("RAS", "RAS"))
            if parameterNode.parameterNode.GetScene() is not None:
                parameterNode.status = "\n".join(_sentences(found, new))
            return new

        return inNewFolder(folder, "segment", stepsInto)


def _ends(parameterNode, run):
    """The two places between which the segment lies, in world coordinates: of the markups that are chosen, else round a stent."""
    node = parameterNode.segmentEnds
    if node is not None:
        points = Conversion.placedPoints(node)
        if len(points) < 2:
            raise InputError(
                _(
                    "Segment: expected at least two points in {name}, its first and its last one, got {count}; place them in a view."
                ).format(name=node.GetName(), count=len(points))
            )
        return points[0], points[-1]
    if run is None:
        raise InputError(
            _(
                "Segment: expected two places, got none; choose markups with two points, or deploy a stent."
            )
        )
    around = run.result.stents[Results.selectedStent(parameterNode, run)].around_before.centers
    known = around[np.isfinite(around).all(axis=1)]
    return known[0], known[-1]


def _named(node):
    """What a document of the segment says of an input: its file, when it is still as it was read, else its name in the scene."""
    file = Plans.fileOf(node)
    return {"file": node.GetName() if file is None else file.path, "sha256": None}


def _sentences(found, folder):
    """What the shell says of a segment."""
    yield from (caution.sentence() for caution in found.warnings)
    yield from segment_sentences(found)
    if found.after is None:
        yield _(
            "Before treatment only: deploy the plan as it is now to have the vessel after it, too."
        )
    yield _("Wrote {folder}, in cm.").format(folder=folder)
