"""The examples run, and give the number that they say."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

from SDFStentLib.cli import main

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.fixture(scope="module")
def a_demo_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("examples") / "demo"
    assert main(["demo", "-o", str(folder), "--quiet"]) == 0
    return folder


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_its_number_holds(path, a_demo_folder, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [str(path), str(a_demo_folder)])
    runpy.run_path(str(path), run_name="__main__")  # the example itself asserts its number
    assert "mm" in capsys.readouterr().out


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_asserts(path):
    text = path.read_text(encoding="utf-8")
    assert 10 <= len(text.splitlines()) <= 32
    assert "assert " in text.split("__main__")[1]
