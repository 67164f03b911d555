"""Fixtures of all test files, and the optional real anatomies."""

import importlib.util
import os
from pathlib import Path
from subprocess import CompletedProcess
from types import ModuleType

import pytest
from child_processes import PROJECT
from hypothesis import HealthCheck, settings
from tube_files import write_tube

from benchmarks.phantoms import branching_pulmonary_artery, cavopulmonary_connection
from SDFStentLib.cli import main
from SDFStentLib.deformation import deployment as engine
from SDFStentLib.flow import channels_of
from SDFStentLib.plan import Plan, run_plan
from SDFStentLib.stent import AtCenter, InputFile, Stent

# How long an example takes says more about the machine than about the code.
settings.register_profile("new", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# The same examples for everybody, so that what passes here passes there. To search for other
# examples set HYPOTHESIS_PROFILE=new.
settings.register_profile("same", settings.get_profile("new"), derandomize=True, database=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

DATA_FOLDER = Path(
    os.environ.get("SDFSTENT_DATA", Path(__file__).resolve().parents[2] / "shared" / "data")
)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real anatomies; tests that need it are skipped, with the reason, if it is
    absent."""
    if not (DATA_FOLDER / "pulmonary_surface_cm.vtp").is_file():
        pytest.skip(f"real anatomies not found in {DATA_FOLDER}; set SDFSTENT_DATA to their folder")
    return DATA_FOLDER


@pytest.fixture
def a_folder(tmp_path, monkeypatch):
    """A working folder with a tube of 6 mm narrowed to 3.6 mm, its centerline and an
    axis, in cm."""
    write_tube(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def result(tmp_path_factory):
    """A stent in a tube of 6 mm, narrowed to 3.6, with files in cm: what came of its plan."""
    folder = tmp_path_factory.mktemp("result")
    write_tube(folder)
    files = (InputFile(str(folder / name)) for name in ("tube.vtp", "line.vtp"))
    stent = Stent(6.5, placement=AtCenter([0, 0, 20.0]), length=20.0, name="main <3")
    return run_plan(Plan((stent,), *files, units="cm"))


@pytest.fixture(scope="session")
def a_fork():
    """Channels of a fork, and a place in its right branch."""
    phantom = branching_pulmonary_artery()
    right = next(one.center for one in phantom.openings if "right" in one.name)
    return channels_of(phantom.surface, phantom.centerline), tuple(right.tolist())


@pytest.fixture(scope="session")
def fontan():
    return cavopulmonary_connection(1.3)


@pytest.fixture
def shell(monkeypatch, capsys):
    """A function that does in this process what the installed command does in a folder."""

    def run(*words: object, folder: Path) -> CompletedProcess[str]:
        monkeypatch.chdir(folder)
        capsys.readouterr()
        return CompletedProcess(words, main([*map(str, words)]), *capsys.readouterr())

    return run


@pytest.fixture(scope="module")
def sweep() -> ModuleType:
    """The sweep of random stents, loaded as the script that it is."""
    spec = importlib.util.spec_from_file_location("sweep", PROJECT / "benchmarks" / "sweep.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def attempts(monkeypatch):
    """A list of all attempts that a deployment makes."""
    made = []
    plain = engine.Attempt

    def recorded(*arguments):
        made.append(plain(*arguments))
        return made[-1]

    monkeypatch.setattr(engine, "Attempt", recorded)
    return made
