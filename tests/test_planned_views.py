"""What an angiographer will see of a plan: in its report, page and angiogram."""

import re
from dataclasses import replace
from html import unescape

import pytest

from SDFStentLib.plan import (
    Alternative,
    PlanComparison,
    PlanResult,
    run_plan,
)
from SDFStentLib.plan.document import plan_document
from SDFStentLib.plan.reader import plan_from_document
from SDFStentLib.report import (
    comparison_document,
    comparison_page,
    plan_report,
    planned_views,
    write_angiogram,
)
from SDFStentLib.report.html import html_page
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.validation import InputError
from SDFStentLib.view import ViewWishes


def framed(result: PlanResult, frame="LPS") -> PlanResult:
    """The same, had the file said its frame."""
    return replace(result, inputs=replace(result.inputs, frame=frame))


@pytest.fixture(scope="module")
def report(result):
    return plan_report(framed(result))


def test_a_report_tells_the_views_of_a_stent_along_the_body(report):
    """Along z, 18 mm of it deployed: whole in every view from the side, one of which is best."""
    told = report.as_dict()["views"]
    assert (told["frame"], told["reason"]) == ("LPS", None)
    assert told["limits"] == {"lao_rao_deg": 110, "cra_cau_deg": 50, "table": []}
    (stent,) = told["stents"]
    assert (stent["stent"], stent["length_mm"]) == (1, pytest.approx(18))
    best, second, worst = stent["views"]
    assert [one["role"] for one in stent["views"]] == ["best view", "second view", "worst view"]
    assert (best["lao_deg"], best["cra_deg"]) == (0, 0)
    assert best["projected_length_mm"] == pytest.approx(18)
    assert abs(second["lao_deg"]) >= 60
    assert worst["cra_deg"] in (-50, 50)
    assert best["stenosis"]["before"]["percent"] == pytest.approx(40, abs=1)
    assert best["stenosis"]["before"]["in_3d_percent"] == pytest.approx(40, abs=1)
    assert best["stenosis"]["after"]["percent"] < 1


def test_a_page_shows_the_best_view_before_and_after_and_the_map_of_all(report):
    page = html_page(report.sections)
    part = page[page.index("<h2>Working views</h2>") :]
    assert "Best view LAO 0, CRA 0: foreshortened 0 %, nothing over it, 18.0 of 18.0 mm" in part
    seen, mapped = re.findall(r"<svg.*?</svg>", part, re.S)[:2]
    assert seen.count("<image") == 2
    assert seen.index(">before<") < seen.index(">after<")
    assert "lines: foreshortened 10 %, 20 %, 40 %" in mapped
    assert [mapped.count(f">{name}<") for name in "12x"] == [2, 2, 2]  # each with its halo
    heads = re.findall("<th>(.*?)</th>", part)
    assert heads[:4] == ["View", "Angles", "Foreshortened", "Under other vessels"]


def test_struts_are_left_out_where_the_device_is_hidden(result):
    shown, hidden = (
        next(planned_views(framed(result), hides_device=hides).stents[0].drawings())[1]
        for hides in (False, True)
    )
    assert len(shown.marks) > len(hidden.marks) + 50


def test_without_a_frame_no_angle_is_told_and_the_reason_is(result):
    report = plan_report(result)
    told = report.as_dict()["views"]
    assert told["stents"] == []
    assert "RAS or LPS" in told["reason"]
    page = unescape(html_page(report.sections))
    assert f"<p class='small'>Not told: {told['reason']}</p>" in page
    assert "LAO" not in page


def test_without_a_centerline_nobody_knows_what_lies_in_the_way(result):
    bare = replace(result.inputs, vessel=replace(result.vessel, centerline=None))
    told = plan_report(framed(replace(result, inputs=bare))).as_dict()["views"]
    assert told["stents"] == []
    assert "centerline" in told["reason"]


def test_each_stent_of_a_plan_has_its_own_views(result, tmp_path):
    (first,) = result.plan.stents
    second = Stent(6.2, placement=AtCenter([0, 0, 30.0]), length=8.0)
    both = framed(run_plan(replace(result.plan, stents=(first, second))))
    told = plan_report(both)
    assert [one["stent"] for one in told.as_dict()["views"]["stents"]] == [1, 2]
    page = html_page(told.sections)
    assert "<h2>Working views of stent 1</h2>" in page
    assert "<h2>Working views of stent 2</h2>" in page
    write_angiogram(both, tmp_path / "both.svg")
    drawn = (tmp_path / "both.svg").read_text(encoding="utf-8")
    assert drawn.count("<image") == 4


def compared(*results):
    plans = (Alternative(name, one.plan, one) for name, one in zip("abc", results, strict=False))
    return unescape(comparison_page(comparison_document(PlanComparison(tuple(plans))), "None."))


def test_compared_plans_have_a_column_of_views_each(result):
    page = compared(framed(result), result)
    row = page[page.index("<b>Best view</b>") :].split("</tr>")[0]
    assert "<p>LAO 0, CRA 0: foreshortened 0 %, nothing over it; 18.0 of 18.0 mm long, " in row
    assert "<p>not told</p>" in row
    assert "<b>Second view</b>" in page
    assert "Worst view" not in page
    silent = compared(result, result)
    assert "<b>Working views</b>" in silent
    assert "RAS or LPS" in silent


def test_a_plan_says_how_the_arm_turns_and_from_where_else_it_is_looked(result):
    wishes = ViewWishes(lao_rao=40.0, apart=20.0, lao=30.0, cra=-20.0, table=((-90, 40, 30),))
    plan = replace(result.plan, views=wishes)
    assert plan_from_document(plan_document(plan)) == plan
    usual = replace(plan, views=replace(wishes, table=()))
    report = plan_report(framed(replace(result, plan=usual)))
    told = report.as_dict()["views"]
    assert told["limits"] == {"lao_rao_deg": 40, "cra_cau_deg": 50, "table": []}
    *found, typed = told["stents"][0]["views"]
    assert all(abs(one["lao_deg"]) <= 40 for one in found)
    assert (typed["role"], typed["words"]) == ("view", "LAO 30, CAU 20")
    assert typed["foreshortening_percent"] == pytest.approx(6.03, abs=0.01)  # 1 - cos 20
    page = html_page(report.sections)
    assert page.count("<image") == 4
    assert "View LAO 30, CAU 20: foreshortened 6 %, nothing over it" in page


@pytest.mark.parametrize(
    ("views", "words"),
    [
        ({"lao": 10}, "both angles"),
        ({"lao_rao": 190}, "LAO/RAO"),
        ({"table": [[0, 10]]}, "LAO, CRA and CAU"),
        ({"table": [[0, 10, 10], [0, 10, 10]]}, "growing LAO"),
        ({"lai": 10}, "unknown key 'lai'"),
    ],
)
def test_wishes_that_no_arm_can_fulfil_are_refused_with_their_place(result, views, words):
    document = {**plan_document(result.plan), "views": views}
    with pytest.raises(InputError, match=f"views.*{words}"):
        plan_from_document(document)
