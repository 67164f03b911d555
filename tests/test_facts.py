"""Facts: a quantity that is listed once is told everywhere."""

import math
from html import unescape

import numpy as np
import pytest

from SDFStentLib.cautions import Caution
from SDFStentLib.plan import Alternative, PlanComparison, PlanResult
from SDFStentLib.report import (
    Tile,
    comparison_document,
    comparison_page,
    deployment_sentences,
    deployment_summary,
    measured_lines,
    plan_report,
    result_tiles,
    stent_rows,
    stents,
    summary,
)
from SDFStentLib.report.facts import COMPARED, DETAILS, GLANCE, LINES, Fact, Facts, size, width
from SDFStentLib.report.html import html_page


def told_everywhere(result: PlanResult) -> dict[str, object]:
    """What every door tells of a result."""
    (stent,), lesions = result.told.stents, result.lesions
    report = plan_report(result)
    both = PlanComparison(tuple(Alternative(name, result.plan, result) for name in "ab"))
    certificate = result.treatment.certificate
    return {
        "document": report.as_dict()["stents"][0]["diameters"],
        "page": unescape(html_page(report.sections)),
        "short": deployment_summary(result).results,
        "verbose": [*deployment_sentences(result)],
        "table": stent_rows(result.told)[0],
        "tiles": result_tiles([stent], lesions, certificate),
        "at hand": measured_lines(stent, [stent], lesions, certificate),
        "side by side": comparison_page(comparison_document(both), "No picture."),
    }


def test_a_number_that_is_listed_once_is_told_at_every_door(result, monkeypatch):
    before = told_everywhere(result)
    known = stents.lumen_facts

    def with_one_more(treated):
        yield from known(treated)
        key, column = "diameters.trial.{}_mm", "trial_{}_mm"
        yield width(key, "Trial number", 1.234, 5.678, level=GLANCE, column=column)

    monkeypatch.setattr(stents, "lumen_facts", with_one_more)
    told = told_everywhere(result)
    assert told["document"]["trial"] == {"before_mm": 1.234, "after_mm": 5.678}
    row = "<td>Trial number</td><td class='n'>1.23 mm</td><td class='n'>5.68 mm</td>"
    assert row in told["page"]
    assert "Trial number: 1.23 -> 5.68 mm." in told["short"]
    assert "Stent 1 (main <3): Trial number: 1.23 -> 5.68 mm." in told["verbose"]
    assert (told["table"]["trial_before_mm"], told["table"]["trial_after_mm"]) == (1.234, 5.678)
    assert Tile("Trial number", "5.7 mm", "before 1.2 mm") in told["tiles"]
    assert "Trial number 1.2 -> 5.7 mm" in told["at hand"]
    assert told["side by side"].count("<p>5.68 mm (before 1.23 mm)</p>") == 2
    for door in ("short", "verbose", "tiles", "at hand"):  # and nothing else
        assert len(told[door]) == len(before[door]) + 1


@pytest.mark.parametrize(
    ("within", "beneath"),
    [((3.94, 4.22), "(3.9-4.2) before 2.0 mm"), ((4.01, 3.99), "before 2.0 mm")],
)
def test_a_range_of_one_number_is_none(within, beneath):
    fact = Fact(before=2.0, after=4.0, unit="mm", level=GLANCE, tile="Trial", within=within)
    assert fact.tiled.beneath == beneath


@pytest.mark.parametrize(
    ("within", "beneath"),
    [
        ((-1.2, 4.8), "(none-5 %) before 62 %"),
        ((7.6, 17.4), "(8-17 %) before 62 %"),
        ((-3.0, 0.4), "before 62 %"),
    ],
)
def test_a_range_of_a_stenosis_says_none_where_there_is_none(within, beneath):
    words = {"tile": "Stenosis left", "few": "none", "beneath": "before 62 %"}
    assert Fact(after=0.0, unit="%", level=GLANCE, within=within, **words).tiled.beneath == beneath


def test_what_came_of_all_stents_is_listed_once(result, monkeypatch):
    """For the lines of the shell, the tiles and the lines beside a stent."""
    before = told_everywhere(result)
    words = {"words": "At length.", "few": "brief", "hand": "beside", "beneath": "below"}
    trial = Fact(after=1.0, level=GLANCE, tile="Trial", **words)
    known = summary.contact_fact
    monkeypatch.setattr(summary, "contact_fact", lambda stents: [*known(stents), trial])
    told = told_everywhere(result)
    assert [one for one in told["short"] if one not in before["short"]] == ["At length."]
    (tile,) = (one for one in told["tiles"] if one not in before["tiles"])
    assert tile == Tile("Trial", "brief", "below")
    assert [one for one in told["at hand"] if one not in before["at hand"]] == ["beside"]


def test_a_number_of_details_is_told_in_report_and_table_only(result, monkeypatch):
    known = stents.lumen_facts
    fact = size("trial_mm", "Trial number", 1.234, level=DETAILS, column="trial_mm")
    monkeypatch.setattr(stents, "lumen_facts", lambda treated: [*known(treated), fact])
    told = told_everywhere(result)
    assert "<td>Trial number</td><td>1.23 mm</td>" in told["page"]
    assert told["table"]["trial_mm"] == 1.234
    shown = {door: "Trial number" in str(told[door]) for door in told}
    assert [door for door, is_shown in shown.items() if is_shown] == ["page"]


