"""A file that CMake does not list is not installed: compare the lists with the disk."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SHIPPED = {
    "SDFStent": lambda p: p.suffix in {".py", ".ui", ".svg", ".png"} and "Testing" not in p.parts,
    "SDFStentLib": lambda p: p.suffix in {".py", ".json", ".csv", ".typed", ".vtp"},
}


def listed(folder):
    """Every file in the lists of a folder: `set(..._SCRIPTS ...)`, resources and samples."""
    text = re.sub(r"#[^\n]*", "", (ROOT / folder / "CMakeLists.txt").read_text(encoding="utf-8"))
    blocks = re.findall(r"set\(\w+_(?:SCRIPTS|RESOURCES|SAMPLES)\s+([^)]*)\)", text)
    return [f.replace("${MODULE_NAME}", folder) for block in blocks for f in block.split()]


def on_disk(folder):
    top = ROOT / folder
    files = [p.relative_to(top) for p in top.rglob("*") if "__pycache__" not in p.parts]
    return sorted(str(p) for p in files if (top / p).is_file() and SHIPPED[folder](p))


@pytest.mark.parametrize("folder", sorted(SHIPPED))
def test_every_shipped_file_is_listed_once_and_every_listed_file_exists(folder):
    assert sorted(listed(folder)) == on_disk(folder)


def test_the_project_is_called_as_the_index_entry_and_the_module():
    project = re.search(
        r"project\((\w+)\)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    ).group(1)
    assert (ROOT / f"{project}.json").is_file()
    assert (ROOT / project / f"{project}.py").is_file()
    assert not project.startswith("Slicer")  # the index refuses such names


def test_the_index_entry_follows_the_schema():
    entry = json.loads((ROOT / "SDFStent.json").read_text(encoding="utf-8"))
    allowed = {
        "$schema": str,
        "category": str,
        "scm_url": str,
        "scm_revision": str,
        "scm_type": str,
        "build_dependencies": list,
        "dicom_support_rule": str,
        "build_subdirectory": str,
        "enabled": bool,
        "tier": int,
    }
    assert {"$schema", "category", "scm_url"} <= set(entry) <= set(allowed)
    assert all(isinstance(value, allowed[key]) for key, value in entry.items())
    assert re.fullmatch(r"https://.*-v1\.0\.\d\.json#", entry["$schema"])
    assert 1 <= entry["tier"] <= 5
    depends = re.search(
        r'EXTENSION_DEPENDS "(\w+)"', (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    )
    assert (depends.group(1) == "NA") == (entry["build_dependencies"] == [])


def test_the_index_finds_icon_and_screenshot_where_it_looks():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    icon = re.search(r'set\(EXTENSION_ICONURL "([^"\s]+)"\)', text).group(1)
    shots = re.search(r'set\(EXTENSION_SCREENSHOTURLS "([^"]+)"\)', text).group(1).split()
    for url in [icon, *shots]:
        assert url.startswith("https://raw.githubusercontent.com/")
        assert (ROOT / url.split("/main/", 1)[1]).is_file(), url
