"""The report: its document, its page and its figure."""

from __future__ import annotations

import json
import math
import re
from base64 import b64decode
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import DiameterProfile
from SDFStentLib.report import Report, document_json, write_report, write_report_figure
from SDFStentLib.report.html import certificate_sentence, html_page
from SDFStentLib.report.lesions import treated_lesion_section
from SDFStentLib.report.picture.drawing import Stroke
from SDFStentLib.report.picture.plot import diameter_plot, figure
from SDFStentLib.report.report import StentResult
from SDFStentLib.report.words import millimeters, number_text
from SDFStentLib.stent import Placement
from SDFStentLib.treatment import TreatedLesion
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import Apposition, FreeStretch, HealthyPlace, Lesion, Ostium

CLEAN = {
    "passed": True,
    "sentence": "Surface certified for meshing: watertight, manifold.",
    "watertight": True,
    "manifold": True,
    "inverted_triangles": [],
    "self_intersections": {"before": 3, "after": 3, "new": 0, "triangles": []},
}


def a_profile(inscribed, wider=1.0):
    inscribed = np.array(inscribed, dtype=float)
    count = len(inscribed)
    return DiameterProfile(np.arange(count), np.zeros((count, 3)), inscribed, wider * inscribed)


def a_lesion(minimum):
    """Against 8 mm; without a section round the centerline."""
    no_wall = Surface([[0, 0, -9], [1, 0, -9], [0, 1, -9]], [[0, 1, 2]])
    return Lesion(
        branch=0,
        branch_name="branch 1",
        branch_arc_length=10.0,
        arc_length=10.0,
        start=5.0,
        end=15.0,
        point=(1.0, 2.0, 10.0),
        minimum_diameter=float(minimum),
        reference_diameter=8.0,
        percent_diameter=100 * (1 - minimum / 8),
        proximal=HealthyPlace((0.0, 0.0, 2.0), 2.0, 8.0, math.nan),
        distal=None,
        reference="healthy vessel proximal of it (8.0 mm)",
        line=Line([[0.0, 0.0, 5.0], [0.0, 0.0, 15.0]]),
        healthy=np.array([8.0, 8.0]),
        diameters=np.array([math.nan, math.nan]),
        surface=no_wall,
    )


def a_report(**changes):
    stent = StentResult(
        description={
            "device": {"name": "generic <10>"},
            "deployed_length_mm": 4.0,
            "axis": {"length_mm": 4},
        },
        before=a_profile([8, 6, 4, 6, 8]),
        after=a_profile([8.4, 8.2, 8, 8.2, 8.4], wider=1.01),
        prescribed_diameter=np.array(8.5),
        branches=(Ostium("branch <1>", np.array([1.0, 2.0, 3.0]), -2.0, 3.0, 9.0, 0.6),),
        lesions=(1,),
    )
    report = Report(
        inputs=({"file": "/data/a & b.vtp", "sha256": "0f", "points": 12000, "units": "cm"},),
        stents=(stent,),
        lesions=(treated_lesion_section(TreatedLesion(1, a_lesion(4), a_lesion(10), (1,)), "cm"),),
        certificate=CLEAN,
        warnings=("The stent was shortened.",),
        timings={"read": 0.25},
        created="2026-01-02T03:04:05Z",
        version="0.1.0",
    )
    return replace(report, **changes)


def with_gaps():
    stent = replace(
        a_report().stents[0],
        before=a_profile([math.nan, 6, 4, math.nan, 8]),
        after=a_profile([math.nan] * 5),
    )
    return a_report(stents=(stent,))


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


def test_the_document_holds_lumen_and_lesions_before_and_after():
    document = json.loads(document_json(a_report().as_dict()))
    assert (document["schema"], document["schema_version"]) == ("sdfstent-report", 1)
    assert document["notice"] == "Research use only, not a medical device."
    diameters, (lesion,) = document["diameters"], document["lesions"]
    narrowest = {"before_mm": 4.0, "before_at_mm": 2.0, "after_mm": 8.0, "after_at_mm": 2.0}
    unknown = {"beyond_before_mm": None, "beyond_after_mm": None}
    assert diameters["minimum_lumen"] == narrowest | unknown
    assert diameters["along"]["prescribed_mm"] == [8.5] * 5
    over = diameters["over_stented_length"]
    assert over["after"]["mean_mm"] == pytest.approx(8.24)
    assert over["mean_after_minus_prescribed_mm"] == pytest.approx(-0.26)
    assert lesion["percent_diameter"] == pytest.approx(50)
    assert lesion["percent_area"] is None
    assert lesion["after"]["percent_diameter"] == pytest.approx(-25)
    assert lesion["reference"]["diameter_mm"] == 8
    assert lesion["extent"] == {"start_mm": 5.0, "end_mm": 15.0, "length_mm": 10.0}
    assert lesion["place"] == pytest.approx([0.1, 0.2, 1.0])
    assert document["stents"][0]["lesions"] == [1]
    text = PageReader(html_page(document)).text
    assert "Lesion 1, diameter stenosis50 %none (25 % above reference)" in text
    assert "Lesion 1 against healthy vessel proximal of it (8.0 mm)." in text


