"""Parameters of the method: their defaults, presets and refusals."""

from __future__ import annotations

import json
import re
from dataclasses import FrozenInstanceError, fields
from pathlib import Path

import numpy as np
import pytest

from SDFStentLib.deformation import BLENDS, FALLOFFS, RULES, Deployment, DeploymentSettings
from SDFStentLib.field import CapsuleChain
from SDFStentLib.parameter import parameters_of
from SDFStentLib.phantoms import straight_tube
from SDFStentLib.plan import method_parameters
from SDFStentLib.stent import Balloon, Shape, Stent, StentEnd, Waist
from SDFStentLib.validation import InputError

LENGTHS = {name: one for name, one in DeploymentSettings.parameters().items() if one.unit == "mm"}
PARTS = {"waist": Waist, "start": StentEnd, "end": StentEnd}
WIDTHS = {name: one for name, one in LENGTHS.items() if one.lowest == 0}
"""Those that may be zero."""


def test_the_defaults_are_the_papers_parameters_where_it_names_them():
    settings = DeploymentSettings()
    assert settings.influence_distance == 6.5
    assert settings.smoothing_width == 0.4
    assert settings.capsule_length == 1.0
    assert settings.contact_tolerance == 0.01
    assert (settings.falloff, settings.blend) == ("compact", "linear")


def test_the_published_preset_adds_nothing_to_the_paper():
    settings = DeploymentSettings.published()
    rule = settings.step_rule()
    assert rule.step == 0.1
    assert settings.rule == "published"
    assert settings.calibration == "paper"
    assert settings.fold == "distal"
    assert not settings.finish
    assert not settings.facet_compensation
    assert not settings.untangle
    assert settings.tissue_gap == 0


def test_the_preview_differs_from_the_default_only_in_effort():
    default, preview = DeploymentSettings(), DeploymentSettings.preview()
    differing = {
        field.name
        for field in fields(default)
        if getattr(default, field.name) != getattr(preview, field.name)
    }
    effort = {"step", "step_tolerance", "finish", "facet_compensation", "untangle", "certify"}
    assert differing <= effort
    assert preview.rule == default.rule


@pytest.mark.parametrize("rule", list(RULES))
def test_the_step_follows_the_rule_unless_given(rule):
    assert DeploymentSettings(rule=rule).step_rule().step == RULES[rule]
    assert DeploymentSettings(rule=rule, step=0.3).step_rule().step == 0.3


def test_the_step_rule_carries_the_distances_and_profiles():
    rule = DeploymentSettings(
        influence_distance=4, contact_tolerance=0.02, step_tolerance=0.07, falloff="cosine",
        blend="quadratic",
    ).step_rule()  # fmt: skip
    assert rule.influence_distance == 4
    assert rule.contact_tolerance == 0.02
    assert rule.tolerance == 0.07
    assert rule.falloff is FALLOFFS["cosine"]
    assert rule.blend is BLENDS["quadratic"]


def test_a_profile_may_be_a_function():
    def cubic(x):
        return (1 - x) ** 3

    assert DeploymentSettings(falloff=cubic).step_rule().falloff is cubic


def test_changes_make_a_copy():
    settings = DeploymentSettings()
    changed = settings.with_changes(tissue_gap=0, smoothing_width=0)
    assert (changed.tissue_gap, changed.smoothing_width) == (0, 0)
    assert settings == DeploymentSettings()


def test_settings_cannot_be_changed_in_place():
    with pytest.raises(FrozenInstanceError):
        DeploymentSettings().step = 0.2


def test_numbers_of_numpy_and_strings_of_digits_become_floats():
    settings = DeploymentSettings(step=np.float32(0.5), influence_distance=np.int64(5))
    assert type(settings.step) is float
    assert type(settings.influence_distance) is float


@pytest.mark.parametrize(
    "name",
    ["influence_distance", "capsule_length", "contact_tolerance", "step_tolerance",
     "crimped_radius", "step"],
)  # fmt: skip
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf"), "much", True])
def test_lengths_that_are_not_positive_are_refused_by_name(name, value):
    with pytest.raises(InputError, match=f"{name}: expected a number at least"):
        DeploymentSettings(**{name: value})


