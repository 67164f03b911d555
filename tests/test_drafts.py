"""Stents as they are edited: what follows from setting a value, and lists of them as plans."""

import math
from dataclasses import replace

import numpy as np
import pytest

from SDFStentLib.flow import Known
from SDFStentLib.plan import (
    NEW_STENT,
    Draft,
    Plan,
    earlier_of,
    in_lumen,
    inflated,
    numbers_again,
    parameter_at,
    rows_from,
    rows_of,
    set_value,
    stent_entry,
    stents_of,
    value_in_use,
    with_device,
    with_value,
)
from SDFStentLib.stent import (
    AlongAxis,
    AtCenter,
    AtLesion,
    Balloon,
    BetweenPoints,
    Device,
    OfStent,
    OnBranch,
    Shape,
    Stent,
    balloon_by_rule,
)
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import VesselName


def changed(draft, changes):
    entry = draft.entry
    for path, value in changes.items():
        entry = with_value(entry, path, value)
    return Draft(entry)


def put(draft, path, value):
    return changed(draft, set_value(draft, path, value))


def test_a_new_stent_is_one():
    assert Draft({}).at({"center": [1.0, 2.0, 3.0]}) == Stent(
        8.0,
        length=20.0,
        foreshortening_fraction=0.1,
        name="Stent",
        placement=AtCenter(np.array([1.0, 2.0, 3.0])),
    )
    assert Draft({}).refusal is None


@pytest.mark.parametrize("seed", range(20))
def test_a_balloon_leaves_its_lumen_whatever_is_set_last(seed):
    """By its definition: what is left of the balloon after recoil."""
    random = np.random.default_rng(seed)
    draft = put(Draft({}), "balloon", True)
    for _step in range(12):
        path = random.choice(["diameter", "balloon.diameter", "balloon.recoil_fraction", "rule"])
        if path == "rule":
            draft = put(draft, "balloon.by_rule", bool(random.integers(2)))
        elif path == "balloon.recoil_fraction":
            draft = put(draft, path, float(random.uniform(0.0, 0.3)))
        else:
            draft = put(draft, path, float(random.uniform(4.0, 20.0)))
        if value_in_use(draft, "balloon.by_rule"):
            draft = changed(draft, in_lumen(draft, float(random.uniform(2.0, 8.0))))
        stent = draft.at({"center": np.zeros(3)})
        balloon = stent.balloon
        assert stent.diameter == pytest.approx(balloon.diameter * (1 - balloon.recoil_fraction))
        shown = [value_in_use(draft, f"balloon.{one}") for one in ("diameter", "recoil_fraction")]
        assert shown == [balloon.diameter, balloon.recoil_fraction]


def test_the_last_of_balloon_and_lumen_stays_when_the_rule_is_applied():
    by_balloon = put(put(Draft({}), "balloon", True), "balloon.diameter", 9.0)
    assert in_lumen(by_balloon, 5.0) == changed_by(balloon_by_rule(9.0, 5.0))
    found = changed(by_balloon, in_lumen(by_balloon, 2.0))
    assert (found.balloon.diameter, found.balloon.recoil_fraction) == (9.0, 0.10)
    by_lumen = put(by_balloon, "diameter", 9.0)
    found = changed(by_lumen, in_lumen(by_lumen, 2.0))
    assert found.entry["diameter"] == 9.0
    assert found.balloon.diameter == pytest.approx(10.0)  # 9 / 0.9
    assert in_lumen(found, 2.0) == {}


@pytest.mark.parametrize("native", [2.0, 5.0, 9.0])
def test_a_balloon_that_is_switched_on_leaves_the_lumen_that_was_there(native):
    """It lost three percent each time that it was switched on where the rule raised the recoil."""
    draft = put(Draft({}), "diameter", 6.6)
    for _time in range(3):
        draft = put(draft, "balloon", True)
        for _measured in range(2):
            draft = changed(draft, in_lumen(draft, native))
        recoil = balloon_by_rule(6.6, native).recoil_fraction
        assert draft.at(None).diameter == 6.6
        assert value_in_use(draft, "balloon.diameter") == pytest.approx(6.6 / (1 - recoil))
        assert value_in_use(draft, "balloon.recoil_fraction") == recoil
        assert value_in_use(draft, "balloon.by_rule")
        draft = put(draft, "balloon", False)
        assert draft.entry["diameter"] == 6.6


def changed_by(balloon):
    document = {"diameter": 9.0, "recoil_fraction": balloon.recoil_fraction}
    return {"balloon": {**document, "reason": balloon.reason}, "diameter": balloon.lumen_diameter}


def test_a_recoil_that_was_given_is_no_matter_of_the_rule():
    draft = put(changed(Draft({}), inflated(Draft({}), 9.0, 0.2)), "balloon.diameter", 10.0)
    assert draft.balloon == Balloon(10.0, 0.2)
    assert put(draft, "balloon.by_rule", True).balloon == balloon_by_rule(10.0, math.nan)
    assert put(draft, "balloon", False).balloon is None


def test_a_device_lends_its_length_and_gives_it_back():
    device = Device("own", nominal_length=16.0, foreshortening_fraction=0.2, source="a bench")
    draft = changed(Draft({}), with_device(Draft({}), device))
    assert (draft.length, draft.foreshortening) == (16.0, 0.2)
    assert not draft.has_free_length
    by_hand = put(draft, "foreshortening_fraction", 0.3)
    assert (by_hand.foreshortening, by_hand.entry["device_shortening"]) == (0.3, False)
    assert changed(draft, with_device(draft, None)).at(None) == Draft({}).at(None)


