"""The page of `sdfstent compare` for the plans of one vessel, in a folder from which the command can make the page
again."""

import re
from pathlib import Path

from slicer.i18n import tr as _

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_lines,
    set_frame_of_polydata,
)
from SDFStentLib.plan import compare, comparison_inputs, save_plan
from SDFStentLib.report import (
    comparison_document,
    comparison_page,
    comparison_pictures,
    document_json,
)
from SDFStentLib.validation import InputError

from . import Conversion, Plans
from .Exporting import freePath
from .Portions import inPortions, working

PAGE, DOCUMENT = "comparison.html", "comparison.json"


class NotWanted(Exception):
    """Raised when nobody waits for the comparison any more."""


def steps(plans, folder):
    """Carry out plans, a mapping of names to parameter sets, and write their comparison into an existing folder.

    An iterator over the fraction that is done, which returns the path of the page. The folder also gets the plans, and
    the vessel and centerline where they are in no file. Raises `InputError` or `DeploymentError` with a sentence.
    """
    files = _Files(folder)
    named = {_safe(name): files.complete(name, plan) for name, plan in plans.items()}
    _checkNames(named, plans)
    yield 0.0
    inputs, done = comparison_inputs(named), [0.0]  # files are read on this thread, as VTK wants it

    def progress(fraction, _name):
        if done is None:
            raise NotWanted
        done[0] = 0.8 * fraction

    def carriedOut():
        comparison = compare(named, inputs=inputs, progress=progress)
        # The pictures are painted by a process of their own, which is only waited for.
        return comparison, comparison_document(comparison), comparison_pictures(comparison)

    try:
        comparison, document, pictures = yield from working(inPortions(carriedOut), lambda: done[0])
    finally:
        done = None
    for one in comparison.alternatives:
        save_plan(one.plan, folder / f"{one.name}.json")
    texts = {DOCUMENT: document_json(document), PAGE: comparison_page(document, pictures)}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", errors="backslashreplace")
    return folder / PAGE


def _checkNames(named, plans):
    """Check that every plan gets a file of its own, other than that of the document, even where case does not
    distinguish names."""
    taken = {DOCUMENT, *(f"{name.casefold()}.json" for name in named)}
    if len(taken) <= len(plans):
        raise InputError(
            _(
                "Compare: expected plans of different names, and none called {document}, got {names}; rename one."
            ).format(document=Path(DOCUMENT).stem, names=", ".join(plans))
        )


class _Files:
    """The inputs of plans as files: the files of their nodes, or new ones in a folder."""

    def __init__(self, folder):
        self._folder, self._written = folder, {}

    def complete(self, name, parameterNode):
        """The library's plan of a parameter set, with its surface and centerline as files."""
        try:
            plan, line = Plans.planOf(parameterNode), parameterNode.centerline
        except InputError as error:
            raise error.labeled(f"{name}: ") from error
        surface = centerline = None
        if plan.surface is None:
            segment = Conversion.segmentOf(parameterNode)
            vessel = parameterNode.vessel
            surface = self._file(
                vessel, "vessel", lambda: Conversion.vesselPolyData(vessel, segment)
            )
        if plan.centerline is None and line is not None:
            centerline = self._file(line, "centerline", lambda: _linesPolyData(line))
        return plan.of_files(surface, centerline)

    def _file(self, node, role, polyDataOf):
        """The path of a new file of a node in RAS; several plans share it."""
        if node.GetID() not in self._written:
            polyData = polyDataOf()
            set_frame_of_polydata(polyData, "RAS")
            path = freePath(self._folder / f"{_safe(node.GetName())} ({role}).vtp")
            path.write_bytes(encode_vtp(polyData))
            self._written[node.GetID()] = str(path)
        return self._written[node.GetID()]


def _linesPolyData(node):
    """A centerline of the scene in world coordinates."""
    points, lines, radius = Conversion.centerlineLines(node)
    polyData = polydata_from_lines(points, lines)
    if radius is not None:
        add_arrays(polyData, {"Radius": radius}, None)
    return polyData


def _safe(name):
    """The name with only those characters that file names can have everywhere."""
    return re.sub(r"[^\w .()+,-]", "_", name).strip(" .")[:80] or "_"