@pytest.mark.parametrize("name", ["smoothing_width", "tissue_gap"])
def test_widths_may_be_zero_but_not_negative(name):
    assert getattr(DeploymentSettings(**{name: 0}), name) == 0
    with pytest.raises(InputError, match=f"{name}: expected a number at least 0"):
        DeploymentSettings(**{name: -0.1})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rule": "fast"}, "rule: expected one of events, published, got 'fast'"),
        ({"calibration": "k/4"}, "calibration: expected one of axis, paper, none, got 'k/4'"),
        ({"falloff": "gauss"}, "falloff: expected one of compact, wendland, cosine"),
        ({"blend": lambda x: x}, "blend: expected a function of an array that falls from 1"),
    ],
)
def test_unknown_choices_are_refused_with_the_known_ones(change, message):
    with pytest.raises(InputError, match=message):
        DeploymentSettings(**change)


def test_an_unknown_setting_is_refused_by_name():
    with pytest.raises(InputError, match=r"settings: expected one of .*, got 'radius_step'"):
        DeploymentSettings().with_changes(radius_step=0.1)


def test_the_precision_of_a_changed_value_is_checked_too():
    with pytest.raises(InputError, match=r"step: expected a number at least 0.0001"):
        DeploymentSettings().with_changes(step=-1)


@pytest.mark.parametrize("name", [name for name in LENGTHS if name not in WIDTHS])
def test_lengths_that_no_vessel_has_are_refused_with_what_is_taken(name):
    shortest, longest = LENGTHS[name].least, LENGTHS[name].most
    for value in (shortest, longest):
        assert getattr(DeploymentSettings(**{name: value}), name) == value
    words = (
        rf"^{name}: expected a number at least {shortest:g} and at most {longest:g} \(mm\), got "
    )
    for value in (0.99 * shortest, 1.01 * longest, 1e-300, 1e308):
        with pytest.raises(InputError, match=words):
            DeploymentSettings(**{name: value})


@pytest.mark.parametrize("name", WIDTHS)
def test_widths_that_no_vessel_has_are_refused(name):
    widest = WIDTHS[name].most
    assert getattr(DeploymentSettings(**{name: widest}), name) == widest
    for value in (1.01 * widest, 1e12, 1e308):
        words = rf"^{name}: expected a number .*at most {widest:g} \(mm\), got "
        with pytest.raises(InputError, match=words):
            DeploymentSettings(**{name: value})


def test_a_smoothing_that_smooths_nothing_is_refused_or_zero():
    assert DeploymentSettings(smoothing_width=1e-3).smoothing_width == 1e-3
    with pytest.raises(
        InputError, match=r"smoothing_width: expected 0 or at least 0.001 .* 1e-300"
    ):
        DeploymentSettings(smoothing_width=1e-300)


def test_the_schema_of_plans_has_the_same_parameters():
    path = Path(__file__).parents[1] / "SDFStentLib" / "plan" / "plan.schema.json"
    schema = json.loads(path.read_text(encoding="utf-8"))
    found = schema["properties"]["settings"]["properties"]
    assert found == {name: one.schema() for name, one in method_parameters().items()}
    stent = schema["definitions"]["stent"]["properties"]
    shape = stent["shape"]["properties"]
    for kind, properties in (
        (Stent, stent),
        (Balloon, stent["balloon"]["properties"]),
        (Shape, shape),
        *((kind, shape[name]["properties"]) for name, kind in PARTS.items()),
    ):
        known = {name: one.schema() for name, one in parameters_of(kind).items()}
        assert known == {name: properties[name] for name in known}


def test_a_length_of_thousands_of_digits_is_refused():
    with pytest.raises(InputError, match=r"capsule_length: expected a number at least 0.05"):
        DeploymentSettings(capsule_length=10**400)


@pytest.mark.parametrize("radius", [5e-301, 0.049, 101, 1e6])
def test_a_radius_that_no_stent_has_is_refused(radius):
    tube = straight_tube(3, 20, 1.2)
    words = r"stent radius: expected a number at least 0.05 and at most 100 \(mm\), got"
    with pytest.raises(InputError, match=words):
        Deployment(tube.surface, CapsuleChain.along([[0, 0, 5], [0, 0, 15]]), radius)


def test_the_method_document_names_every_setting_with_its_default():
    text = (
        (Path(__file__).parents[1] / "docs" / "method.md")
        .read_text(encoding="utf-8")
        .split("## Defaults")[1]
    )
    default, documented = DeploymentSettings(), {}
    for names, values in re.findall(r"^\| (`[^|]+) \| ([^|]+) \|", text, flags=re.MULTILINE):
        documented |= dict(zip(re.findall(r"\w+", names), values.split(", "), strict=True))
    assert set(documented) == {field.name for field in fields(default)}
    for name, said in documented.items():
        value = RULES["events"] if name == "step" else getattr(default, name)
        meant = {"on": True, "off": False}.get(said, said.removesuffix(" mm").strip())
        assert str(meant) == str(value), name
