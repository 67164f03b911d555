"""What a stranger installs: a wheel that is whole, of one version, and runs without the sources."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile

import pytest
from child_processes import PROJECT, python

from SDFStentLib import __version__

SHIPPED = ("SDFStentLib", "SDFStentApp", "SDFStent/SDFStentSlicer", "SDFStent/Resources/UI")


@pytest.mark.parametrize(
    ("document", "place"),
    [
        ("pyproject.toml", r'^version = "(.+)"'),
        ("CITATION.cff", r"^version: (.+)"),
        ("CHANGELOG.md", r"^## (\S+?),? "),
        ("README.md", r"(\d\S+) is not released yet"),
    ],
)
def test_one_version_is_told_everywhere(document, place):
    text = (PROJECT / document).read_text(encoding="utf-8")
    assert re.search(place, text, re.M)[1] == __version__


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built of a copy, so that nothing of an earlier build is in it."""
    folder = tmp_path_factory.mktemp("wheel")
    ignored = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "*.egg-info")
    copy = shutil.copytree(PROJECT, folder / "sources", ignore=ignored)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(folder), copy]
    subprocess.run(pip, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def test_the_wheel_holds_all_that_is_shipped_and_no_test(wheel):
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info" not in name}
    files = [file for folder in SHIPPED for file in (PROJECT / folder).rglob("*")]
    files.append(PROJECT / "SDFStent" / "SDFStent.py")
    suffixes = (".py", ".json", ".css", ".js", ".html", ".ui", ".vtp", ".typed")
    wanted = {file.relative_to(PROJECT).as_posix() for file in files if file.suffix in suffixes}
    assert names == wanted


def test_the_wheel_works_where_the_sources_are_not(wheel, tmp_path):
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    program = "import SDFStentLib.cli as it; print(it.__file__); it.main(['demo', '-o', 'made'])"
    paths = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    done = python(program, folder=tmp_path, env=paths)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(tmp_path / "site"))
    assert "certified" in done.stdout
    assert (tmp_path / "made" / "report.html").is_file()


def test_the_entry_of_the_extension_index_fits_this_repository():
    """Fields of version 1.0.2 of the index' schema; names and address as in CMakeLists.txt."""
    entry = json.loads((PROJECT / "SDFStent.json").read_text(encoding="utf-8"))
    needed = {"$schema", "category", "scm_url"}
    more = {"scm_revision", "build_dependencies", "build_subdirectory", "tier"}
    assert needed <= set(entry) <= needed | more
    assert entry["$schema"].endswith("slicer-extension-catalog-entry-schema-v1.0.2.json#")
    lists = (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8")
    assert "project(SDFStent)" in lists
    assert f'set(EXTENSION_HOMEPAGE "{entry["scm_url"]}")' in lists
    assert 'set(EXTENSION_DEPENDS "NA")' in lists
    assert entry["build_dependencies"] == []
    assert entry["scm_url"].rpartition("/")[2].startswith("Slicer")
    assert (entry["category"], entry["tier"]) == ("Planning", 1)
    urls = re.findall(r"githubusercontent\.com/SDFStent/SlicerSDFStent/main/(\S+?)\"", lists)
    assert len(urls) == 2
    assert all((PROJECT / url).is_file() for url in urls)