@pytest.mark.parametrize(
    ("lesions", "covered", "words", "table"),
    [
        ("some", (), "This stent covers no lesion of 15 % or more.", True),
        ("none", (), "No lesion of 15 % or more was found.", True),
        ("unknown", None, "Lesions were not looked for", False),
    ],
)
def test_a_stent_without_a_lesion_has_no_percentage(lesions, covered, words, table):
    known = {"some": a_report().lesions, "none": (), "unknown": None}[lesions]
    stent = replace(a_report().stents[0], lesions=covered)
    page = html_page(a_report(stents=(stent,), lesions=known).as_dict())
    assert words in PageReader(page).text
    assert "Diameter stenosis" not in page
    assert ("Lesions of the vessel" in page) == table


def test_what_is_not_known_is_null_and_never_nan():
    text = document_json(with_gaps().as_dict())
    assert "NaN" not in text
    assert "Infinity" not in text
    document = json.loads(text)
    assert document["diameters"]["along"]["mis_before_mm"] == [None, 6.0, 4.0, None, 8.0]
    assert document["diameters"]["minimum_lumen"]["after_mm"] is None
    assert document["branches"][0]["lumen_before_mm"] is None


def test_profiles_at_different_stations_are_refused():
    with pytest.raises(InputError, match="after: expected the stations of the profile before"):
        StentResult({}, a_profile([1, 2, 3]), a_profile([1, 2]), np.array(5.0))
    with pytest.raises(InputError, match="prescribed_diameter: expected one number or 3"):
        StentResult({}, a_profile([1, 2, 3]), a_profile([1, 2, 3]), np.array([5.0, 6.0]))


# Files


def test_what_cannot_be_written_is_refused_and_leaves_no_file(tmp_path):
    for write, report, name, words in (
        (write_report, a_report(), "r.pdf", r"ends in \.json, \.html, \.htm, got '\.pdf'"),
        (write_report_figure, a_report(), "f.gif", r"ends in \.png, \.svg, got '\.gif'"),
        (write_report_figure, a_report(stents=()), "f.png", "at least one stent, got none"),
    ):
        with pytest.raises(InputError, match=words):
            write(report, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match=r"certificate\.faces: expected numbers.* got function"):
        a_report(certificate={"faces": lambda: 0}).as_dict()


# The page


def in_order(text, *words):
    places = [text.index(word) for word in words]
    return places == sorted(places)


def test_a_failed_certificate_and_the_warnings_stand_before_every_table():
    failed = {"passed": False, "sentence": "Not certified: the surface folds."}
    page = html_page(a_report(certificate=failed).as_dict())
    assert in_order(
        page,
        "Research use only",
        "<p class='bad'>Not certified: the surface folds.</p>",
        "<p class='warn'>The stent was shortened.</p>",
        "<table",
        "<svg",
    )
    assert page.count("Not certified") == 1
    assert certificate_sentence(failed) == (False, failed["sentence"])
    assert in_order(
        html_page(a_report().as_dict()), "<p class='warn'>", "<p class='good'>Surface", "<table"
    )


PLANNED = {
    "number": 1,
    "name": "main <3",
    "lumen_diameter_mm": 20.0,
    "nominal_length_mm": 25.0,
    "deployed_length_mm": 22.5,
    "foreshortening_fraction": 0.1,
    "placement": "AtCenter",
    "axis": {
        "start_mm": [29.62, -64.4, 63.49],
        "end_mm": [27.27, -44.68, 72.11],
        "length_mm": 22.5,
        "chord_mm": 21.65,
        "min_bend_radius_mm": 32.0,
    },
    "moved_points": 4917,
}


def planned(**changes):
    axis = {**PLANNED["axis"], **changes.pop("axis", {})}
    description = {**PLANNED, **changes, "axis": axis}
    return replace(a_report().stents[0], description=description)