def test_caps_and_a_table_of_a_shape():
    flat = put(Draft({}), "shape.cap_height", 0.35)
    assert flat.shape == Shape(cap_height=0.35)
    assert put(flat, "shape.cap_height", 1.0).shape is None
    table = put(flat, "shape.table", ((0.0, 6.0), (1.0, 9.0)))
    assert (table.entry["diameter"], table.shape.cap_height) == (9.0, 0.35)
    narrower = put(table, "diameter", 4.5)
    assert narrower.shape.table == ((0.0, 3.0), (1.0, 4.5))
    assert put(table, "shape.table", ()).shape == Shape(cap_height=0.35)


PLACES = [
    AtCenter(np.array([1.0, 2.0, 3.0])),
    BetweenPoints(np.zeros(3), np.array([0.0, 0.0, 9.0])),
    AlongAxis(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 8.0], [0.0, 0.0, 20.0]])),
    AtLesion(2, 1.5),
    OnBranch("LPA", fraction=0.5),
]


def in_words(placement, row):
    """The place of a row, its points filled in."""
    place = row.entry["placement"]
    if isinstance(placement, AlongAxis):
        return {"axis": {"points": row.points}}
    return dict(zip(place, row.points, strict=True)) if row.points else place


@pytest.mark.parametrize("placement", PLACES, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("is_on", [True, False])
def test_a_stent_of_a_plan_is_edited_and_the_same_again(placement, is_on):
    length = None if isinstance(placement, BetweenPoints | AlongAxis) else 15.0
    lost = None if length else 0.0
    stent = Stent(7.0, placement=placement, length=length, foreshortening_fraction=lost)
    stent = replace(stent, name="one", enabled=is_on)
    (row,) = rows_from([stent])
    (again,) = stents_of([Draft(row.entry)], [in_words(placement, row)])
    assert replace(again, foreshortening_fraction=lost) == stent
    assert again.foreshortening == stent.foreshortening


def test_stents_that_are_dilated_again_are_rows_of_their_own_unless_at_once():
    first = Stent(7.0, placement=PLACES[0], length=15.0, name="a")
    at_once = Stent(8.0, placement=OfStent(1), name="a, dilated again")
    later = Stent(9.0, placement=OfStent(2), name="b")
    rows = rows_from([first, at_once, later])
    assert [(row.redilation, row.original) for row in rows] == [(8.0, None), (None, 0)]
    drafts = [Draft(row.entry) for row in rows]
    assert numbers_again(drafts, ["here", "here"]) == [None, 2]
    assert numbers_again(drafts, ["here", "there"]) == [None, None]
    assert earlier_of(drafts, ["here", "here"], 1) is drafts[0]
    assert earlier_of(drafts, ["here", "here"], 0) is None
    assert rows_of(drafts) == [1, 1, 2]
    found = stents_of(drafts, [{"center": [1.0, 2.0, 3.0]}, {"stent": 2}])
    assert [one.placement for one in found[1:]] == [OfStent(1), OfStent(2)]
    assert [one.diameter for one in found] == [7.0, 8.0, 9.0]
    with pytest.raises(InputError, match="stent 1: expected a stent above it to dilate again"):
        rows_from([later])


def test_one_that_is_off_and_cannot_be_is_there_by_its_name_or_refused():
    entry = {**stent_entry(Stent(12.0, length=15.0)), "keeps": "proximal", "name": "off"}
    draft = Draft({**entry, "enabled": False, "placement": {"distal": None}})
    assert "expected its distal end to be kept" in str(draft.refusal)
    assert stents_of([draft], [None], has_named=True) == [Stent(12.0, name="off", enabled=False)]
    smaller = Draft({**NEW_STENT, "enabled": False, "redilation": 5.0})
    with pytest.raises(InputError, match="expected more than the 8 mm of stent 1, got 5 mm"):
        stents_of([smaller], [None])


def test_a_parameter_is_found_by_the_path_of_its_value():
    assert parameter_at("stents.keeps").names == ("center", "proximal", "distal")
    assert parameter_at("stents.balloon.diameter").unit == "mm"
    assert parameter_at("settings.straightening_fraction").most == 1.0
    assert parameter_at("flow.bsa").unit == "m2"


def test_a_plan_is_the_same_in_the_other_frame_with_x_and_y_the_other_way():
    place, known = (1.0, 2.0, 3.0), Known(80.0, right=(4.0, 5.0, 6.0))
    how = {"root": place, "reference": (place,), "names": (VesselName("LPA", place),)}
    plan = Plan(stents=(Stent(8.0, placement=AtCenter(place), length=9.0),), flow=known, **how)
    ras = plan.in_frame("RAS")
    assert (ras.stents, ras.flow, ras.marks.names) == (plan.stents, known, plan.names)
    lps = ras.in_frame("LPS")
    assert (lps.frame, lps.root, lps.reference) == ("LPS", (-1.0, -2.0, 3.0), ((-1.0, -2.0, 3.0),))
    assert (lps.flow.right, lps.names[0].at) == ((-4.0, -5.0, 6.0), (-1.0, -2.0, 3.0))
    assert lps.stents[0].placement == AtCenter((-1.0, -2.0, 3.0))
    assert lps.in_frame("RAS") == ras
    assert Plan(frame="LPS").marked(ras.marks).names == lps.names
    assert ras.of_files("a.vtp", None).centerline is None
