"""The user guide: its recipes run, its pictures exist, and it speaks of every control."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs" / "user_guide.md").read_text(encoding="utf-8")
RECIPES = re.findall(r"^```python\n(.*?)^```$", GUIDE, flags=re.MULTILINE | re.DOTALL)
BUTTONS = ("QCheckBox", "QPushButton", "QToolButton", "QLabel", "ctkCollapsibleButton")


@pytest.mark.parametrize("number", range(len(RECIPES)))
def test_every_recipe_of_the_user_guide_runs(aScene, number, capsys):
    import slicer

    names = {"slicer": slicer}
    exec(RECIPES[0], names)
    if number:
        exec(RECIPES[number], names)
    assert "Surface certified for meshing" in capsys.readouterr().out


def test_pictures_of_the_guide_exist():
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", GUIDE)
    assert len(pictures) >= 7
    for picture in pictures:
        assert (ROOT / "docs" / picture).stat().st_size > 5_000


@pytest.mark.bench
def test_the_pictures_can_be_made_again(tmp_path):
    script = ROOT / "SDFStent" / "Testing" / "make_pictures.py"
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path)], capture_output=True, text=True, timeout=3600
    )
    assert done.returncode == 0, done.stderr
    used = set(re.findall(r"\(images/([^)]+)\)", GUIDE)) - {"dragging.gif"}  # made by --moving
    assert {path.name for path in tmp_path.iterdir()} == used | {"panel.png"}


def test_every_control_of_the_panel_is_in_the_reference():
    panel = ElementTree.parse(ROOT / "SDFStent" / "Resources" / "UI" / "SDFStent.ui")
    reference = GUIDE[GUIDE.index("## Every control") : GUIDE.index("## Python console recipes")]
    for widget in panel.iter("widget"):
        text = widget.find("property[@name='text']/string")
        if widget.get("class") in BUTTONS and text is not None and text.text:
            assert text.text.rstrip(":") in reference, widget.get("name")


def test_sentences_of_the_troubleshooting_are_those_that_users_read():
    table = GUIDE[GUIDE.index("## Troubleshooting") : GUIDE.index("## How to cite")]
    files = [*ROOT.glob("SDFStentLib/**/*.py"), *ROOT.glob("SDFStent/SDFStentSlicer/*.py")]
    said = "".join(path.read_text(encoding="utf-8") for path in files)
    said = re.sub(r'"\s*\n\s*f?"', "", said)  # sentences that go on in the next line
    sentences = re.findall(r'"([^"]+)"', table)
    assert len(sentences) > 10
    for sentence in sentences:
        for part in re.split(r"\.\.\.|Stent 1: |Warning: |\b\d\b", sentence):
            assert part.strip(" .:,;") in said, sentence


def test_anchors_of_the_guide_lead_somewhere():
    headings = {
        re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")
        for title in re.findall(r"^#+ (.+)$", GUIDE, flags=re.MULTILINE)
    }
    for anchor in re.findall(r"\]\(#([^)]+)\)", GUIDE):
        assert anchor in headings