def test_a_planned_stent_reads_in_words_units_and_percent():
    page = html_page(a_report(stents=(planned(),)).as_dict())
    rows = dict(re.findall(r"<tr><td>([^<]*)</td><td>([^<]*)</td></tr>", page))
    expected = {
        "Prescribed lumen diameter": "20.0 mm",
        "Nominal length": "25.0 mm",
        "Deployed length along the axis": "22.5 mm",
        "Foreshortening on expansion": "10 % of nominal length",
        "Placed": "by its middle",
        "Proximal end (x, y, z)": "29.6, \N{MINUS SIGN}64.4, 63.5 mm; "
        "in the file 2.96, \N{MINUS SIGN}6.44, 6.35 cm",
        "Straight distance of its ends": "21.6 mm",
        "Tightest bend of its axis": "radius 32.0 mm, of the circle through three points of the "
        "axis that are 10.0 mm apart (the stent radius)",
        "Surface points that it moved": "4\N{THIN SPACE}917",
    }
    assert {name: rows.get(name) for name in expected} == expected
    for raw in ("AtCenter", "fraction", "min bend", "moved points", "_"):
        assert raw not in "".join([*rows, *rows.values()])


@pytest.mark.parametrize("placement", [kind.__name__ for kind in Placement.__args__])
def test_every_placement_has_words(placement):
    page = html_page(a_report(stents=(planned(placement=placement),)).as_dict())
    assert placement not in page
    assert "<td>Placed</td>" in page


def test_the_bend_names_the_window_in_use():
    for axis, words in (
        ({"min_bend_radius_mm": math.inf}, "none, the axis is straight"),
        # A stent shorter than its diameter: the window ends at half of its length.
        ({"length_mm": 8.0}, "4.0 mm apart (half of its length)"),
    ):
        text = PageReader(html_page(a_report(stents=(planned(axis=axis),)).as_dict())).text
        assert words in text


def test_a_zero_has_no_sign():
    assert number_text(-0.04, 1) == "0.0"
    assert number_text(-0.06, 1) == "\N{MINUS SIGN}0.1"
    assert millimeters(0.004, signed=True) == "0.00 mm"
    assert millimeters(0.006, signed=True) == "+0.01 mm"
    assert millimeters(None) == number_text(None, 1) == "not known"


def test_headings_name_the_stent_and_its_number_in_the_plan():
    def headings(*stents):
        return re.findall(r"<h2>(Stent[^<]*)</h2>", html_page(a_report(stents=stents).as_dict()))

    assert headings(planned(), planned(number=2, name="")) == [
        "Stent 1 of 2: main &lt;3, lumen before and after",
        "Stent 2 of 2, lumen before and after",
        "Stent 1 of 2: main &lt;3, as planned",
        "Stent 2 of 2, as planned",
    ]
    assert headings(planned())[1] == "Stent: main &lt;3, as planned"
    assert headings(planned(number=2))[1] == "Stent 2 of the plan: main &lt;3, as planned"
    document = a_report(stents=(planned(number=2),)).as_dict()
    assert [branch["stent"] for branch in document["branches"]] == [2]


def test_the_page_is_well_formed_loads_nothing_escapes_names_and_tells_files_in_words():
    entry = {"role": "surface", "file": "a & b.vtp", "sha256": "0f", "triangles": 12000}
    page = html_page(a_report(inputs=({**entry, "frame": None},)).as_dict())
    reader = PageReader(page)
    assert reader.loads == reader.open == []
    assert "<h3>Surface</h3>" in page
    for words in (
        *("generic <10>", "a & b.vtp", "SHA-2560f", "Triangles12\N{THIN SPACE}000"),
        "Framenot said by the file",
    ):
        assert words in reader.text


def test_a_page_without_any_diameter_or_stent_still_says_so():
    text = PageReader(html_page(with_gaps().as_dict())).text
    assert "not known" in text
    assert "nan" not in text.lower()
    bare = PageReader(html_page(a_report(stents=(), certificate=None, warnings=()).as_dict()))
    assert "was not checked" in bare.text


# The plot


def test_the_curves_of_the_plot_are_the_measured_diameters():
    diameters = a_report().as_dict()["diameters"]
    marks = diameter_plot(diameters).marks
    # Grid and legend are straight; a curve has a corner per station.
    lines = [mark for mark in marks if isinstance(mark, Stroke) and len(mark.points) == 5]
    assert len(lines) == 5
    heights = np.array([[y for _, y in line.points] for line in lines])
    drawn = ("equivalent_before", "equivalent_after", "mis_before", "mis_after", "prescribed")
    expected = np.array([diameters["along"][f"{key}_mm"] for key in drawn])
    slope, floor = np.polyfit(expected.ravel(), heights.ravel(), 1)
    np.testing.assert_allclose(heights, floor + slope * expected, atol=1e-9)
    assert slope < 0, "larger diameters are drawn higher"