def test_a_value_that_treatment_does_not_change_can_be_told_at_a_glance(result, monkeypatch):
    known = stents.lumen_facts
    fact = size("trial_mm", "Trial number", 1.234, level=GLANCE, column="trial_mm")
    monkeypatch.setattr(stents, "lumen_facts", lambda treated: [*known(treated), fact])
    told = told_everywhere(result)
    assert "<td>Trial number</td><td>1.23 mm</td>" in told["page"]
    assert "Trial number: 1.23 mm." in told["short"]
    assert "Stent 1 (main <3): Trial number: 1.23 mm." in told["verbose"]
    assert Tile("Trial number", "1.2 mm", "") in told["tiles"]
    assert "Trial number 1.2 mm" in told["at hand"]
    assert told["side by side"].count("<p>1.23 mm</p>") == 2


def test_of_several_stents_a_tile_has_the_worst(result, monkeypatch):
    known = stents.lumen_facts
    (stent,) = result.told.stents

    def tile(values, worst):
        left = iter(values)

        def told(treated):
            return [*known(treated), width("", "Trial", 1.0, next(left), level=GLANCE, worst=worst)]

        monkeypatch.setattr(stents, "lumen_facts", told)
        tiles = result_tiles([stent] * len(values), None, None)
        return next(one.value for one in tiles if one.name == "Trial")

    assert tile([3.0, 2.0, 4.0], min) == "2.0 mm"
    assert tile([3.0, 2.0, 4.0], max) == "4.0 mm"
    assert tile([3.0, math.nan, 4.0], max) == "not known mm"


def test_the_words_of_a_fact_are_its_numbers(result):
    """As texts are read back, apart from the facts' own formatting."""
    sections = plan_report(result).sections
    every = [*sections["stents"], *sections["lesions"], *sections["branches"]]
    told = [
        (words, value)
        for facts in every
        for one in facts
        for words, value in ((one.was, one.before), (one.words, one.after))
        if one.unit == "mm" and words
    ]
    assert len(told) > 15
    for words, value in told:
        assert float(words.split()[0]) == pytest.approx(value, abs=0.051)
        assert words.endswith(" mm")


def test_a_table_has_the_numbers_of_the_document(result):
    (row,), document = stent_rows(result.told), plan_report(result).as_dict()["stents"][0]
    lumen, over = (document["diameters"][key] for key in ("minimum_lumen", "over_stented_length"))
    for when in ("before", "after"):
        assert row[f"lumen_{when}_mm"] == lumen[f"{when}_mm"]
        assert row[f"mean_lumen_{when}_mm"] == over[when]["mean_mm"]
    for end in ("start", "end"):
        assert [row[f"{end}_{axis}_mm"] for axis in "xyz"] == document["axis"][f"{end}_mm"]
    assert row["length_mm"] == document["nominal_length_mm"] == 20.0
    assert (row["diameter_mm"], row["stent"], row["certified"]) == (6.5, 1, True)


def test_views_of_facts():
    facts = Facts(
        (
            width("lumen.{}_mm", "Lumen", 3.0, 6.0, level=GLANCE, note=", wanted", column="w_{}"),
            size("a.b_mm", "Size", 2.0, level=COMPARED, column="b"),
            size("a.c_mm", "None", None),
            Fact("a.place_mm", after=np.array([1.0, 2.0, 3.0]), column="{}_mm"),
            Fact(words="A sentence.", level=LINES),
            Fact("_hidden", "Hidden", words="words"),
        )
    )
    document = facts.as_dict()
    assert document["lumen"] == {"before_mm": 3.0, "after_mm": 6.0}
    assert (document["a"]["b_mm"], document["a"]["c_mm"]) == (2.0, None)
    assert document["a"]["place_mm"].tolist() == [1.0, 2.0, 3.0]
    assert [*document] == ["lumen", "a"]
    table = {"w_before": 3.0, "w_after": 6.0, "b": 2.0, "x_mm": 1.0, "y_mm": 2.0, "z_mm": 3.0}
    assert facts.columns() == table
    assert facts.rows() == [("Size", "2.00 mm"), ("Hidden", "words")]
    assert facts.changes() == [("Lumen", "3.00 mm", "6.00 mm")]
    assert [str(one) for one in facts.at(COMPARED)] == [
        "Lumen: 3.00 -> 6.00 mm, wanted",
        "Size: 2.00 mm",
    ]
    assert facts.at(LINES)[-1].words == "A sentence."
    assert str(width("", "Lumen", 3.0, math.nan)) == "Lumen: 3.00 mm -> not known"
    assert str(width("", "Lumen", math.nan, 3.0)) == "Lumen: not known -> 3.00 mm"


def test_a_danger_to_the_vessel_is_told_before_what_the_mesh_lacks(result):
    """Six times too wide is graver than 2.9 % too narrow; and "narrower" alone says nothing."""
    (stent,), certificate = result.told.stents, result.treatment.certificate
    narrower = Caution(
        "narrower", {"percent": 2.9, "found_mm": 8.16, "prescribed_mm": 8.4}, (0.0, 0.0, 0.0)
    )
    wide = {"stent_diameter_mm": 8.4, "times": 6.0, "healthy_mm": 1.4, "where": "at its end"}
    both = [narrower, Caution("overdilated", wide)]
    lines = measured_lines(stent, [stent], result.lesions, certificate, both)
    assert "warning: overdilated 6.0 x, 1 more" in lines
    lines = measured_lines(stent, [stent], result.lesions, certificate, [narrower])
    assert "warning: 3 % narrower than prescribed" in lines
