"""The process that makes a vessel of a segmentation for a page: `python -m SDFStentApp.preparing`.

It has a label's number among those of the file, -1 for the only one, and the folder to write into.
Every line that it prints is a JSON object: the `share` that is done, or in the end the `labels` to
choose from, what there is to say of the vessel (`said`), or an `error`.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from pathlib import Path
from typing import Any

from SDFStentLib.files import write_extracted_lines, write_new_surface
from SDFStentLib.report import prepared_sentences
from SDFStentLib.scan import prepared_vessel, read_scan
from SDFStentLib.validation import DeploymentError, InputError

SURFACE, CENTERLINE = "surface.vtp", "centerline.vtp"
"""Files that are written."""


def prepare(path: str, number: int, folder: Path) -> dict[str, Any]:
    """Write surface and centerline of a label; what to print in the end."""
    scan = read_scan(path)
    labels = scan.labels
    if not 0 <= number < len(labels):
        if len(labels) > 1:
            return {"labels": [label.words for label in labels]}
        number = 0
    segment = scan.segmentation(labels[number])
    made = prepared_vessel(segment.labelmap, show=_show)
    write_new_surface(folder / SURFACE, made.surface, made.faces, "LPS", made.voxels)
    write_extracted_lines(folder / CENTERLINE, made.lines, "mm", "LPS")
    return {"said": [*(one.sentence() for one in made.warnings), *prepared_sentences(made)]}


def _show(share: float) -> None:
    _print({"share": share})


def _print(answer: dict[str, Any]) -> None:
    print(json.dumps(answer), flush=True)


def main() -> None:
    """Do what the arguments say, and end when stdin does: the page is gone then."""
    threading.Thread(target=_end_with_stdin, daemon=True).start()
    path, number, folder = sys.argv[1:]
    try:
        _print(prepare(path, int(number), Path(folder)))
    except (InputError, DeploymentError) as error:
        _print({"error": str(error)})


def _end_with_stdin() -> None:
    sys.stdin.read()
    os._exit(0)


if __name__ == "__main__":
    main()
