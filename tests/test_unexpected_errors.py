"""Inputs that once ended in "unexpected error": each has its sentence, or is carried out."""

import json
import shutil
from pathlib import Path

import pytest
from child_processes import installed
from cohort_cases import bytes_of, document, sweep_in, tube_folder
from test_refusals import made

from SDFStentLib.cohort import run_sweep

PLACED = "deploy tube.vtp --units cm --centerline line.vtp --center 0 0 2 --length 20 -o out.vtp"
PROFILE = PLACED + " --profile"


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("unexpected")
    made(folder)
    return folder


@pytest.fixture
def folder(prepared, tmp_path):
    return shutil.copytree(prepared, tmp_path / "work")


@pytest.fixture
def ended(shell):
    """Carries out a command in a folder, in this process: code, stdout, stderr."""

    def run(folder, command):
        done = shell(*command.split(), folder=folder)
        return done.returncode, done.stdout, done.stderr

    return run


def process(folder, command, **streams):
    """The installed command once it is done."""
    return installed(*command.split(), folder=folder, **streams)


def test_a_thin_stent_is_drawn_with_as_many_rings_as_can_be_told_apart(folder, ended):
    code, _, error = ended(folder, "run thin.json -o results --export-device struts.vtp")
    assert code == 0, error
    assert (folder / "results" / "report.html").is_file()
    assert (folder / "struts.vtp").stat().st_size > 1000


def test_lines_of_a_profile_may_end_in_any_way(folder, ended):
    outputs = set()
    for name in ("cr", "crlf", "mixed", "quoted"):
        code, _, error = ended(folder, f"{PROFILE} {name}.csv --quiet")
        assert code == 0, error
        outputs.add((folder / "out.vtp").read_bytes())
    assert len(outputs) == 1


FULL = Path("/dev/full")


@pytest.mark.skipif(not FULL.exists(), reason="the system has no file that is always full")
def test_words_that_nobody_can_take_end_in_a_sentence(folder):
    with FULL.open("w") as full:
        done = process(folder, "devices", stdout=full)  # few words, refused at the end
    assert done.returncode == 2
    assert done.stderr.endswith(
        "standard output: cannot be written (No space left on device); free space, or choose "
        "another folder or name.\n"
    )
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(not FULL.exists(), reason="the system has no file that is always full")
@pytest.mark.parametrize(
    ("command", "code"), [("check none.vtp", 2), (f"{PLACED} --diameter 3", 0)]
)
def test_warnings_and_errors_that_nobody_can_take_change_no_result(folder, command, code):
    with FULL.open("w") as full:
        assert process(folder, command, stderr=full).returncode == code
    assert (folder / "out.vtp").exists() == (code == 0)


# Cohorts that are damaged, or come from elsewhere


@pytest.fixture(scope="module")
def a_cohort(tmp_path_factory):
    """Two cases, done."""
    folder = tmp_path_factory.mktemp("cohort")
    tube_folder(folder)
    changes = {"axes": {"diameter": [6, 6.5]}, "store": "moved"}
    (folder / "sweep.json").write_text(json.dumps(document(**changes)), encoding="utf-8")
    assert run_sweep(sweep_in(folder, **changes), folder / "out", workers=1).certified == 2
    return folder


@pytest.fixture
def cohort(a_cohort, tmp_path):
    return shutil.copytree(a_cohort, tmp_path / "cohort")


DAMAGED = ["{}", "[]", "7", '{"files": {}}', '{"cases": {}}', "{"]


@pytest.mark.parametrize("text", [*DAMAGED, '{"files": {}, "status": "done", "rows": [7]}'])
@pytest.mark.parametrize("name", ["case.json", "times.json"])
def test_a_case_whose_files_lack_something_is_done_again(cohort, a_cohort, name, text, ended):
    for path in (cohort / "out").glob(f"cases/*/*/{name}"):
        path.write_text(text, encoding="utf-8")
    for command in ("sweep --status out", "sweep --table out"):
        code, _, error = ended(cohort, command)
        assert code == 0, error
    manifest = (cohort / "out" / "manifest.csv").read_text(encoding="utf-8")
    assert manifest.count(",open,") == (2 if name == "case.json" else 0)
    if (name, text) == ("case.json", '{"files": {}}'):
        assert ended(cohort, "sweep sweep.json -o out --workers 1")[0] == 0
        assert bytes_of(cohort / "out") == bytes_of(a_cohort / "out")


def without(key):
    """A document of a cohort that lacks something."""
    return lambda found: {name: value for name, value in found.items() if name != key}


LACKING = {
    **{text: lambda _, text=text: json.loads(text) for text in DAMAGED[:-1]},
    **{
        f"no {key}": without(key)
        for key in ("axes", "cases", "patients", "method", "seed", "store", "sdfstent_version")
    },
    "a path as a case": lambda found: {**found, "cases": [["../../victim/aaaaaaa", 0, [6]]]},
    "no such patient": lambda found: {**found, "cases": [[*found["cases"][0][:1], 3, [6]]]},
    "too few values": lambda found: {**found, "cases": [[*found["cases"][0][:2], []]]},
    "an axis without a name": lambda found: {**found, "axes": [{"is_number": True}]},
    "a patient without files": lambda found: {**found, "patients": [{"name": "a", "units": "mm"}]},
}


@pytest.mark.parametrize("change", LACKING.values(), ids=LACKING)
def test_a_document_of_a_cohort_that_lacks_something_is_none(cohort, change, ended):
    path = cohort / "out" / "cohort.json"
    found = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(change(found)), encoding="utf-8")
    (cohort / "victim").mkdir()
    (cohort / "victim" / "mine.txt").touch()
    commands = ["sweep --status out", "sweep --table out", "sweep sweep.json -o out --workers 1"]
    for command in commands:
        code, _, error = ended(cohort, command)
        assert code == 2, error
        assert "expected the folder of a cohort, got one" in error
        assert error.count("\n") == 1
    assert (cohort / "victim" / "mine.txt").exists()
