"""What a stent is beyond its sizes and its place, kept as one text."""

from __future__ import annotations

import pytest
from test_devices import a_device
from test_shapes import SHAPES

from SDFStentLib.plan import StentSizes, detailed_stent, details_words, stent_details
from SDFStentLib.stent import AtCenter, Balloon, Stent
from SDFStentLib.validation import InputError

PLACE = AtCenter([0.0, 0, 20])


def again(stent: Stent, diameter: float | None = None) -> Stent:
    sizes = StentSizes(diameter or stent.diameter, stent.length, stent.foreshortening)
    return detailed_stent(stent_details(stent), sizes, stent.placement, stent.name)


@pytest.mark.parametrize("name", SHAPES)
def test_a_stent_comes_back_from_its_sizes_and_its_details(name):
    stent = Stent(
        8.0 * 0.9,
        placement=PLACE,
        length=16.0,
        foreshortening_fraction=0.1,
        balloon=Balloon(8.0, 0.1),
        keeps="distal",
        name="left",
    )
    assert again(stent) == stent
    shaped = Stent(
        8.0, placement=PLACE, length=16.0, foreshortening_fraction=0.0, shape=SHAPES[name]
    )
    assert again(shaped) == shaped


def test_another_diameter_takes_the_recoil_and_the_table_along():
    stent = Stent(7.2, placement=PLACE, length=16, balloon=Balloon(8.0, 0.1))
    assert again(stent, 9.0).balloon.diameter == pytest.approx(10.0)
    table = Stent(8.0, placement=PLACE, length=16, shape=SHAPES["table"])
    assert again(table, 4.0).shape.table == ((0, 3.5), (0.3, 4.0), (0.5, 3.25), (1, 4.0))
    with pytest.raises(InputError, match=r"waist: expected at most the 6 mm of the stent, got 6"):
        again(Stent(8.0, placement=PLACE, length=16, shape=SHAPES["hourglass"]), 6.0)


def test_the_details_in_words():
    stent = Stent(
        12.6,
        placement=PLACE,
        device=a_device(),
        balloon=Balloon(14.0, 0.1),
        keeps="distal",
        shape=SHAPES["all"],
    )
    assert details_words(stent_details(stent)) == (
        "device bench-34, a balloon with 10 % of recoil, its distal end kept on shortening, "
        "a shape (waist, start of its own, end of its own)"
    )
    flat = Stent(8.0, placement=PLACE, length=16, shape=SHAPES["flat caps"])
    assert details_words(stent_details(flat)) == "a shape (flat caps)"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "stent details: expected a JSON document, got an error"),
        ('{"color": 1}', "stent details: unknown key 'color'"),
        ('{"device": {}}', r"stent details.device: expected the key 'name', got none"),
        ('{"balloon": {"diameter": 8}}', r"stent details.balloon: expected the key 'recoil_fra"),
        ('{"shape": {"waist": {"diameter": 0}}}', r"details.shape.waist: waist: expected a numb"),
    ],
)
def test_details_that_cannot_be_read_are_said(text, words):
    with pytest.raises(InputError, match=words):
        detailed_stent(text, StentSizes(8.0, 16, 0.1), PLACE)
