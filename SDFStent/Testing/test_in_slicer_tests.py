"""The unittest classes that ctest runs inside Slicer, run by the host here."""

import importlib.util
import unittest
from pathlib import Path

import pytest

IN_SLICER = Path(__file__).parent / "Python"


def run(testCaseClass):
    result = unittest.TestResult()
    unittest.defaultTestLoader.loadTestsFromTestCase(testCaseClass).run(result)
    assert not result.errors + result.failures, (result.errors + result.failures)[0][1]
    assert result.testsRun > 1


def test_the_self_test_of_the_module(aScene, theModule):
    run(theModule.python.SDFStentTest)


@pytest.mark.parametrize("path", sorted(IN_SLICER.glob("*Test.py")), ids=lambda p: p.stem)
def test_files_that_ctest_runs(aScene, path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    python = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(python)
    run(getattr(python, path.stem))
