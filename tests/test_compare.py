"""Several plans of one patient side by side: each column is what the plan's own run tells."""

import json
import re
import runpy
from html.parser import HTMLParser

import numpy as np
import pytest
from child_processes import PROJECT
from tube_files import INPUTS, plan_of, write_tube

from SDFStentLib.cli import main
from SDFStentLib.plan import compare, load_plan
from SDFStentLib.report import comparison_document, comparison_page, comparison_pictures
from SDFStentLib.report.picture import painting
from SDFStentLib.validation import DeploymentError

MIDDLE = {"center": [0, 0, 2]}  # cm; the throat of the tube


def a_stent(diameter=6.0, length=20, **more):
    return {"diameter": diameter, "length": length, "placement": MIDDLE, **more}


PLANS = {
    "one": plan_of(a_stent()),
    "wide": plan_of(a_stent(7.0), flow={"mean": 5, "peak": 20}),
    "two": plan_of(
        a_stent(6.0, 8, name="first", placement={"center": [0, 0, 1.7]}),
        a_stent(
            5.58, 8, name="second", placement={"center": [0, 0, 2.3]},
            balloon={"diameter": 6.0, "recoil_fraction": 0.07, "reason": "usual"},
        ),
    ),
}  # fmt: skip


def written(folder, **plans):
    for name, document in plans.items():
        (folder / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    return [f"{name}.json" for name in plans]


@pytest.fixture(scope="module")
def a_run_folder(tmp_path_factory):
    """Three plans of a tube, compared into `out`, and each carried out by `run`."""
    folder = tmp_path_factory.mktemp("compare")
    write_tube(folder)
    written(folder, **PLANS)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        names = [f"{name}.json" for name in PLANS]
        assert main(["compare", *names, "-o", "out", "--quiet"]) == 0
        for name in PLANS:
            assert main(["run", f"{name}.json", "-o", f"run_{name}", "--quiet"]) == 0
    return folder


class Page(HTMLParser):
    """The table of a page: per row its cells, per cell its lines of text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows, self.images, self._is_in_cell = [], 0, False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        self._is_in_cell = tag in ("td", "th") or (self._is_in_cell and tag in ("p", "b"))
        if tag in ("td", "th"):
            self.rows[-1].append("")
        self.images += tag == "img"

    def handle_endtag(self, tag):
        self._is_in_cell = self._is_in_cell and tag not in ("td", "th")

    def handle_data(self, data):
        if self._is_in_cell:
            self.rows[-1][-1] += f"{data}\n"


def page_of(folder):
    page = Page((folder / "out" / "comparison.html").read_text(encoding="utf-8"))
    return page, {row[0].split("\n")[0]: row[1:] for row in page.rows}


def document_of(folder):
    return json.loads((folder / "out" / "comparison.json").read_text(encoding="utf-8"))


def own_report(folder, name):
    return json.loads((folder / f"run_{name}" / "report.json").read_text(encoding="utf-8"))


# The numbers


def test_every_column_is_the_report_of_the_plans_own_run(a_run_folder):
    alternatives = document_of(a_run_folder)["alternatives"]
    assert [one["name"] for one in alternatives] == [*PLANS]
    for one in alternatives:
        own = own_report(a_run_folder, one["name"])
        for report in (own, one["report"]):
            del report["created"], report["timings"], report["outputs"]
        # The run's own name for a file that it lost nothing of.
        assert one["report"]["certificate"].pop("arrays_kept") is own["certificate"].pop(
            "arrays_kept"
        )
        # All lesions stand beside each other there.
        assert (one["report"].pop("whole_tree"), own.pop("whole_tree")) == (True, False)
        assert one["report"] == own
        assert (one["certified"], one["failure"]) == (True, None)


def test_the_page_shows_the_numbers_of_every_run(a_run_folder):
    page, rows = page_of(a_run_folder)
    assert rows["Plan"] == ["one\n", "wide\n", "two\n"]
    assert page.images == 1
    for column, name in enumerate(PLANS):
        own = own_report(a_run_folder, name)
        stents = own["stents"]
        for title, key in (
            ("Minimum lumen diameter", "after_mm"),
            ("Minimum lumen beyond the ends", "beyond_after_mm"),
        ):
            shown = re.findall(r"([\d.]+) mm \(before", rows[title][column])
            assert shown == [f"{s['diameters']['minimum_lumen'][key]:.2f}" for s in stents]
        prescribed = [f"{stent['lumen_diameter_mm']:.2f} mm" for stent in stents]
        assert re.findall(r"[\d.]+ mm", rows["Prescribed lumen diameter"][column]) == prescribed
        (lesion,) = own["lesions"]
        left = lesion["after"]["percent_diameter"]
        words = rows["Stenosis left of lesion 1"][column]
        assert words.startswith(f"{left:.0f} %" if round(left) >= 0 else "none (")
        low, high = (own["changes"]["area_ratio"][key] for key in ("smallest", "largest"))
        stretch = rows["Stretch of the wall, area after over before"][column]
        assert f"{low:.2f} to {high:.2f}" in stretch
        assert rows["Certificate"][column].strip() == own["certificate"]["sentence"]
        assert rows.get("Warnings", [""] * 3)[column].splitlines() == own["warnings"]
    assert "first: " in rows["Minimum lumen diameter"][2]
    assert rows["Balloon diameter"] == ["", "", "second: 6.00 mm\n"]
    told = rows["Pressure and flow"]
    assert "At the peak flow of 20 mL/s (1.2 L/min), drop over stent 1: recovered" in told[1]
    assert (told[0], told[2]) == ("", "")


# The picture


# What cannot be compared


def test_a_plan_that_fails_is_a_column_that_says_why(a_folder, capsys):
    outside = plan_of(a_stent(placement={"center": [3, 0, 2]}))
    names = written(a_folder, one=PLANS["one"], outside=outside)
    assert main(["compare", *names, "-o", "out"]) == 3
    assert main(["run", "outside.json", "-o", "alone"]) == 2
    said = capsys.readouterr().err.splitlines()
    reason = said[-1].removeprefix("sdfstent run: ")
    assert said[0] == f"warning: outside could not be carried out: {reason}"
    _, rows = page_of(a_folder)
    assert rows["Certificate"][1] == f"Could not be carried out: {reason}\n"
    assert all(row[1] == "" for title, row in rows.items() if title not in ("Plan", "Certificate"))
    failed = document_of(a_folder)["alternatives"][1]
    assert failed == {"name": "outside", "certified": False, "failure": reason, "report": None}


def test_nothing_is_written_when_every_plan_fails(a_folder, capsys):
    outside = plan_of(a_stent(placement={"center": [3, 0, 2]}))
    names = written(a_folder, a=outside, b=outside)
    assert main(["compare", *names, "-o", "out"]) == 2
    assert "None of the plans could be carried out; a: " in capsys.readouterr().err
    assert not (a_folder / "out").exists()


def test_a_plan_without_centerline_is_compared_and_its_lesions_were_not_looked_for(a_folder):
    alone = plan_of({"diameter": 6.0, "placement": {"axis": {"file": "axis.vtp"}}})
    alone["inputs"] = {key: value for key, value in INPUTS.items() if key != "centerline"}
    names = written(a_folder, one=PLANS["one"], alone=alone)
    assert main(["compare", *names, "-o", "out", "--quiet"]) == 0
    _, rows = page_of(a_folder)
    assert "that takes a centerline" in rows["Stenosis left of lesion 1"][1]


def test_json_is_printed_and_is_the_document(a_folder, capsys):
    names = written(a_folder, one=PLANS["one"], wide=PLANS["wide"])
    assert main(["compare", *names, "-o", "out", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == document_of(a_folder)


def test_a_page_without_picture_says_why(a_folder, monkeypatch):
    def broken(*_):
        raise DeploymentError("No OpenGL here.")

    names = written(a_folder, one=PLANS["one"], wide=PLANS["wide"])
    result = compare({name: load_plan(name) for name in names})
    monkeypatch.setattr(painting.subprocess, "run", lambda *_, **__: broken())
    pictures = comparison_pictures(result)
    page = comparison_page(comparison_document(result), pictures)
    assert "No OpenGL here." in page
    assert Page(page).images == 0


def test_the_picture_is_written_as_a_png_of_all_panels(a_folder, capsys):
    names = written(a_folder, one=PLANS["one"], wide=PLANS["wide"])
    page = ["-o", "page.html"]
    assert main(["compare", *names, *page, "--picture", "all.gif"]) == 2
    assert "expected a picture that ends in .png" in capsys.readouterr().err
    assert main(["compare", *names, *page, "--picture", "all.png", "--quiet"]) == 0
    data = (a_folder / "all.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert [int.from_bytes(data[at : at + 4], "big") for at in (16, 20)] == [1800, 700]


def test_the_papers_figure_is_made_of_a_phantom_where_there_is_no_patient(tmp_path):
    script = runpy.run_path(str(PROJECT / "benchmarks" / "three_plans.py"))
    assert script["main"](tmp_path, is_phantom=True) == 0
    document = json.loads((tmp_path / "compared" / "comparison.json").read_text(encoding="utf-8"))
    left = [
        [round(lesion["after"]["percent_diameter"]) for lesion in one["report"]["lesions"]]
        for one in document["alternatives"]
    ]
    main_ones, daughters, all_four = np.array(left)
    # As they were made, and as they are opened.
    assert main_ones[2:] == pytest.approx([40, 35], abs=1)
    assert daughters[:2] == pytest.approx([50, 45], abs=1)
    assert (abs(main_ones[:2]) <= 2).all()
    assert (abs(daughters[2:]) <= 2).all()
    assert (abs(all_four) <= 2).all()