def around(profile, beyond=3):
    """The profile with stations on both sides, which are two millimeters wider."""
    at = profile.arc_length
    outside = profile.inscribed_diameter[[0, -1]] + 2.0
    inscribed = np.r_[np.full(beyond, outside[0]), profile.inscribed_diameter]
    inscribed = np.r_[inscribed, np.full(beyond, outside[1])]
    positions = np.r_[at[0] - np.arange(beyond, 0, -1), at, at[-1] + np.arange(1, beyond + 1)]
    return DiameterProfile(positions, np.zeros((len(positions), 3)), inscribed, inscribed)


def with_surroundings():
    stent = a_report().stents[0]
    free = Apposition(np.arange(4) + 0.5, np.array([1, 1, 0, 0]), (FreeStretch(0, 2, 1, 0.5),), 4.0)
    before, after = around(stent.before), around(stent.after)
    whole = replace(stent, around_before=before, around_after=after, apposition=free)
    return a_report(stents=(whole,))


def test_curves_go_on_beyond_the_stent_and_numbers_do_not():
    plain, whole = (made.as_dict()["diameters"] for made in (a_report(), with_surroundings()))
    along = whole.pop("along")
    assert along["arc_length_mm"] == list(range(-3, 8))
    assert along["mis_before_mm"] == [10, 10, 10, 8, 6, 4, 6, 8, 10, 10, 10]
    assert along["prescribed_mm"] == 3 * [None] + 5 * [8.5] + 3 * [None]
    plain.pop("along")
    beyond = [
        [made["minimum_lumen"].pop(f"beyond_{when}_mm") for when in ("before", "after")]
        for made in (whole, plain)
    ]
    assert beyond == [[8 + 2, 8.4 + 2], [None, None]]
    assert whole == plain
    assert whole["stent_ends_mm"] == [0, 4]


def test_a_curve_is_interrupted_where_nothing_was_measured():
    marks = diameter_plot(with_gaps().as_dict()["diameters"]).marks
    colored = [mark for mark in marks if getattr(mark, "color", "") in ("#b35806", "#111111")]
    lines = [mark for mark in colored if isinstance(mark, Stroke)]
    curves = [line for line in lines if line.points[0][1] > 62]  # below the legend
    # Before, both diameters: the run of two stations; a single station makes no line.
    assert [len(line.points) for line in curves] == [2, 2, 5]


# The figure and the picture


def test_the_figure_is_the_same_drawing_in_both_formats(tmp_path):
    two = a_report(stents=(planned(name="main <3\x1b\ud800"), with_gaps().stents[0]))
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


@pytest.mark.parametrize("zone", ["Z", "+00:00"])
def test_the_time_of_a_report_reads_without_letters_of_a_computer(zone):
    document = a_report(created=f"2026-01-02T03:04:05{zone}").as_dict()
    assert "2026-01-02 03:04:05 UTC" in html_page(document)
    assert document["created"] == f"2026-01-02T03:04:05{zone}"


def test_the_clinicians_part_comes_first_and_what_is_to_be_checked_last():
    png = b"\x89PNG\r\n\x1a\n"
    page = html_page(a_report(stents=(planned(),)).as_dict(), png)
    assert in_order(
        page,
        "<h2>Warnings",
        "<p class='good'>Surface certified",
        "<img",
        "<h2>Lesions of the vessel",
        "lumen before and after</h2>",
        "Stent of 20.0 mm x 22.5 mm (packed 25.0 mm, 10 % shorter once expanded), placed by",
        "<svg",
        "<div class='details'>",
        ", as planned</h2>",
        "<h2>Input files",
        "SHA-256",
        "Time:",
        "<h2>Definitions",
    )
    assert re.search(r"\.details\{break-before:page\}", page)


def test_the_page_holds_the_picture_or_says_why_there_is_none(tmp_path):
    png = b"\x89PNG\r\n" + bytes(range(256))
    write_report(a_report(picture=png), tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text("utf-8")
    assert PageReader(page).loads == ["img", "src"]
    (data,) = re.findall(r"src='data:image/png;base64,([^']*)'", page)
    assert b64decode(data, validate=True) == png
    assert in_order(page, "The stent was shortened.", "<img", "<table")
    without = html_page(a_report().as_dict(), "No <OpenGL>.")
    assert PageReader(without).loads == []
    assert "no picture of the vessel. No <OpenGL>." in PageReader(without).text
    assert "picture" not in html_page(a_report().as_dict())
    assert json.loads(document_json(a_report(picture=png).as_dict())) == a_report().as_dict()
