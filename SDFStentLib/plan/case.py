"""A vessel in memory and its plan: placed, grown, measured, cut out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..geometry import NamedFaces, Precision, Surface
from ..parameter import Parameter, parameters_of
from ..stent import Stent, stent_axis
from ..treatment import (
    ExtractedSegment,
    PlacedStent,
    PreviewState,
    Residual,
    SegmentWishes,
    SizingWishes,
    TreatedLesion,
    Treatment,
    TreatmentResult,
    Vessel,
    extract_segment,
    label_of,
    labeled,
    lesions_of_treated,
    residual_of,
    size_cautions,
    treated_lesions,
    with_known_minima,
)
from ..units import Frame
from ..validation import InputError, Points
from ..vessel import Lesion
from .draft import Draft
from .plan import Marks, Plan


def vessel_of(
    surface: Surface,
    centerline: Centerline | None = None,
    marks: Marks = Marks(),  # noqa: B008
    *,
    faces: NamedFaces | None = None,
    lines: Points | None = None,
) -> tuple[Vessel, str]:
    """Vessel with a plan's marks, except names of another vessel; and the reason for that, or "".

    Parameters
    ----------
    surface, centerline, faces, lines
        As of `Vessel`.
    marks : Marks
        Marks of the plan in the frame of the surface.
    """
    vessel = Vessel(surface, centerline, marks.reference, faces, marks.names, lines)
    try:
        _ = vessel.given_names
    except InputError as error:
        return replace(vessel, names=()), str(error)
    return vessel, ""


def lying(stent: Stent, centerline: Centerline) -> PlacedStent:
    """A stent in its place on a centerline, whatever the vessel; `InputError` for nowhere."""
    return PlacedStent(1, stent, stent_axis(stent, centerline))


def sizing_parameters() -> dict[str, tuple[Parameter, float]]:
    """Parameters of a stent that is proposed, by name, and their defaults."""
    usual: dict[str, Any] = {one.name: one.default for one in fields(SizingWishes)}
    return {name: (one, usual[name]) for name, one in parameters_of(SizingWishes).items()}


def wishes_of(draft: Draft, ratio: float, margin: float) -> SizingWishes:
    """Wishes for a stent that is proposed in place of a draft; it has the device of that.

    `InputError` for numbers out of their range.
    """
    device = draft.device
    is_own = device is not None and not draft.entry["device_shortening"]
    lost = draft.entry["foreshortening_fraction"] if is_own else None
    return SizingWishes(ratio, margin, device, lost)


@dataclass(frozen=True)
class Case:
    """A plan in its vessel.

    Attributes
    ----------
    vessel : Vessel
    plan : Plan
    frame : {"RAS", "LPS"} or None
        Patient frame of the vessel.
    precision : Precision
        Precision of the stored surface.
    companions : array, shape (c, 3)
        Further points that are dragged along, mm.
    rows : sequence of int
        Rows by which messages count the stents; by default their places in the plan.
    """

    vessel: Vessel
    plan: Plan = field(default_factory=Plan)
    frame: Frame | None = None
    precision: Precision = field(default_factory=Precision)
    companions: Points = field(default_factory=lambda: np.empty((0, 3)))
    rows: Sequence[int] = ()

    @cached_property
    def stents(self) -> tuple[Stent, ...]:
        """Stents of the plan in the frame of the vessel, by points where only that knows more.

        `InputError` as of `Vessel.placed`.
        """
        stents, found = self.plan.in_frame(self.frame).stents, []
        for number, stent in enumerate(stents, start=1):
            with labeled(label_of(stents, number, self.rows)):
                found.append(self.vessel.placed(stent) if stent.enabled else stent)
        return tuple(found)

    def treatment(self) -> Treatment:
        """The stents in turn; iterate it, or ask its `result`.

        `InputError` for a stent that cannot be placed.
        """
        vessel, plan = self.vessel, self.plan
        return Treatment(
            vessel.surface,
            self.stents,
            vessel.centerline,
            plan.settings,
            straightening_fraction=plan.straightening_fraction,
            companions=self.companions,
            precision=self.precision,
            faces=vessel.faces,
            given_names=vessel.given_names,
            rows=self.rows,
        )

    def previewed(self) -> PreviewState:
        """Approximate result, see `Preview`; errors as of `treatment`."""
        plan = self.plan
        fraction = plan.straightening_fraction
        return self.vessel.preview.of(
            self.stents, plan.settings, straightening_fraction=fraction, rows=self.rows
        )

    def segment(
        self, start: Points, end: Points, result: TreatmentResult | None, **wishes: Any
    ) -> ExtractedSegment:
        """Cut out the segment between two places (3,), mm, also after treatment where that is
        known.

        Wishes as of `SegmentWishes`, by name; errors as of `extract_segment`.
        """
        after = None if result is None else Vessel(result.surface, faces=self.vessel.faces)
        return extract_segment(self.vessel, start, end, SegmentWishes(**wishes), after=after)


class CaseOutcome:
    """Lesions, residual stenosis and cautions of a treatment in its vessel."""

    vessel: Vessel
    treatment: TreatmentResult
    found: tuple[Lesion, ...] | None
    """The lesions of the vessel before treatment; None without a centerline."""
    left: tuple[TreatedLesion, ...] | None = None
    """The lesions after treatment, where these are known already."""

    @cached_property
    def lesions(self) -> tuple[TreatedLesion, ...] | None:
        """Lesions of the vessel before and after; None without a centerline."""
        vessel, result, found = self.vessel, self.treatment, self.found
        if found is None or self.left is not None:
            return self.left
        return treated_lesions(found, result.stents, result.surface, vessel.surface)

    @cached_property
    def told_lesions(self) -> tuple[TreatedLesion, ...] | None:
        """Those of `lesions` on which a treatment tells, see `lesions_of_treated`."""
        return self.lesions and lesions_of_treated(self.lesions, self.treatment.stents)

    @cached_property
    def told(self) -> TreatmentResult:
        """The treatment, its narrowest places before it as the lesions there have them."""
        stents = with_known_minima(self.treatment.stents, self.told_lesions)
        return replace(self.treatment, stents=stents)

    @cached_property
    def residual(self) -> Residual | None:
        """Narrowest place in the treated vessels; None where no stent covers a lesion."""
        return residual_of(self.told_lesions or (), self.treatment.stents)

    def size_cautions(self, label: Callable[[int], str]) -> tuple[Caution, ...]:
        """Cautions for a stent too short for its lesion, or its ratio to it beyond what is known.

        `label` names a stent by its number.
        """
        return tuple(size_cautions(self.treatment.stents, self.told_lesions, label))


@dataclass(frozen=True)
class TreatedCase(CaseOutcome):
    """A vessel and its treatment, and the lesions that were found before it."""

    vessel: Vessel
    treatment: TreatmentResult
    found: tuple[Lesion, ...] | None
    left: tuple[TreatedLesion, ...] | None = None
