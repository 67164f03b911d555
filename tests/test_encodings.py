"""Text files are UTF-8 everywhere, whatever the machine takes for its own encoding."""

from __future__ import annotations

import ast
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
FOLDERS = ("SDFStentLib", "SDFStent", "tests", "examples", "benchmarks", "docs")
ARGUMENTS = {"read_text": 1, "write_text": 2, "open": 4}
"""With so many arguments the last one is the encoding."""


def without_encoding(call):
    """Whether a call opens a text file in the encoding of the machine."""
    name = getattr(call.func, "id", getattr(call.func, "attr", None))
    if name not in ARGUMENTS or (name == "open" and not isinstance(call.func, ast.Name)):
        return False
    modes = [word.value for word in call.args if isinstance(word, ast.Constant)]
    is_binary = name == "open" and any("b" in str(mode) for mode in modes[-1:])
    keywords = {keyword.arg for keyword in call.keywords}
    return not (is_binary or len(call.args) >= ARGUMENTS[name] or "encoding" in keywords)


def test_every_text_file_is_opened_with_its_encoding():
    assert not [
        f"{path.relative_to(PROJECT)}:{node.lineno}"
        for folder in FOLDERS
        for path in (PROJECT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and without_encoding(node)
    ]
