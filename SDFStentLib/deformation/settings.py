"""The settings of a deployment: the parameters of the method, apart from the stent itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from ..field import FOLDS, CapsuleChain, RadiusShares
from ..geometry import Line
from ..parameter import Parameter, parameter, parameters_of
from ..validation import Floats, InputError
from .profiles import BLENDS, FALLOFFS, Profile, StepRule, as_profile

RULES = {"events": 0.8, "published": 0.1}
"""Radius-step rules and their (longest) step, mm."""

THINNEST_AND_WIDEST_RADIUS = (0.05, 100.0)
"""Radii of a stent, mm: from below that of a wire to above that of any vessel."""

CALIBRATIONS = ("axis", "paper", "none")


def _length(does: str, least: float, most: float, **more: Any) -> Any:
    return parameter(does, unit="mm", least=least, most=most, **more)


def _choice(does: str, names: Iterable[str], **more: Any) -> Any:
    return parameter(does, names=tuple(names), **more)


_OWN_STEPS = " and ".join(f"{step:g} with {rule}" for rule, step in RULES.items())


@dataclass(frozen=True)
class DeploymentSettings:
    """Parameters of the method; the defaults are the recommended ones. Immutable. Lengths in mm.

    Lengths reach from a fraction of an edge of a vessel's mesh, or of what its coordinates resolve,
    to the size of the largest vessel: shorter capsules and steps would be too many to be worked
    off; a narrower smoothing changes the distance by less than a mesh resolves, k/4. Weights may be
    functions as well as names. `parameters` describes each of them by name.

    Raises
    ------
    InputError
        Values that make no sense, or are out of their range.
    """

    influence_distance: float = _length(
        "distance from the stent at which the deformation ends (paper: 6.5)",
        0.05,
        100.0,
        default=6.5,
        option="influence",
    )
    smoothing_width: float = _length(
        "width k of the smooth minimum (paper: 0.4); 0 is the hard minimum",
        1e-3,
        20.0,
        default=0.4,
        may_be_zero=True,
        option="smoothing",
    )
    capsule_length: float = _length(
        "length of a capsule (paper: 1)", 0.05, 50.0, default=1.0, option="capsule"
    )
    contact_tolerance: float = _length(
        "distance from the stent below which the wall is in contact (paper: 0.01)",
        1e-6,
        1.0,
        default=0.01,
    )
    rule: str = _choice(
        "radius-step rule: contact events resolved within long steps, or Euler as published",
        RULES,
        option="rule",
        default="events",
    )
    step: float | None = _length(
        f"radius step; the rule's own is {_OWN_STEPS}", 1e-4, 100.0, default=None, option="step"
    )
    step_tolerance: float = _length(
        "largest estimated distance of an adaptive step to its limit", 1e-6, 10.0, default=0.05
    )
    crimped_radius: float = _length(
        "radius to start from, lowered where the wall is nearer to the axis",
        0.01,
        50.0,
        default=0.4,
    )
    fold: str = _choice(
        "ends from which the smooth minimum is folded: the mean of both, which makes the "
        "result independent of the direction of the axis, or distal as published",
        FOLDS,
        default="both",
    )
    falloff: str | Profile = _choice(
        "weight over the distance to the stent", FALLOFFS, option="falloff", default="compact"
    )
    blend: str | Profile = _choice(
        "weight over the distance to the nearest contact point",
        BLENDS,
        option="blend",
        default="linear",
    )
    calibration: str = _choice(
        "how the smooth minimum's inflation is taken off the radius: measured on the stent's "
        "own axis, k/4 as in the paper, or not at all",
        CALIBRATIONS,
        default="axis",
    )
    finish: bool = parameter(
        "put the wall in contact on the true distance from the axis", default=True
    )
    facet_compensation: bool = parameter(
        "make up for what flat facets take of the lumen's diameter; needs finish",
        default=True,
        option="no-compensation",
    )
    tissue_gap: float = _length(
        "thickness kept between the stent and walls of other lumens; 0 as published",
        0.0,
        10.0,
        default=0.4,
        option="tissue-gap",
    )
    axis_smoothing: float = _length(
        "length over which the axis of every stent is smoothed first, such as a hand-drawn or "
        "shaky one; 0 leaves it as it is",
        0.0,
        50.0,
        default=0.0,
        option="smooth-axis",
    )
    untangle: bool = parameter(
        "take apart triangles that intersect anew, and retry with other gaps if that fails",
        default=True,
    )
    certify: bool = parameter("look for new self-intersections at the end", default=True)

    def __post_init__(self) -> None:
        for name, one in self.parameters().items():
            if one.is_number:
                self._set(name, one.number(getattr(self, name), name))
        for name in ("rule", "calibration", "fold"):
            self.parameters()[name].choice(getattr(self, name), name)
        as_profile(self.falloff, FALLOFFS, "falloff")
        as_profile(self.blend, BLENDS, "blend")

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Name, meaning and range of each parameter, by its field, in their order."""
        return parameters_of(cls)

    @classmethod
    def published(cls) -> DeploymentSettings:
        """The method as in the paper, with an exact last partial step and nothing else added."""
        return cls(
            rule="published",
            fold="distal",
            calibration="paper",
            finish=False,
            facet_compensation=False,
            tissue_gap=0.0,
            untangle=False,
        )

    @classmethod
    def preview(cls) -> DeploymentSettings:
        """Settings for dragging: longer steps, and neither untangled nor certified."""
        return cls(
            step=1.6,
            step_tolerance=0.1,
            finish=False,
            facet_compensation=False,
            untangle=False,
            certify=False,
        )

    def with_changes(self, **changes: Any) -> DeploymentSettings:
        """A copy with other values; `InputError` for an unknown name."""
        for name in changes:
            if name not in self.parameters():
                known = ", ".join(self.parameters())
                raise InputError(f"settings: expected one of {known}, got {name!r}.")
        return replace(self, **changes)

    def chain(
        self, axis: Line | ArrayLike, profile: tuple[Floats, Floats, float] | None = None
    ) -> CapsuleChain:
        """The stent along an axis; parameters and errors as `CapsuleChain.along`.

        A profile has places as parts of the length, the diameters there (mm), and the height of its
        caps over the radius; the radius to deploy is then half of its largest diameter.
        """
        shares = None
        if profile is not None:
            fractions, diameters, *caps = profile
            shares = RadiusShares(fractions, diameters / diameters.max(), *caps)
        return CapsuleChain.along(
            axis,
            capsule_length=self.capsule_length,
            smoothing_width=self.smoothing_width,
            fold=self.fold,
            shares=shares,
        )

    def step_rule(self) -> StepRule:
        """The part of the settings that a radius step needs."""
        return StepRule(
            influence_distance=self.influence_distance,
            contact_tolerance=self.contact_tolerance,
            step=RULES[self.rule] if self.step is None else self.step,
            tolerance=self.step_tolerance,
            falloff=as_profile(self.falloff, FALLOFFS, "falloff"),
            blend=as_profile(self.blend, BLENDS, "blend"),
        )

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)
