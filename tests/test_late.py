"""Modules that are executed when they are first used."""

from __future__ import annotations

import importlib
import sys

import pytest

from SDFStentLib.late import postpone


@pytest.fixture
def executed(tmp_path, monkeypatch):
    """The modules of a package that were executed, in order; the package asks for all of them."""
    folder = tmp_path / "a_package_of_the_test"
    folder.mkdir()
    (folder / "__init__.py").write_text("names = []", encoding="utf-8")
    for name in ("slow", "other"):
        text = f"from a_package_of_the_test import names; names.append({name!r}); value = 1"
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    names = importlib.import_module(folder.name).names
    yield names
    for name in [name for name in sys.modules if name.startswith(folder.name)]:
        del sys.modules[name]


def test_a_postponed_module_is_executed_when_something_in_it_is_asked_for(executed):
    postpone("a_package_of_the_test.slow")
    from a_package_of_the_test import other, slow

    assert executed == ["other"]
    assert other.value == slow.value == 1
    assert executed == ["other", "slow"]


def test_a_module_that_is_imported_or_missing_stays_as_it_is(executed):
    other = importlib.import_module("a_package_of_the_test.other")
    postpone("a_package_of_the_test.other")
    assert sys.modules["a_package_of_the_test.other"] is other
    postpone("a_package_of_the_test.nowhere")
    assert "a_package_of_the_test.nowhere" not in sys.modules
