"""The page has logic, words and ranges of the module from there: nothing is written twice."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from child_processes import PROJECT

APP = sorted((PROJECT / "SDFStentApp").glob("*.py"))
SHARED = sorted(
    [
        *(PROJECT / "SDFStent" / "SDFStentSlicer").glob("*.py"),
        *(PROJECT / "SDFStentLib").rglob("*.py"),
    ]
)
UI = PROJECT / "SDFStent" / "Resources" / "UI" / "SDFStent.ui"
SAME_LINES = 5
"""So many lines in a row are written twice when they are the same."""


def blocks(path: Path) -> set[tuple[str, ...]]:
    """All runs of so many statements' lines, without imports, blank lines and indentation."""
    lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
    code = [
        line for line in lines if len(line) > 3 and not line.startswith(("import", "from", "#"))
    ]
    return {tuple(code[i : i + SAME_LINES]) for i in range(len(code) - SAME_LINES + 1)}


def test_no_piece_of_the_logic_or_the_library_is_in_the_page_once_more():
    known = {block: path.name for path in SHARED for block in blocks(path)}
    twice = [(path.name, known[block]) for path in APP for block in blocks(path) if block in known]
    assert twice == []


def test_the_page_takes_from_the_library_what_reads_plans_and_writes_results_only():
    used = {
        (node.module, alias.name)
        for path in APP
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("SDFStentLib")
        for alias in node.names
    }
    assert {module.partition(".")[2] for module, _ in used} == {
        "files", "plan", "report", "stent", "units", "validation"
    }  # fmt: skip
    # A plan that is kept is written whole or not at all, as every file; a file that is dropped on
    # the page is a centerline where it has lines.
    of_files = {name for module, name in used if module == "SDFStentLib.files"}
    assert of_files == {"read_lines", "write_bytes"}
    assert not {name for _, name in used} & {"Treatment", "Preview", "Deployment", "find_lesions"}


def test_no_word_of_the_panel_and_no_range_is_in_the_page_once_more():
    ui = UI.read_text(encoding="utf-8")
    texts = re.findall(r'<property name="(?:text|toolTip)">\s*<string>([^<]{12,})</string>', ui)
    assert len(texts) > 40
    sources = "\n".join(path.read_text(encoding="utf-8") for path in APP)
    assert [text for text in texts if text in sources] == []
    known = set(re.findall(r'name="(\w+)">', ui)) - {"text"}
    ranges = re.findall(r"\.(\w+Slider|\w+SpinBox)\.(?:minimum|maximum|value) = ", sources)
    assert [name for name in ranges if name in known] == []


def test_neither_page_nor_panel_imports_all_of_vtk():
    panel = (PROJECT / "SDFStent" / "SDFStentSlicer").glob("*.py")
    lines = [
        (path.name, line)
        for path in [*APP, *panel]
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.match(r"\s*(import|from) vtk\b", line)
    ]
    assert lines == []
