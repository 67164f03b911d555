"""A small part of every benchmark that needs nothing but what the tests need."""

import importlib
import json
import sys

import pytest
from child_processes import PROJECT


@pytest.fixture(scope="module", autouse=True)
def _benchmarks_can_be_imported():
    sys.path.insert(0, str(PROJECT))
    yield
    sys.path.remove(str(PROJECT))


ERRORS = ("place", "minimum", "percent", "reference", "extent")


def benchmark(name):
    return importlib.import_module(f"benchmarks.{name}")


def quick(name):
    module = benchmark(name)
    found = module.measured(True, None)
    json.dumps(found)
    assert_is_table(module.table(found))
    return found


def assert_is_table(text):
    """Markdown in which every row has as many cells as the header."""
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert len(rows) > 2
    assert len({line.count("|") for line in rows}) == 1


# What is measured --------------------------------------------------------------------------------


@pytest.mark.bench
def test_in_a_tree_without_narrowings_none_is_invented():
    """Trees with some are judged in `test_tree_bench.py` and `test_phantoms.py`."""
    bench = benchmark("trees.bench")
    found = bench.summary([bench.of_number(1, 24, benchmark("sweep").DATA_FOLDER)])
    assert_is_table(bench.table({"seed": 1, "makings": {"made": found}}))
    whole = found["rows"][-1]
    assert (whole["trees"], whole["narrowings"]) == (1, 0)
    assert (whole["invented"], whole["failed"]) == (0, 0), found["wrong"]


def test_the_worst_making_is_the_figure_of_narrowed_trees():
    bench = benchmark("trees.bench")
    right = {"shape": "focal", "words": "as it is"} | dict.fromkeys(ERRORS)
    case = {
        "case": "0", "facts": {"tree": "random", "outlets": 1}, "failure": "", "seconds": 1.0,
        "invented": [], "outlets": 1,
    }  # fmt: skip
    wrong = right | {"words": "missed"}
    found = {
        "made": bench.summary([case | {"verdicts": [right, right]}]),
        "hourglass": bench.summary([case | {"verdicts": [right, wrong]}]),
    }
    text = bench.table({"seed": 7, "makings": found})
    assert_is_table(text)
    assert text.splitlines()[0] == "made, seed 7"
    assert text.splitlines()[-1] == "Worst making: hourglass, 50.0 % as they are."


def test_the_lumen_has_the_prescribed_diameter_and_the_published_one_has_not():
    rows = {row["mode"]: row for row in quick("lumen")["rows"]}
    default = rows["default"]
    # Edges of 0.5 mm: the mean stays within the goal for fine phantoms.
    assert 5.99 < default["mean"] < 6.01
    assert default["sd"] < 0.01
    assert rows["as published (k/4)"]["sd"] > 5 * default["sd"]
    assert rows["without facet compensation"]["mean"] < default["mean"]


def test_the_published_rule_leaves_the_lumen_that_the_paper_tells(data_dir):
    rows = {row["name"]: row["mm"] for row in quick("paper")["rows"]}
    published = benchmark("paper").PUBLISHED
    assert rows["before"] == pytest.approx(published["before"][:4], abs=0.12)
    assert rows["as published (k/4)"] == pytest.approx(published["SDFStent"][:4], abs=0.1)
    assert rows["default"] == pytest.approx([6.0, 6.0, 6.0, 0.0], abs=0.04)


# How it is told ----------------------------------------------------------------------------------


def test_each_checkout_is_timed_with_its_own_library_wherever_one_stands(tmp_path, monkeypatch):
    speed = benchmark("speed")
    for name in ("one", "other"):
        package = tmp_path / name / "SDFStentLib"
        package.mkdir(parents=True)
        (package / "__init__.py").touch()
        (package / "__main__.py").write_text(f"print([{len(name)}.0])", "utf-8")
    monkeypatch.chdir(tmp_path / "one")
    row = speed.Row("printed", ("-m", "SDFStentLib"), is_own=True)
    found = [speed.run(row, tmp_path / name).seconds for name in ("one", "other")]
    assert found == [3.0, 5.0]


def test_processes_of_two_checkouts_are_timed_in_turn():
    speed = benchmark("speed")
    row = speed.Row("printed", ("-c", "print('[0.5, 1.5]')"), is_own=True)
    runs = [speed.run(row, PROJECT) for _ in range(2)]
    assert [(one.seconds, one.processor) for one in runs] == [(1.0, 1.0)] * 2
    assert runs[0].megabytes > 1
    assert_is_table(speed.table({"printed": runs, "again": runs}))
    with pytest.raises(SystemExit, match="ended with 5"):
        speed.run(speed.Row("refused", ("-c", "raise SystemExit(5)")), PROJECT)
