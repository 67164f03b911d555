"""No sentence tells a number with an exponent, a signed zero, or a width of nothing."""

import re
import string

import numpy as np
import pytest

from benchmarks.phantoms import straight_tube
from SDFStentLib.cautions import TEMPLATES, Caution
from SDFStentLib.files.same_space import size_warnings
from SDFStentLib.geometry import Surface
from SDFStentLib.report.diameters import filed_point
from SDFStentLib.stent import AtCenter, Stent, stent_axis
from SDFStentLib.units import place_text
from SDFStentLib.validation import InputError, place_words, plain

ABSURD = re.compile(r"\de[+-]?\d|(?<![\d.])-0(\.0+)?(?![\d.])|nan|\binf\b")


@pytest.mark.parametrize(
    ("value", "spec", "told"),
    [
        (1.45e-15, ".3g", "0"),
        (100.2, ".2g", "100"),
        (123456.0, ".3g", "123000"),
        (0.00002, ".2g", "0.00002"),
        (-0.04, ".1f", "0.0"),
        (-1e-17, ".4g", "0"),
        (-0.5, ".1f", "-0.5"),
        (2.5, ".3g", "2.5"),
        (10.0, ".4g", "10"),
    ],
)
def test_a_number_is_told_as_one_writes_it(value, spec, told):
    assert plain(value, spec) == told


@pytest.mark.parametrize("kind", sorted(TEMPLATES))
@pytest.mark.parametrize("value", [1.45e-15, -1e-17, 2e8, 123456.0])
def test_no_sentence_of_a_caution_has_an_exponent_or_a_signed_zero(kind, value):
    names = {name for _, name, spec, _ in string.Formatter().parse(TEMPLATES[kind]) if name}
    specs = {name: spec for _, name, spec, _ in string.Formatter().parse(TEMPLATES[kind]) if name}
    numbers = {name: value if specs[name] else "x" for name in names - {"x", "y", "z"}}
    told = Caution(kind, numbers, (value, -value, 0.0)).sentence(units="cm")
    assert not ABSURD.search(told), told


def test_places_are_told_without_an_exponent():
    place = np.array([-1e-17, 123456.0, -0.0])
    for told in (place_words(place), place_text(tuple(place), "m"), filed_point(place, "cm")):
        assert not ABSURD.search(told), told


def test_a_placement_far_away_is_refused_with_a_plain_distance():
    tube = straight_tube()
    with pytest.raises(InputError, match=r"centerline, got .* 9[89]\d0 mm away") as raised:
        stent_axis(Stent(6.0, placement=AtCenter([9876.5, 0, 0]), length=9), tube.centerline)
    assert not ABSURD.search(str(raised.value))


def test_a_sheet_that_holds_nothing_is_not_told_to_be_a_hair_wide():
    tube = straight_tube(3.0, 40.0)
    both = np.vstack([tube.triangles, tube.triangles[:, ::-1] + len(tube.points)])
    sheet = Surface(np.vstack([tube.points, tube.points + 1e-12]), both)
    assert not any("wide" in str(one) for one in size_warnings(sheet, "sheet.vtp"))
    turned = tube.triangles.copy()
    turned[::2] = turned[::2, ::-1]
    assert size_warnings(Surface(tube.points, turned), "tube.vtp") == ()
