"""The report: its document, its page and its figure."""

import html
import json
import math
import re
from base64 import b64decode
from copy import deepcopy
from dataclasses import fields, replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import polydata_from_arrays
from SDFStentLib.plan import Plan, PlanResult, read_input_files, treatment_of
from SDFStentLib.report import (
    Facts,
    Report,
    document_json,
    plan_report,
    stent_facts,
    write_report,
    write_report_figure,
)
from SDFStentLib.report.html import html_page
from SDFStentLib.report.lesions import treated_lesion_facts
from SDFStentLib.report.picture.drawing import Stroke
from SDFStentLib.report.picture.plot import diameter_plot, figure
from SDFStentLib.report.stents import PLACEMENTS, _bend_words
from SDFStentLib.report.words import plain_text, point_words
from SDFStentLib.stent import AtCenter, Placement, Stent
from SDFStentLib.validation import DeploymentError, InputError, Points, Triangles


@pytest.fixture(scope="module")
def the_document(result):
    return plan_report(result).as_dict()


@pytest.fixture
def document(the_document):
    """To be changed."""
    return deepcopy(the_document)


@pytest.fixture
def sections(result):
    """Of which the page is made; to be changed."""
    return dict(plan_report(result).sections)


def told_of(result, *, number=1, lesions=None, **changes):
    """The facts of the stent, had it been another one."""
    (treated,) = result.told.stents
    stent = replace(treated.stent, **changes)
    return stent_facts(replace(treated, stent=stent, number=number), lesions, "cm")


