"""A file imports only from rows below its own, and the library stays free of the application."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

LIBRARY = Path(__file__).parents[1] / "SDFStentLib"
FILES = sorted(path.stem for path in LIBRARY.glob("*.py"))
VTK_GATE = {  # the only files that may import vtk themselves
    "polydata", "centerline_files", "centerline_output", "surface_files", "surface_output",
    "vtk_formats", "triangulation", "normal_arrays", "same_space", "picture_scene",
    "legacy_blocks",
}  # fmt: skip
LOW = ("validation", "version", "blending", "polyline", "surface", "topology")
HIGH = ("cli", "report", "picture", "plan", "treatment", "deployment", "stent", "polydata")


def tree_of(name):
    return ast.parse((LIBRARY / f"{name}.py").read_text(encoding="utf-8"))


@cache
def imports_of(name):
    """Library files that a file imports, at its top or late."""
    found = set()
    for node in ast.walk(tree_of(name)):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("SDFStentLib"):
            found.add(node.module.partition(".")[2] or "__init__")
    return found


def outside_of(name):
    found = set()
    for node in ast.walk(tree_of(name)):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.split(".")[0])
    return found


def test_every_file_stands_on_lower_rows_only():
    waiting = {name: imports_of(name) - {"__init__"} for name in FILES}
    while waiting:
        row = {name for name, below in waiting.items() if not below & set(waiting)}
        assert row, f"these import each other in a circle: {sorted(waiting)}"
        waiting = {name: below for name, below in waiting.items() if name not in row}


def test_the_command_line_is_on_top_and_nothing_below_knows_it():
    for name in FILES:
        if not name.startswith("cli") and name not in ("__main__", "__init__"):
            assert not {other for other in imports_of(name) if other.startswith("cli")}, name


def test_reports_and_pictures_stand_above_plans_and_plans_above_deployment():
    upper = {
        0: ("report", "picture", "treatment_report"),
        1: ("plan", "treatment"),
        2: (
            "deployment", "attempt", "deployment_value", "event_steps", "published_steps",
            "untangle", "lumen",
        ),
    }  # fmt: skip

    def level(name):
        if name == "treatment_report" or name.startswith(("report", "picture")):
            return 0
        if name.startswith(tuple(upper[1])):
            return 1
        return 2 if name in upper[2] else 3

    for name in FILES:
        if name.startswith("cli") or name in ("__main__", "__init__"):
            continue
        for other in imports_of(name):
            assert level(other) >= level(name), f"{name} imports {other}, which stands above it"


def test_low_files_import_nothing_high():
    for name in LOW:
        for other in imports_of(name):
            assert not other.startswith(HIGH), f"{name} imports {other}"


@pytest.mark.parametrize("name", FILES)
def test_only_the_gate_imports_vtk_and_nothing_imports_the_application(name):
    outside = outside_of(name)
    assert not outside & {"slicer", "qt", "ctk", "pymeshlab", "tetgen", "svmorph", "jsonschema"}
    if outside & {"vtk", "vtkmodules"}:
        assert name in VTK_GATE


def test_importing_the_library_imports_neither_vtk_nor_scipy_spatial():
    program = (
        "import sys; [sys.modules.__setitem__(name, None) for name in ('slicer', 'qt', 'ctk')];"
        "import SDFStentLib; "
        "print([m for m in sys.modules if m.startswith(('vtk', 'scipy.spatial', 'matplotlib'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=LIBRARY.parent,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "[]"


def test_every_name_of_the_table_of_contents_exists():
    import SDFStentLib

    assert len(set(SDFStentLib.__all__)) == len(SDFStentLib.__all__)
    for name in SDFStentLib.__all__:
        assert getattr(SDFStentLib, name) is not None
    assert set(SDFStentLib.__all__) <= set(dir(SDFStentLib))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        SDFStentLib.nothing  # noqa: B018


def test_the_version_is_that_of_the_project():
    import re

    import SDFStentLib

    text = (LIBRARY.parent / "pyproject.toml").read_text(encoding="utf-8")
    assert re.search(r'^version = "(.+)"', text, re.M).group(1) == SDFStentLib.__version__


def test_no_shipped_file_grows_beyond_its_limit():
    for name in FILES:
        lines = (LIBRARY / f"{name}.py").read_text(encoding="utf-8").splitlines()
        assert len(lines) <= 350, name
