"""Warnings are values; their sentences are made once, at the end, and read by nobody but people."""

import ast
import re
import string

import numpy as np
import pytest
from child_processes import PROJECT

from SDFStentLib.cautions import NO_REMEDIES, TEMPLATES, Caution
from SDFStentLib.validation import InputError

SOURCES = [
    path
    for folder in ("SDFStentLib", "SDFStent/SDFStentSlicer")
    for path in sorted((PROJECT / folder).rglob("*.py"))
]
BEND = {"bend_radius_mm": 2.04, "stent_radius_mm": 3}


def made_kinds() -> set[str]:
    """Every constant that the code gives a caution, or compares its kind with."""
    texts = set()
    for path in SOURCES:
        if path.name != "cautions.py":
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            texts |= {node.value for node in nodes if isinstance(node, ast.Constant)}
    return texts & set(TEMPLATES)


def fields_of(kind: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(TEMPLATES[kind]) if name}


def test_a_caution_is_a_kind_numbers_and_a_place_and_says_them_in_a_sentence():
    caution = Caution("facets-inside", {"depth_mm": 0.123}, (1.0, -2.04, 3.0))
    assert str(caution) == (
        "Facets lie inside the prescribed lumen near (1.0, -2.0, 3.0) mm, by up to 0.12 mm: "
        "pushed out they would fold; smaller triangles there may help."
    )


def test_a_label_stands_in_front_and_changes_nothing_else():
    gap = Caution("switched-off", stent=2).labeled("After: ").labeled("Stent 2 (left): ")
    assert str(gap) == "Stent 2 (left): After: it is switched off and was not deployed."
    assert (gap.kind, gap.stent) == ("switched-off", 2)


def test_a_part_that_is_measured_is_no_stent():
    caution = Caution("shortened", {"prescribed_mm": 20.0, "available_mm": 12.0})
    assert caution.sentence().startswith("The stent is shortened: 20.0 mm")
    assert caution.sentence("part").startswith("The part is shortened: 20.0 mm")
    chosen = Caution("branch-chosen", {"rule": "widest"}, (0.0, 0, 0), label="the stent's file: ")
    assert chosen.sentence("part").startswith("the stent's file: At")
    assert "the part follows the widest branch" in chosen.sentence("part")


def test_a_reader_who_has_an_option_is_told_it_and_others_are_not():
    caution = Caution("tight-bend", BEND, (1.0, 2.0, 3.0))
    assert caution.sentence().endswith("or straighten the axis.")
    told = caution.sentence(remedies={"straighten": " (--straighten F)", "to": " (--to)"})
    assert told.endswith("or straighten the axis (--straighten F).")


def test_a_text_of_the_user_is_no_template():
    caution = Caution("picture-missing", {"reason": "{to} {0}"}, label="{x}.stl: ")
    assert str(caution) == "{x}.stl: {to} {0}"


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [("unheard-of", {}), ("tight-bend", {}), ("facets-inside", {"depth_mm": 1})],
)
def test_a_kind_number_or_place_that_is_missing_is_found_at_once(kind, numbers):
    with pytest.raises((KeyError, TypeError)):
        Caution(kind, numbers)


def test_every_kind_is_made_somewhere_and_says_one_sentence():
    assert made_kinds() == set(TEMPLATES)
    for kind, template in TEMPLATES.items():
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", kind)
        assert template.endswith((".", "{reason}"))


def test_the_numbers_of_a_kind_have_names_that_nothing_else_has():
    taken = {*NO_REMEDIES, "thing", "x", "y", "z"}
    for kind in TEMPLATES:
        numbers = {name: 0 for name in fields_of(kind) - taken}
        place = (0.0, 0.0, 0.0) if "x" in fields_of(kind) else None
        assert Caution(kind, numbers, place).sentence()


def test_an_error_names_the_remedy_of_who_reads_it_also_behind_labels():
    error = InputError("stent: too wide; check the unit of the files", "units", end=".")
    assert str(error) == "stent: too wide; check the unit of the files."
    labeled = error.labeled("Stent 2: ").labeled("plan.json: ")
    assert str(labeled) == f"plan.json: Stent 2: {error}"
    told = labeled.sentence({"units": " (--units mm)", "to": " (--to)"})
    assert told == "plan.json: Stent 2: stent: too wide; check the unit of the files (--units mm)."
    python = InputError("accept it ", "accept", otherwise="(accept=True)", end=".")
    assert str(python) == "accept it (accept=True)."
    assert python.sentence({"accept": "(--accept)"}) == "accept it (--accept)."


def test_no_code_looks_for_words_in_a_sentence():
    """A sentence, a caution or an error turned into text is neither searched, cut nor changed."""
    readers = {"replace", "startswith", "endswith", "split", "partition", "find", "index", "count"}
    about = re.compile(r"sentence|caution|warning|gap\b|str\(error\)")
    found = []
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            read = None
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                read = node.func.value if node.func.attr in readers else None
            elif isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
                is_text = isinstance(node.left, ast.Constant)
                read = node.comparators[0] if is_text else None
            if read is None or not about.search(ast.unparse(read)):
                continue
            # A writer knows only the name that its file has while it is written.
            if "str(staged)" not in ast.unparse(node):
                found.append(f"{path.relative_to(PROJECT)}:{node.lineno}: {ast.unparse(node)}")
    assert not found


def test_places_of_arrays_are_plain_numbers():
    place = tuple(np.array([1.5, 2, 3]).tolist())
    assert Caution("cap-bulged", {"height_mm": 1.0}, place).place == (1.5, 2.0, 3.0)
