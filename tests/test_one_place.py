"""What is said once is in one place: a parameter of a stent, a treated stent in words, and the ways
that a value takes, as the developer guide walks them."""

import ast
import os
import re
import shutil

import pytest
from child_processes import PROJECT, python
from tube_files import PLACE, write_tube

PACKAGES = ("SDFStentLib", "SDFStent", "SDFStentApp")
SHIPPED = [
    path
    for package in PACKAGES
    for path in sorted((PROJECT / package).rglob("*.py"))
    if "Testing" not in path.parts
]


# A new parameter of a stent: a field in one file, of which all doors know.

FIELD = """\
    strut_thickness: float | None = parameter(
        "thickness of its struts", unit="mm", above=0.0, most=5.0, default=None,
        option="strut-thickness",
    )
    name: str = ""
    enabled: bool = True
"""
PROGRAM = """
import json, sys
from SDFStentLib.cli import main
from SDFStentLib.plan import load_plan, plan_schema

deploy = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", "--diameter", "6"]
deploy += [*sys.argv[1:], "-o", "out.vtp", "--quiet"]
assert main([*deploy, "--strut-thickness", "9"]) == 2
assert main([*deploy, "--strut-thickness", "0.2", "--save-plan", "plan.json"]) == 0
assert load_plan("plan.json").stents[0].strut_thickness == 0.2
assert main(["run", "plan.json", "-o", "again", "--quiet"]) == 0
assert load_plan("again/plan.json").stents[0].strut_thickness == 0.2
assert "Thickness of its struts (mm)." in json.dumps(plan_schema())
sweep = {"schema": "sdfstent-sweep", "version": 1, "plan": "plan.json"}
sweep["axes"] = {"strut_thickness": [0.1, 0.3]}
with open("sweep.json", "w", encoding="utf-8") as file:
    json.dump(sweep, file)
assert main(["sweep", "sweep.json", "--dry-run"]) == 0
"""


@pytest.fixture
def a_library(tmp_path):
    """A copy of the library whose stents have one more parameter: one file is another."""
    made = tmp_path / "library" / "SDFStentLib"
    shutil.copytree(PROJECT / "SDFStentLib", made, ignore=shutil.ignore_patterns("__pycache__"))
    path = made / "stent" / "stent.py"
    parts = path.read_text(encoding="utf-8").split('    name: str = ""\n    enabled: bool = True\n')
    assert len(parts) == 2
    path.write_text(FIELD.join(parts), encoding="utf-8")
    return made.parent


def test_a_parameter_of_a_stent_is_one_field_for_shell_plan_schema_and_sweep(a_library, tmp_path):
    write_tube(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(a_library)}
    done = python(PROGRAM, *PLACE, folder=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    assert "strut_thickness: expected a number greater than 0" in done.stderr
    assert '{"strut_thickness": 0.3}' in done.stdout


# A treated stent is put into words by the report alone, and a stent has two forms.


def words_of_imports(path) -> set[str]:
    """The names, and the parts of the names of modules, that a file imports."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= set((getattr(node, "module", "") or "").split("."))
            found |= {word for alias in node.names for word in alias.name.split(".")}
    return found


def test_only_the_report_knows_what_a_treated_stent_has():
    knows = {
        path.relative_to(PROJECT).parts[:2]
        for path in SHIPPED
        if "TreatedStent" in words_of_imports(path)
    }
    assert knows == {("SDFStentLib", "treatment"), ("SDFStentLib", "report")}
    lists = [path for path in SHIPPED if "def stent_facts(" in path.read_text(encoding="utf-8")]
    assert [path.name for path in lists] == ["stents.py"]


def test_a_stent_is_a_value_or_an_entry_that_is_edited():
    """`Stent`, which refuses what does not fit together, and `Draft` of an entry of a document."""
    makes = {
        path.relative_to(PROJECT).as_posix()
        for path in SHIPPED
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
        if {"diameter", "length", "keeps"}
        <= {one.target.id for one in node.body if isinstance(one, ast.AnnAssign)}
    }
    assert makes == {"SDFStentLib/stent/stent.py"}
    reads = [
        path.name for path in SHIPPED if "typed_values(Stent" in path.read_text(encoding="utf-8")
    ]
    assert reads == ["entry.py"]


# The walks of the developer guide.

GUIDE = (PROJECT / "docs" / "developer_guide.md").read_text(encoding="utf-8")
WALKS = re.findall(
    r"^\*\*(From .*?):\*\*(.*?)\n\n", GUIDE.split("### Three walks")[1], re.MULTILINE | re.DOTALL
)


@pytest.mark.parametrize(("title", "text"), WALKS, ids=[title for title, _ in WALKS])
def test_a_walk_has_at_most_ten_files_and_each_uses_another_one_of_it(title, text):
    names = re.findall(r"`([\w/]+\.(?:py|ui))`", text)
    known = [*SHIPPED, PROJECT / "SDFStent" / "Resources" / "UI" / "SDFStent.ui"]
    found = [[path for path in known if path.as_posix().endswith("/" + name)] for name in names]
    assert all(len(paths) == 1 for paths in found), title
    walk = [path for (path,) in found]
    assert len(WALKS) == 3
    assert 5 < len(walk) <= 10
    assert all(is_linked(path, walk) for path in walk if path.suffix == ".py")


def is_linked(path, walk) -> bool:
    """Whether a file imports from another one of a walk, or from its room, or the other does."""
    return any(is_named(path, other) or is_named(other, path) for other in walk if other != path)


def is_named(path, other) -> bool:
    return other.suffix == ".py" and bool({path.stem, path.parent.name} & words_of_imports(other))
