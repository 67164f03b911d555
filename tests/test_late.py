"""Modules that are executed when they are first used."""

from __future__ import annotations

import importlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from SDFStentLib.__main__ import PARTLY
from SDFStentLib.late import PartlyLate, postpone

PACKAGE = """
import time
from .. import names
names.append("all")
from .slow import value
time.sleep(0.05)
later = 2
def __getattr__(name):
    if name == "old":
        return 3
    raise AttributeError(name)
"""


@pytest.fixture
def executed(tmp_path, monkeypatch):
    """The modules of a package that were executed, in order; the package asks for all of them."""
    folder = tmp_path / "a_package_of_the_test"
    folder.mkdir()
    (folder / "__init__.py").write_text("names = []", encoding="utf-8")
    for name in ("slow", "other"):
        text = f"from a_package_of_the_test import names; names.append({name!r}); value = 1"
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    inner = folder / "inner"
    inner.mkdir()
    (inner / "__init__.py").write_text(PACKAGE, encoding="utf-8")
    text = "from a_package_of_the_test import names; names.append('inner slow'); value = 1"
    (inner / "slow.py").write_text(text, encoding="utf-8")
    (inner / "beside.py").write_text("", encoding="utf-8")
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


@pytest.fixture
def partly(executed, monkeypatch):
    """The package within it, of which `value` is taken alone, `gone` is said to be, and is not."""
    modules = {"value": "slow", "gone": "nowhere", "later": "slow"}
    finder = PartlyLate({"a_package_of_the_test.inner": modules})
    monkeypatch.setattr(sys, "meta_path", [finder, *sys.meta_path])
    return importlib.import_module("a_package_of_the_test.inner")


def test_a_name_of_a_package_is_taken_without_the_rest_of_it(executed, partly):
    assert partly.value == 1
    assert executed == ["inner slow"]
    from a_package_of_the_test.inner import beside, value

    assert value == 1
    assert beside.__name__ == "a_package_of_the_test.inner.beside"
    assert executed == ["inner slow", "all"]


def test_any_other_name_executes_the_package_once_in_whatever_thread(executed, partly):
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(lambda _: partly.names, range(8))) == [executed] * 8
    assert executed == ["all", "inner slow"]
    assert partly.value == 1


def test_a_name_that_lies_elsewhere_by_now_is_found_in_the_package(executed, partly):
    assert partly.later == 2  # not in its module
    assert partly.old == 3  # by the package's own way to names
    for missing in ("gone", "never_there"):
        with pytest.raises(AttributeError, match=missing):
            getattr(partly, missing)
    assert executed.count("all") == 1


def test_scipy_gives_what_is_asked_for_partly_and_otherwise_the_same_as_whole():
    names = ", ".join(sorted(PARTLY["scipy.sparse.csgraph"]))
    script = f"""
import sys
from SDFStentLib.__main__ import PARTLY
from SDFStentLib.late import PartlyLate
sys.meta_path.insert(0, PartlyLate(PARTLY))
from scipy.spatial import cKDTree, KDTree
from scipy.sparse.csgraph import {names}
assert "scipy.special" not in sys.modules and "scipy.sparse.linalg" not in sys.modules
from scipy.spatial import Delaunay
from scipy.sparse import csgraph
import scipy.spatial
assert scipy.spatial.cKDTree is cKDTree and scipy.spatial.Delaunay is Delaunay
assert csgraph.laplacian and csgraph.dijkstra is dijkstra
"""
    subprocess.run([sys.executable, "-c", script], check=True)