class PageReader(HTMLParser):
    """Collects text, and tags that would load or run something."""

    def __init__(self, page):
        super().__init__()
        self.text, self.loads, self.open = "", [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag in ("script", "link", "img", "iframe", "object"):
            self.loads.append(tag)
        self.loads += [name for name, _ in attrs if name in ("src", "href") or name[:2] == "on"]
        if tag not in ("meta", "br", "img"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, "tags close in the order in which they open"

    def handle_data(self, data):
        self.text += data


# The document


def test_the_document_holds_lumen_and_lesions_before_and_after(document, result, sections):
    assert (document["schema"], document["schema_version"]) == ("sdfstent-report", 1)
    assert document["notice"] == "Research use only, not a medical device."
    (stent,), (lesion,) = result.treatment.stents, document["lesions"]
    before, after = (one.inscribed_diameter for one in (stent.around_before, stent.around_after))
    at = stent.around_before.arc_length
    within = (at >= -1e-9) & (at <= stent.axis.deployed_length + 1e-9)
    diameters = document["diameters"]
    narrowest, over = diameters["minimum_lumen"], diameters["over_stented_length"]
    for when, widths in (("before", before), ("after", after)):
        assert narrowest[f"{when}_mm"] == np.nanmin(widths[within])
        assert narrowest[f"{when}_at_mm"] == at[within][np.nanargmin(widths[within])]
        assert narrowest[f"beyond_{when}_mm"] == np.nanmin(widths[~within])
        assert over[when]["mean_mm"] == pytest.approx(np.nanmean(widths[within]))
        assert over[when]["sd_mm"] == pytest.approx(np.nanstd(widths[within]))
    error = np.nanmean(after[within]) - 6.5
    assert over["mean_after_minus_prescribed_mm"] == pytest.approx(error)
    prescribed = [None if one is None else 6.5 for one in diameters["along"]["prescribed_mm"]]
    assert [one is not None for one in prescribed] == within.tolist()
    assert diameters["along"]["prescribed_mm"] == prescribed
    assert diameters["stent_ends_mm"] == [0.0, pytest.approx(18.0)]
    assert lesion["percent_diameter"] == pytest.approx(40, abs=1)
    assert np.multiply(lesion["place"], 10) == pytest.approx(lesion["place_mm"])
    assert document["stents"][0]["lesions"] == [1]
    text = PageReader(html_page(sections)).text
    assert re.search(r"Lesion 1, diameter stenosis40 %none \(\d+ % above reference\)", text)
    assert f"Lesion 1 against {lesion['reference']['words']}." in text


@pytest.mark.parametrize(
    ("count", "words", "table"),
    [
        (1, "This stent covers no lesion of 15 % or more.", True),
        (0, "No lesion of 15 % or more was found.", True),
        (None, "Lesions were not looked for", False),
    ],
)
def test_a_stent_without_a_lesion_has_no_percentage(result, sections, count, words, table):
    found = None if count is None else [replace(one, stents=()) for one in result.lesions[:count]]
    sections["stents"] = [told_of(result, lesions=found)]
    sections["lesions"] = found and [treated_lesion_facts(one) for one in found]
    page = html_page(sections)
    assert words in PageReader(page).text
    assert "Diameter stenosis" not in page
    assert ("Lesions of the vessel" in page) == table


def test_what_is_not_known_is_null_and_never_nan():
    text = document_json({"one": np.array([math.nan, 6.0]), "other": (math.inf, np.float64(1))})
    assert json.loads(text) == {"one": [None, 6.0], "other": [None, 1.0]}


# Files


def test_what_cannot_be_written_is_refused_and_leaves_no_file(tmp_path, result):
    for write, name, words in (
        (write_report, "r.pdf", r"ends in \.json, \.html, \.htm, got '\.pdf'"),
        (write_report_figure, "f.gif", r"ends in \.png, \.svg, got '\.gif'"),
    ):
        with pytest.raises(InputError, match=words):
            write(plan_report(result), tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match=r"certificate\.faces: expected numbers.* got function"):
        Report({"certificate": {"faces": lambda: 0}}).as_dict()


# The page


def in_order(text, *words):
    places = [text.index(word) for word in words]
    return places == sorted(places)


def test_a_failed_certificate_and_the_warnings_stand_before_every_table(sections):
    failed = {"passed": False, "sentence": "Not certified: the surface folds."}
    told = {"warnings": ["The stent was shortened."], "certificate": failed}
    page = html_page(sections | told)
    assert in_order(
        page,
        "Research use only",
        "<p class='bad'>Not certified: the surface folds.</p>",
        "<p class='warn'>The stent was shortened.</p>",
        "<table",
        "<svg",
    )
    assert page.count("Not certified") == 1
    passed = html_page(sections | {"warnings": told["warnings"]})
    assert in_order(passed, "<p class='warn'>", "<p class='good'>Surface", "<table")
    assert "was not checked" in html_page(sections | {"certificate": None})


def rows_of(page):
    """Of the stent."""
    planned = page.partition(", as planned")[2].partition("<h2>")[0]
    return dict(re.findall(r"<tr><td>([^<]*)</td><td>([^<]*)</td></tr>", planned))


def test_a_planned_stent_reads_in_words_units_and_percent(sections):
    rows = rows_of(html_page(sections))
    expected = {
        "Prescribed lumen diameter": "6.5 mm",
        "Nominal length": "20.0 mm",
        "Deployed length along the axis": "18.0 mm",
        "Foreshortening on expansion": "10 % of nominal length, the usual share, assumed without "
        "a device",
        "Placed": "by its middle",
        "Proximal end (x, y, z)": "0.0, 0.0, 11.0 mm; in the file 0.00, 0.00, 1.10 cm",
        "Straight distance of its ends": "18.0 mm",
        "Tightest bend of its axis": "none, the axis is straight",
    }
    assert {name: rows.get(name) for name in expected} == expected
    for raw in ("AtCenter", "fraction", "min bend", "moved points", "_"):
        assert raw not in "".join([*rows, *rows.values()])


def test_numbers_of_a_planned_stent_read_in_words():
    assert _bend_words(32.0, 6.5, 18.0) == (
        "radius 32.0 mm, of the circle through three points of the axis that are 3.2 mm apart "
        "(the stent radius)"
    )
    assert point_words((29.62, -64.4, 63.49), "cm") == (
        "29.6, \N{MINUS SIGN}64.4, 63.5 mm; in the file 2.96, \N{MINUS SIGN}6.44, 6.35 cm"
    )
    assert plain_text("", 4917) == "4\N{THIN SPACE}917"


def test_every_placement_has_words():
    assert set(PLACEMENTS) == {kind.__name__ for kind in Placement.__args__}


def test_headings_name_the_stent_and_its_number_in_the_plan(result, sections):
    first, second = told_of(result), told_of(result, number=2)

    def headings(*stents):
        return re.findall(r"<h2>(Stent[^<]*)</h2>", html_page(sections | {"stents": stents}))

    assert headings(first, told_of(result, number=2, name="")) == [
        "Stent 1 of 2: main &lt;3, lumen before and after",
        "Stent 2 of 2, lumen before and after",
        "Stent 1 of 2: main &lt;3, as planned",
        "Stent 2 of 2, as planned",
    ]
    assert headings(first)[1] == "Stent: main &lt;3, as planned"
    assert headings(second)[1] == "Stent 2 of the plan: main &lt;3, as planned"


def test_the_page_is_well_formed_loads_nothing_escapes_names_and_tells_files_in_words(sections):
    told = {"file": "a & b.vtp", "sha256": "0f"}
    (surface, *others) = sections["inputs"]
    renamed = Facts(
        one._replace(after=told[one.key], words=told[one.key]) if one.key in told else one
        for one in surface
    )
    sections["inputs"] = [renamed, *others]
    page = html_page(sections)
    reader = PageReader(page)
    assert reader.loads == reader.open == []
    assert "<h3>Surface</h3>" in page
    for words in (
        *("main <3", "a & b.vtp", "SHA-2560f"),
        "Framenot said by the file",
    ):
        assert words in reader.text


# The plot


CURVES = ("equivalent_before", "equivalent_after", "mis_before", "mis_after", "prescribed")


def curves_of(diameters):
    """Grid and legend are straight; a curve has a corner per station."""
    marks = diameter_plot(diameters).marks
    return [mark.points for mark in marks if isinstance(mark, Stroke) and len(mark.points) > 3]


def test_the_curves_of_the_plot_are_the_measured_diameters(document):
    along = document["diameters"]["along"]
    expected = [[one for one in along[f"{key}_mm"] if one is not None] for key in CURVES]
    lines = curves_of(document["diameters"])
    assert [len(line) for line in lines] == [len(one) for one in expected]
    heights, expected = np.array([y for line in lines for _, y in line]), np.concatenate(expected)
    slope, floor = np.polyfit(expected, heights, 1)
    np.testing.assert_allclose(heights, floor + slope * expected, atol=1e-9)
    assert slope < 0, "larger diameters are drawn higher"


def test_a_curve_is_interrupted_where_nothing_was_measured(document, result, sections):
    diameters = document["stents"][0]["diameters"]
    whole = [len(line) for line in curves_of(diameters)]
    diameters["along"]["mis_before_mm"][8] = None
    broken = [len(line) for line in curves_of(diameters)]
    assert broken == [*whole[:2], 8, whole[2] - 9, *whole[3:]]
    for key in CURVES:
        diameters["along"][f"{key}_mm"] = [None] * len(diameters["along"]["arc_length_mm"])
    assert diameter_plot(diameters) is None
    (treated,) = result.told.stents
    lost = {
        name: replace(
            getattr(treated, name),
            inscribed_diameter=getattr(treated, name).inscribed_diameter * math.nan,
            equivalent_diameter=getattr(treated, name).equivalent_diameter * math.nan,
            known=None,
        )
        for name in ("before", "after", "around_before", "around_after")
    }
    sections["stents"] = [stent_facts(replace(treated, **lost), ())]
    text = PageReader(html_page(sections)).text
    assert "Smallest to largestnot knownnot known" in text


# The figure and the picture


def test_the_figure_is_the_same_drawing_in_both_formats(tmp_path, result):
    stents = [told_of(result, name="main <3\x1b\ud800"), told_of(result, number=2)]
    two = Report({**plan_report(result).sections, "stents": stents})
    write_report_figure(two, tmp_path / "f.SVG")
    texts = [t.text for t in ElementTree.fromstring((tmp_path / "f.SVG").read_text("utf-8")).iter()]
    assert r"Stent 1 of 2: main <3\x1b\ud800" in texts
    assert "Research use only, not a medical device." in texts
    assert texts.count("lumen diameter (mm)") == 2
    try:
        write_report_figure(two, tmp_path / "f.png")
    except DeploymentError as error:
        pytest.skip(f"nothing here renders: {error}")
    header = (tmp_path / "f.png").read_bytes()[:24]
    assert header.startswith(b"\x89PNG\r\n")
    size = [int.from_bytes(part, "big") for part in (header[16:20], header[20:24])]
    drawing = figure(two.as_dict())
    assert size == [2 * drawing.width, 2 * drawing.height]


def test_the_clinicians_part_comes_first_and_what_is_to_be_checked_last(sections):
    page = html_page(sections | {"warnings": ["Shortened."]}, b"\x89PNG\r\n\x1a\n")
    assert in_order(
        page,
        "<h2>Warnings",
        "<p class='good'>Surface certified",
        "<img",
        "<h2>Lesions of the vessel",
        "lumen before and after</h2>",
        "Stent of 6.5 x 18.0 mm (20 mm as packed, 10 % shorter once expanded: the usual share, ",
        "placed by its middle.",
        "<svg",
        "<div class='details'>",
        ", as planned</h2>",
        "<h2>Input files",
        "SHA-256",
        "Time:",
        "<h2>Definitions",
    )
    assert re.search(r"\.details\{break-before:page\}", page)


def test_a_diameter_is_told_to_the_hundredth_where_it_was_set_so(result, sections):
    """Else one page said 6.2 mm in two places and 6.25 mm in a third."""
    page = html_page(sections | {"stents": [told_of(result, diameter=6.25)]})
    assert "Stent of 6.25 x 18.0 mm" in page
    assert "<td>Prescribed lumen diameter</td><td>6.25 mm</td>" in page


def test_the_page_holds_the_picture_or_says_why_there_is_none(tmp_path, result, sections):
    png = b"\x89PNG\r\n" + bytes(range(256))
    write_report(plan_report(result, picture=png), tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text("utf-8")
    assert PageReader(page).loads == ["img", "src"]
    (data,) = re.findall(r"src='data:image/png;base64,([^']*)'", page)
    assert b64decode(data, validate=True) == png
    assert in_order(page, "Surface certified", "<img", "<table")
    without = html_page(sections, "No <OpenGL>.")
    assert PageReader(without).loads == []
    assert "no picture of the vessel. No <OpenGL>." in PageReader(without).text
    assert "picture" not in html_page(sections)


# What a report tells of the run's settings, of the surface's triangles, and of coordinates.


def quality(points: Points, triangles: Triangles, measure: str) -> np.ndarray:
    """A measure of every triangle by VTK's Verdict library."""
    judge = vtkMeshQuality()
    judge.SetInputData(polydata_from_arrays(points, triangles))
    getattr(judge, f"SetTriangleQualityMeasureTo{measure}")()
    judge.Update()
    return vtk_to_numpy(judge.GetOutput().GetCellData().GetArray("Quality"))


@pytest.fixture(scope="module")
def in_cm(data_dir: Path) -> PlanResult:
    """A deployment in an anatomy, in a file in cm."""
    surface, line = (data_dir / f"pulmonary_{part}_cm.vtp" for part in ("surface", "centerline"))
    inputs = read_input_files(surface, line, "cm")
    stent = Stent(20.0, placement=AtCenter(np.array([27.16, -54.26, 67.09])), length=20.0)
    plan = Plan((stent,), units="cm", settings=DeploymentSettings(tissue_gap=0.5))
    return PlanResult(plan, inputs, treatment_of(plan, inputs).result)


def test_the_report_tells_how_triangles_were_changed(in_cm: PlanResult) -> None:
    told = plan_report(in_cm).as_dict()["changes"]
    before, after = in_cm.inputs.surface.points, in_cm.treatment.points
    triangles = in_cm.inputs.surface.triangles
    moved = (before != after).any(axis=1)
    faces = triangles[moved[triangles].any(axis=1)]
    assert told["moved_points"] == moved.sum() > 100
    assert (told["moved_triangles"], told["triangles"]) == (len(faces), len(triangles))
    for when, points in (("before", before), ("after", after)):
        angles = quality(points, faces, "MinAngle")
        expected = [angles.min(), np.median(angles), angles.max()]
        assert [*told["smallest_angle_deg"][when].values()] == pytest.approx(expected, abs=1e-5)
        edges = [
            np.linalg.norm(points[faces[:, i]] - points[faces[:, i - 1]], axis=1) for i in range(3)
        ]
        expected = [np.min(edges), np.median(edges), np.max(edges)]
        assert [*told["edge_length_mm"][when].values()] == pytest.approx(expected)
    ratio = quality(after, faces, "Area") / quality(before, faces, "Area")
    expected = [ratio.min(), np.median(ratio), ratio.max()]
    assert [*told["area_ratio"].values()] == pytest.approx(expected, rel=1e-6)


def test_the_page_tells_coordinates_in_mm_and_as_the_file_has_them(in_cm: PlanResult) -> None:
    report = plan_report(in_cm)
    document = report.as_dict()
    axis = document["stents"][0]["axis"]
    for end in ("start", "end"):
        np.testing.assert_allclose(np.multiply(axis[end], 10), axis[f"{end}_mm"])
    page = html.unescape(html_page(report.sections))
    for label, name in (("Proximal", "start"), ("Distal", "end")):
        (told,) = re.findall(rf"<td>{label} end [^<]*</td><td>([^<]*)</td>", page)
        numbers = [
            float(n) for n in re.findall(r"-?[0-9]+\.[0-9]+", told.replace("\N{MINUS SIGN}", "-"))
        ]
        np.testing.assert_allclose(numbers[:3], axis[f"{name}_mm"], atol=0.051)
        np.testing.assert_allclose(numbers[3:], axis[name], atol=0.0051)
        assert " mm; in the file " in told
        assert told.endswith(" cm")
    assert len(re.findall(r"along it; [^<]* mm; in the file [^<]* cm", page)) == len(
        document["lesions"]
    )


def test_every_parameter_of_the_method_is_told_lengths_in_mm(in_cm: PlanResult) -> None:
    document = plan_report(in_cm).sections
    rows = dict(document["settings"].rows())
    assert rows["Tissue gap"] == "0.5 mm"
    assert rows["Step"] == "chosen by the rule"
    assert rows["Untangle"] == "yes"
    assert len(rows) == len(fields(DeploymentSettings)) + 1
    lengths = {
        key.removesuffix("_mm") for key in document["settings"].as_dict() if key.endswith("_mm")
    }
    assert lengths == {
        name for name, one in DeploymentSettings.parameters().items() if one.unit == "mm"
    }
    page = html_page(document)
    for name, text in rows.items():
        assert f"<td>{name}</td><td>{text}</td>" in page
