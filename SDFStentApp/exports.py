"""The files that a page gives to its user: the plan with its files, the stented surface, the
report. They are made from the plan, as the commands make them."""

from __future__ import annotations

import io
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

from SDFStentLib.files import read_with_pieces
from SDFStentLib.plan import Plan, PlanResult, load_plan, plan_text, run_plan
from SDFStentLib.report import before_after_picture, plan_report, write_report
from SDFStentLib.stent import InputFile
from SDFStentLib.validation import DeploymentError, InputError

NAMES = {
    "plan": ("plan.zip", "application/zip"),
    "surface": ("stented.vtp", "application/xml"),
    "report": ("report.html", "text/html"),
}
"""Name and media type of each file that can be asked for."""


def exported(kind: str, plan: Path) -> bytes:
    """The content of a file of `NAMES`, made from a plan document whose files exist."""
    return {"plan": _zipped, "surface": _surface, "report": _report}[kind](load_plan(plan))


def _zipped(plan: Plan) -> bytes:
    """The plan together with its files, which `sdfstent run` can carry out anywhere."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        moved = {}
        for role in ("surface", "centerline"):
            file: InputFile | None = getattr(plan, role)
            if file is not None:
                name = f"{role}{Path(file.path).suffix}"
                archive.write(file.path, name)
                for piece in read_with_pieces(file.path).pieces:
                    archive.write(piece.path, piece.path.relative_to(Path(file.path).parent))
                moved[role] = replace(file, path=f"/{name}")
        archive.writestr("plan.json", plan_text(replace(plan, **moved), "/"))
    return content.getvalue()


def zipped_folder(folder: Path) -> bytes | None:
    """The files of a folder as a zip file; None if there are none."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files:
            archive.write(path, path.relative_to(folder).as_posix())
    return content.getvalue() if files else None


def _surface(plan: Plan) -> bytes:
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        path = Path(folder) / NAMES["surface"][0]
        _carried_out(plan).write_surface(path)
        return path.read_bytes()


def _report(plan: Plan) -> bytes:
    result = _carried_out(plan)
    try:
        picture: bytes | str = before_after_picture(result)
    except DeploymentError as error:
        picture = str(error)
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        path = Path(folder) / NAMES["report"][0]
        write_report(plan_report(result, picture=picture), path)
        return path.read_bytes()


def _carried_out(plan: Plan) -> PlanResult:
    if plan.surface is None:
        raise InputError(
            "Saving: expected a vessel that is in a file, got none; open one from a file."
        )
    return run_plan(plan)
