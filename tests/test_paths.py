"""Values of a document by their paths, and stents as the entries of one."""

import json

import pytest

from SDFStentLib.plan import entry_words, stent_entry, stent_of, value_at, with_value
from SDFStentLib.stent import AtCenter, Balloon, Device, Shape, Stent, StentEnd, Waist
from SDFStentLib.validation import InputError

DOCUMENT = {"stents": [{"diameter": 8.0}, {"diameter": 9.0, "shape": None}], "flow": None}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("stents.1.diameter", 9.0),
        ("stents.1.shape", None),
        ("stents.1.shape.waist", "none"),
        ("stents.2.diameter", "none"),
        ("stents.-1.diameter", "none"),
        ("stents.one", "none"),
        ("flow.mean", "none"),
        ("stents.0.diameter.more", "none"),
    ],
)
def test_a_value_is_got_by_its_path(path, value):
    assert value_at(DOCUMENT, path, "none") == value


def test_setting_a_value_makes_what_is_missing_and_leaves_the_document():
    before = json.dumps(DOCUMENT)
    found = with_value(DOCUMENT, "stents.1.shape.waist.diameter", 6.0)
    assert found["stents"][1] == {"diameter": 9.0, "shape": {"waist": {"diameter": 6.0}}}
    assert found["stents"][0] is DOCUMENT["stents"][0]
    assert with_value(DOCUMENT, "flow.mean", 80.0)["flow"] == {"mean": 80.0}
    assert json.dumps(DOCUMENT) == before
    with pytest.raises(IndexError, match="got 2"):
        with_value(DOCUMENT, "stents.2.diameter", 1.0)


STENTS = [
    Stent(8.0),
    Stent(8.0, length=20.0, foreshortening_fraction=0.2, name="Upper", keeps="distal"),
    Stent(
        Balloon(10.0, 0.07).lumen_diameter,
        length=20.0,
        balloon=Balloon(10.0, 0.07),
        enabled=False,
        may_be_shortened=True,
    ),
    Stent(9.0, shape=Shape(Waist(6.0, 0.3), StentEnd(10.0, 2.0), cap_height=0.5)),
    Stent(10.0, shape=Shape(table=((0.0, 8.0), (1.0, 10.0)))),
    Stent(
        8.0,
        device=Device(
            "own", lengths=((8.0, 18.0), (10.0, 17.0)), nominal_length=20.0, source="a table"
        ),
    ),
]


@pytest.mark.parametrize("stent", STENTS)
def test_a_stent_comes_back_from_its_entry(stent):
    entry = json.loads(json.dumps(stent_entry(stent)))
    assert stent_of(entry) == stent
    assert stent_of({**entry, "redilation": 3.0}) == stent  # not its business


def test_an_entry_goes_to_a_place():
    assert stent_of({"diameter": 8.0, "length": 20.0}, AtCenter([1, 2, 3])) == Stent(
        8.0, placement=AtCenter([1, 2, 3]), length=20.0
    )


def test_balloon_and_table_follow_another_diameter():
    balloon = stent_of({**stent_entry(STENTS[2]), "diameter": 4.65}).balloon
    assert balloon.diameter == pytest.approx(5.0)
    assert balloon.recoil_fraction == 0.07
    table = stent_of({**stent_entry(STENTS[4]), "diameter": 5.0}).shape.table
    assert table == ((0.0, 4.0), (1.0, 5.0))


def test_a_device_with_lengths_shortens_as_they_say():
    stent = stent_of({**stent_entry(STENTS[5]), "foreshortening_fraction": 0.3})
    assert stent.foreshortening_fraction is None
    assert stent.foreshortening == pytest.approx(0.1)


def test_a_part_that_is_left_out_is_none():
    left_out = {"waist": {"diameter": None, "position": 0.3, "length": 4.0}}
    assert stent_of({"diameter": 8.0, "shape": left_out}).shape is None
    flat = stent_of({"diameter": 8.0, "shape": {**left_out, "cap_height": 0.5}}).shape
    assert flat == Shape(cap_height=0.5)
    both = {**left_out, "end": {"diameter": 9.0, "length": 2.0}}
    assert stent_of({"diameter": 8.0, "shape": both}).shape == Shape(end=StentEnd(9.0, 2.0))
    with pytest.raises(InputError, match="diameter"):  # not said to be none: forgotten
        stent_of({"diameter": 8.0, "shape": {"waist": {"position": 0.3}}})


@pytest.mark.parametrize(
    ("stent", "words"),
    [
        (STENTS[0], ""),
        (STENTS[1], "its distal end kept on shortening"),
        (STENTS[2], "a balloon with 7 % of recoil, shortened where the vessel ends"),
        (STENTS[3], "a shape (waist, start of its own)"),
        (STENTS[4], "a shape (table)"),
        (STENTS[5], "device own"),
        (Stent(8.0, shape=Shape(cap_height=0.5)), "a shape (flat caps)"),
    ],
)
def test_an_entry_is_told_in_words(stent, words):
    assert entry_words(stent_entry(stent)) == words
