"""Warnings are values; their sentences are made once, at the end, and read by nobody but people."""

import ast
import re

import numpy as np
from child_processes import PROJECT

from SDFStentLib.cautions import TEMPLATES, Caution

SOURCES = [
    path
    for folder in ("SDFStentLib", "SDFStent/SDFStentSlicer")
    for path in sorted((PROJECT / folder).rglob("*.py"))
]


def made_kinds() -> set[str]:
    """Every constant that the code gives a caution, or compares its kind with."""
    texts = set()
    for path in SOURCES:
        if path.name != "cautions.py":
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            texts |= {node.value for node in nodes if isinstance(node, ast.Constant)}
    return texts & set(TEMPLATES)


def test_every_kind_is_made_somewhere_and_says_one_sentence():
    assert made_kinds() == set(TEMPLATES)
    for kind, template in TEMPLATES.items():
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", kind)
        assert template.endswith((".", "{reason}"))


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
