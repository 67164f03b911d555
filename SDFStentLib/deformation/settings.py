"""What a deployment can be told beside the stent: the parameters of the method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from ..field import FOLDS, CapsuleChain, RadiusShares
from ..validation import Floats, InputError, as_length, as_number
from .profiles import BLENDS, FALLOFFS, Profile, as_profile
from .step_rule import StepRule

RULES = {"events": 0.8, "published": 0.1}
"""Radius-step rules and their (longest) step, mm."""

SHORTEST_AND_LONGEST = {
    "influence_distance": (0.05, 100.0),
    "capsule_length": (0.05, 50.0),
    "contact_tolerance": (1e-6, 1.0),
    "step": (1e-4, 100.0),
    "step_tolerance": (1e-6, 10.0),
    "crimped_radius": (0.01, 50.0),
}
"""Lengths that a deployment can be told, mm: from a fraction of an edge of a vessel's mesh, or of
what its coordinates resolve, to the size of the largest vessel. Shorter capsules and steps would
be too many to be worked off."""

THINNEST_AND_WIDEST_RADIUS = (0.05, 100.0)
"""Radii of a stent, mm: from below that of a wire to above that of any vessel."""

WIDEST = {"smoothing_width": 20.0, "tissue_gap": 10.0, "axis_smoothing": 50.0}
"""Widths that may also be zero, mm: from the size of an aorta, of the tissue beside it, and of its
arch."""

NARROWEST_SMOOTHING = 1e-3
"""A smaller width of the smooth minimum, mm, is none: it changes the distance by k/4 at most."""

CALIBRATIONS = ("axis", "paper", "none")


@dataclass(frozen=True)
class DeploymentSettings:
    """Parameters of the method; the defaults are the recommended ones. Immutable. Lengths in mm.

    `InputError` for values without sense, and for lengths out of `SHORTEST_AND_LONGEST`, `WIDEST`.

    Attributes
    ----------
    influence_distance : float
        Distance from the stent at which the deformation has decayed to zero (paper: 6.5).
    smoothing_width : float
        k of the smooth minimum (paper: 0.4); 0 is the hard minimum.
    capsule_length : float
        Length of one capsule (paper: 1).
    contact_tolerance : float
        Signed distance below which the wall is in contact (paper: 0.01).
    rule : {"events", "published"}
        Radius-step rule: contact events resolved within long steps, or Euler as published.
    step : float, optional
        Radius step, the longest one of rule "events"; by default 0.8 there and 0.1 as published.
    step_tolerance : float
        Distance to the converged limit, mm, that an adaptive step may have by its own estimate.
    crimped_radius : float
        Radius to start from; lowered where the wall is nearer to the axis than that.
    fold : {"both", "distal"}
        Ends from which the smooth minimum is folded. The mean of both makes the result independent
        of the direction of the axis; from the distal end only is as published.
    falloff, blend : str or function
        Weight over the distance to the stent, and over that to the nearest contact point.
    calibration : {"axis", "paper", "none"}
        How the smooth minimum's inflation is taken off the radius: measured on the stent's own
        axis, k/4 as in the paper, or not at all.
    finish : bool
        Put the wall in contact on the true distance from the axis.
    facet_compensation : bool
        Make the lumen, not only its vertices, reach the prescribed diameter. Needs `finish`.
    tissue_gap : float
        Thickness kept between the stent and walls of other lumens; 0 as published.
    axis_smoothing : float
        Length over which the axis of every stent is smoothed in a treatment; 0 leaves it as it is.
    untangle : bool
        Take apart triangles that intersect anew, and retry with other gaps when that fails.
    certify : bool
        Look for new self-intersections at the end.
    """

    names: ClassVar[Mapping[str, Sequence[str]]] = {
        "rule": tuple(RULES),
        "falloff": tuple(FALLOFFS),
        "blend": tuple(BLENDS),
        "calibration": CALIBRATIONS,
        "fold": FOLDS,
    }
    """What the parameters that are names may be."""

    influence_distance: float = 6.5
    smoothing_width: float = 0.4
    capsule_length: float = 1.0
    contact_tolerance: float = 0.01
    rule: str = "events"
    step: float | None = None
    step_tolerance: float = 0.05
    crimped_radius: float = 0.4
    fold: str = "both"
    falloff: str | Profile = "compact"
    blend: str | Profile = "linear"
    calibration: str = "axis"
    finish: bool = True
    facet_compensation: bool = True
    tissue_gap: float = 0.4
    axis_smoothing: float = 0.0
    untangle: bool = True
    certify: bool = True

    def __post_init__(self) -> None:
        for name, (shortest, longest) in SHORTEST_AND_LONGEST.items():
            value = getattr(self, name)
            if name != "step" or value is not None:
                self._set(name, as_length(value, name, shortest, longest))
        for name, widest in WIDEST.items():
            value = as_number(getattr(self, name), name, unit="mm", minimum=0)
            self._set(name, as_number(value, name, unit="mm", maximum=widest))
        if 0 < self.smoothing_width < NARROWEST_SMOOTHING:
            raise InputError(
                f"smoothing_width: expected 0 or at least {NARROWEST_SMOOTHING:g} (mm), got "
                f"{self.smoothing_width!r}; 0 is the hard minimum."
            )
        if self.rule not in RULES:
            raise InputError(f"rule: expected one of {', '.join(RULES)}, got {self.rule!r}.")
        if self.calibration not in CALIBRATIONS:
            raise InputError(
                f"calibration: expected one of {', '.join(CALIBRATIONS)}, got {self.calibration!r}."
            )
        if self.fold not in FOLDS:
            raise InputError(f"fold: expected one of {', '.join(FOLDS)}, got {self.fold!r}.")
        as_profile(self.falloff, FALLOFFS, "falloff")
        as_profile(self.blend, BLENDS, "blend")

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
        """The same code path for dragging: longer steps, neither untangled nor certified."""
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
        known = {field.name for field in fields(self)}
        for name in changes:
            if name not in known:
                raise InputError(f"settings: expected one of {', '.join(known)}, got {name!r}.")
        return replace(self, **changes)

    def chain(
        self, axis: ArrayLike, profile: tuple[Floats, Floats, float] | None = None
    ) -> CapsuleChain:
        """The stent along an axis (n, 3), mm; parameters and errors as `CapsuleChain.along`.

        A profile is parts of the length, diameters there (mm), and the height of its caps over the
        radius; the radius to deploy is then that of its largest diameter.
        """
        shares = None
        if profile is not None:
            fractions, diameters, cap_height = profile
            shares = RadiusShares(fractions, diameters / diameters.max(), cap_height)
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
