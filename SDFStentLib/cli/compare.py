"""The command `compare`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

from ..files import check_suffix
from ..plan import Alternative, Plan, PlanComparison, compare, load_plan
from ..report import (
    alternatives_picture,
    check_rendering,
    comparison_document,
    comparison_page,
    comparison_pictures,
    document_json,
    output_list,
)
from ..validation import InputError
from .console import Console, tell
from .outputs import Outputs

NOT_CERTIFIED = 3
PAGES = (".html", ".htm")


def compare_command(options: argparse.Namespace, console: Console) -> int:
    """Carry out several plans and show them side by side; return 0, or 3 if one is
    not certified."""
    start = perf_counter()
    accept = options.accept_changed_inputs
    plans = {
        name: load_plan(path, accept_changed_inputs=accept)
        for name, path in _named(options.plans).items()
    }
    results = _Results(options.hide_device)
    outputs = _outputs(options, plans, results)
    with console.progress("Deploying") as show:
        results.comparison = compare(plans, accept_changed_inputs=accept, progress=show)
    results.document = comparison_document(results.comparison)
    results.pictures = comparison_pictures(results.comparison, hides_device=options.hide_device)
    outputs.write()
    if options.json:
        print(document_json(results.document), end="")
    else:
        _tell(results, console)
        console.say(f"Wrote {', '.join(outputs.names())} in {perf_counter() - start:.1f} s.")
    is_certified = all(one.is_certified for one in results.comparison.alternatives)
    return 0 if is_certified else NOT_CERTIFIED


class _Results:
    """The results to write, filled in when they are there."""

    def __init__(self, hides_device: bool) -> None:
        self.hides_device = hides_device
        self.comparison = PlanComparison(())
        self.document: dict[str, Any] = {}
        self.pictures: list[bytes] | str = ""

    def write_page(self, path: Path) -> None:
        page = comparison_page(self.document, self.pictures)
        path.write_text(page, encoding="utf-8", errors="backslashreplace")

    def write_picture(self, path: Path) -> None:
        picture = alternatives_picture(self.comparison.results, hides_device=self.hides_device)
        path.write_bytes(picture)

    def write_json(self, path: Path, files: Mapping[str, str]) -> None:
        self.document["outputs"] = output_list(files)
        text = document_json(self.document)
        path.write_text(text, encoding="utf-8", errors="backslashreplace")


def _named(paths: list[str]) -> dict[str, str]:
    """The paths of the plans by the names of their files."""
    if len(paths) < 2:
        raise InputError(f"expected two or more plans to compare, got {len(paths)}; name another.")
    found: dict[str, str] = {}
    for path in paths:
        name = Path(path).stem
        if name in found:
            raise InputError(
                f"{path}: expected plans of different names, {found[name]} is called {name}, too; "
                "rename one of the files."
            )
        found[name] = path
    return found


def _outputs(options: argparse.Namespace, plans: dict[str, Plan], results: _Results) -> Outputs:
    """The outputs: a page, or a folder with page and document."""
    inputs = [
        *options.plans,
        *(
            file.path
            for plan in plans.values()
            for file in (plan.surface, plan.centerline, *(s.axis_file for s in plan.stents))
            if file is not None
        ),
    ]
    place = Path(options.output)
    is_page = place.suffix.lower() in PAGES
    outputs = Outputs(inputs, None if is_page else place)
    outputs.add(place if is_page else place / "comparison.html", results.write_page)
    if not is_page:
        path = place / "comparison.json"
        outputs.add(path, lambda made: results.write_json(made, outputs.beside(path)), is_last=True)
    if options.picture:
        check_suffix(options.picture, "a picture", (".png",))
        outputs.add(options.picture, results.write_picture)
        check_rendering()
    return outputs


def _tell(results: _Results, console: Console) -> None:
    """Report the outcome of every plan in short; the page has the rest."""
    for one in results.comparison.alternatives:
        _tell_alternative(one, console)
    if isinstance(results.pictures, str):
        console.complain(results.pictures)


def _tell_alternative(one: Alternative, console: Console) -> None:
    if one.result is None:
        console.complain(f"{one.name} could not be carried out: {one.failure}")
        return
    cautions = (*one.result.warnings, *one.result.size_warnings)
    tell(one.result, cautions, console, f"{one.name}: ")
