"""Files that the logic writes: the device, networks for a 0D solver, and a segment of the vessel in a new folder."""

import shutil
from pathlib import Path

import numpy as np
from slicer.i18n import tr as _

from SDFStentLib.files import (
    cannot_write,
    check_suffix,
    check_writable,
    read_surface,
    write_bytes,
)
from SDFStentLib.plan import Case, device_vtp
from SDFStentLib.report import document_json, write_segment
from SDFStentLib.validation import InputError

from . import Conversion, Display, Plans, Results
from .Portions import inPortions, untilDone, working


def newFolder(parent, name):
    """Make a new folder in another one; nothing is overwritten."""
    folder = Path(parent) / name
    try:
        folder = freePath(folder)
        folder.mkdir()
    except OSError as error:
        raise cannot_write(folder, error) from error
    return folder


def freePath(path):
    """The path, with a number behind its name if it exists already."""
    free, number = path, 1
    # Ends, since there are finitely many files.
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem} {number}")
    return free


def inNewFolder(parent, name, stepsInto):
    """The iterator that `stepsInto` makes for a new folder; the folder is removed if the iterator fails
    or is stopped."""
    folder = newFolder(parent, name)
    try:
        return (yield from stepsInto(folder))
    except BaseException as error:
        shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            raise cannot_write(folder, error) from error
        raise


class Exporting:
    """A part of `SDFStentLogic` that writes files of the last deployment."""

    def writeDevice(self, path, parameterNode):
        """Write the stents as VTP, as `sdfstent deploy --export-device` does: rings and struts, or the chosen mesh.

        The file is in world coordinates, mm. Raises `InputError` with a sentence, for example if the present plan was
        not deployed.
        """
        check_suffix(path, _("a device"), (".vtp",))
        node = parameterNode.deviceMesh
        mesh = None if node is None else Conversion.stentMesh(node)
        content = device_vtp(self._deployed(parameterNode), mesh, frame="RAS")
        _write(path, content, parameterNode)

    def write0D(self, path, parameterNode):
        """Write the stented vessel as a network for svZeroDSolver, and that before beside it, as `--export-0d` does;
        errors as above."""
        check_suffix(path, _("a network"), (".json",))
        self._deployed(parameterNode)
        answer = self.lastRun(parameterNode).flow
        if answer is None:
            raise InputError(
                _(
                    "Results: expected a flow, without which there is no network, got none; set the flow first."
                )
            )
        before, after = map(document_json, answer.documents())
        path = Path(path)
        _write(path.with_stem(f"{path.stem}_before"), before.encode(), parameterNode)
        _write(path, after.encode(), parameterNode)

    def loadDeviceMesh(self, path, parameterNode):
        """Add a straight stent mesh from a file, in mm, to the scene and choose it; returns its node."""
        surface = read_surface(path, "mm").surface
        parameterNode.deviceMesh = Display.addMesh(parameterNode, path, surface)
        return parameterNode.deviceMesh

    def isDeployed(self, parameterNode):
        """Whether a deployment's result was measured."""
        run = self.lastRun(parameterNode)
        return run is not None and run.result is not None

    def _deployed(self, parameterNode):
        if not self.isDeployed(parameterNode) or self.hasChanged(parameterNode):
            raise InputError(
                _(
                    "Results: expected the plan deployed as it is now, it is not; click Deploy first."
                )
            )
        return self.lastRun(parameterNode).result


def _write(path, content, parameterNode):
    write_bytes(check_writable(path), content)
    parameterNode.status = _("Wrote {path}.").format(path=path)


class Segments:
    """A part of `SDFStentLogic` that cuts a segment out of the vessel."""

    def extractSegment(self, parameterNode, folder):
        """Write the segment between the chosen places into a new folder in `folder`, and return the new folder.

        Remarks on it are in `status` afterward. Raises `InputError` or `DeploymentError` with a sentence if no plane
        cuts only this vessel.
        """
        return untilDone(self.segmentSteps(parameterNode, folder))

    def segmentSteps(self, parameterNode, folder):
        """Write a segment in portions: an iterator over the fraction done, which returns the folder."""
        if None in (parameterNode.vessel, parameterNode.centerline):
            raise InputError(
                _("Segment: expected a vessel and its centerline, choose both in Vessel.")
            )
        run = self.lastRun(parameterNode)
        isMeasured = run is not None and run.result is not None
        ends = _ends(parameterNode, run if isMeasured else None)
        case = Case(self._inputs.patient(parameterNode))
        result = run.result if isMeasured and not self.hasChanged(parameterNode) else None
        inputs = {
            "surface": _named(parameterNode.vessel),
            "centerline": _named(parameterNode.centerline),
        }
        wishes = {
            "close_branches": parameterNode.closeBranches,
            "nearest": parameterNode.segmentEnds is None,  # nobody has chosen these places
        }

        def stepsInto(new):
            yield 0.0
            found = yield from working(inPortions(lambda: case.segment(*ends, result, **wishes)))
            write_segment(new, found, inputs, ("RAS", "RAS"))
            if parameterNode.parameterNode.GetScene() is not None:
                parameterNode.status = "\n".join(_sentences(found, new))
            return new

        return inNewFolder(folder, "segment", stepsInto)


def _ends(parameterNode, run):
    """The two places between which the segment lies, in world coordinates: those of the chosen markups, or the ends of
    a stent's surroundings."""
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
    """The entry of an input in the segment's document: its file, if it is unchanged since it was read, else its name in
    the scene."""
    file = Plans.fileOf(node)
    return {"file": node.GetName() if file is None else file, "sha256": None}


def _sentences(found, folder):
    """The sentences about a segment that the panel shows."""
    yield _("Wrote {folder}, in cm; segment.json tells what is in it.").format(folder=folder)
    if found.after is None:
        yield _(
            "Before treatment only: deploy the plan as it is now to have the vessel after it, too."
        )
    yield from (caution.sentence() for caution in found.warnings)
