"""Parameters of the method: their defaults, presets and refusals."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from SDFStentLib.deformation import RULES, DeploymentSettings
from SDFStentLib.validation import InputError

LENGTHS = {name: one for name, one in DeploymentSettings.parameters().items() if one.unit == "mm"}
WIDTHS = {name: one for name, one in LENGTHS.items() if one.lowest == 0}
"""Those that may be zero."""


def test_the_defaults_are_the_papers_where_it_names_them_and_its_preset_adds_nothing():
    settings = DeploymentSettings()
    assert (settings.influence_distance, settings.smoothing_width) == (6.5, 0.4)
    assert (settings.capsule_length, settings.contact_tolerance) == (1.0, 0.01)
    assert (settings.falloff, settings.blend) == ("compact", "linear")
    settings = DeploymentSettings.published()
    assert settings.step_rule().step == 0.1
    assert (settings.rule, settings.calibration, settings.fold) == ("published", "paper", "distal")
    assert settings.tissue_gap == 0
    off = (settings.finish, settings.facet_compensation, settings.untangle)
    assert off == (False, False, False)


@pytest.mark.parametrize("name", LENGTHS)
def test_lengths_have_bounds_that_are_said(name):
    """Those of a width are 0, or what is told apart from it, and a largest one."""
    one = LENGTHS[name]
    taken, bad = [one.lowest or one.least, one.most], [-0.1, 1.01 * one.most, 1e12, 1e308]
    if name not in WIDTHS:
        bad += [0, 0.99 * one.least, 1e-300]
    for value in taken + [1e-3] * (name == "smoothing_width") + [0] * (name in WIDTHS):
        assert getattr(DeploymentSettings(**{name: value}), name) == value
    least = f"at least {one.lowest or one.least:g}" if name not in WIDTHS else "at least 0"
    for value in [*bad, -1, float("nan"), float("inf"), "much", True]:
        words = rf"^{name}: expected a number .*{least}.* at most {one.most:g} \(mm\), got "
        with pytest.raises(InputError, match=words):
            DeploymentSettings(**{name: value})


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
