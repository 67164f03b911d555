"""Angiograms of a plan that was carried out: one for each of its stents."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ...files import check_suffix, write_bytes
from ...geometry import Surface
from ...plan import PlanResult
from ...validation import Floats, InputError, check_is_a
from ...view import ViewWishes
from ..facts import Facts
from ..picture.drawing import Drawing, svg
from ..picture.painting import painted
from ..picture.shapes import strut_curves
from .facts import ToldViews, limits_document, stent_stretch
from .picture import below_each_other, seen_drawing, views_drawing
from .sight import Sight


class SeenStent(NamedTuple):
    """Views of a stent, and the walls and struts seen in them."""

    number: int
    told: ToldViews
    walls: tuple[Surface, Surface]
    """Walls before and after treatment."""
    struts: Sequence[Floats]

    @property
    def title(self) -> str:
        """Title of the stretch that is looked at."""
        return self.told.stretch.title

    def drawings(self) -> Iterator[tuple[Facts, Drawing]]:
        """Drawings before and after in the best view, and in chosen ones, with their facts."""
        typed = self.told.typed
        views = [self.told.found.best, *typed]
        facts = [self.told.facts[0], *self.told.facts[len(self.told.facts) - len(typed) :]]
        for seen, own in zip(views, facts, strict=True):
            yield own, seen_drawing(self.told, self.walls, seen, self.struts)

    @property
    def column(self) -> Drawing:
        """The best view in one drawing, before above after."""
        best = [self.told.found.best]
        return views_drawing(self.told, self.walls, struts=self.struts, views=best)

    def as_dict(self) -> dict[str, Any]:
        """For a document."""
        length = self.told.stretch.length
        return {"stent": self.number, "length_mm": length, "views": self.told.facts}


@dataclass(frozen=True, eq=False)
class PlannedViews:
    """Views of a plan's stents, or the reason for none."""

    stents: tuple[SeenStent, ...]
    wishes: ViewWishes
    reason: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For a document."""
        frame = self.stents[0].told.frame if self.stents else None
        return {
            "frame": frame,
            "reason": self.reason or None,
            "limits": limits_document(self.wishes.limits),
            "stents": self.stents,
        }


def no_views(wishes: ViewWishes | None, reason: str) -> PlannedViews:
    """Views of a plan without any, and the reason."""
    return PlannedViews((), wishes or ViewWishes(), reason)


def planned_views(result: PlanResult, *, hides_device: bool = False) -> PlannedViews:
    """Views of all stents that lie in the vessel in the end, or the reason for none."""
    check_is_a(result, PlanResult, "result")
    wishes = result.plan.views or ViewWishes()
    try:
        return PlannedViews(_seen(result, wishes, hides_device), wishes)
    except InputError as error:
        return no_views(wishes, str(error))


def write_angiogram(
    result: PlanResult, path: str | os.PathLike[str], *, hides_device: bool = False
) -> None:
    """Draw the stents of a plan, each from its best view, before and after, to .png or .svg.

    Raises
    ------
    InputError
        Another suffix, a file that cannot be written; no frame, centerline or radii.
    DeploymentError
        A PNG is wanted and nothing here can render; the message names what to install.
    """
    check_is_a(result, PlanResult, "result")
    check_suffix(path, "an angiogram", (".png", ".svg"))
    seen = _seen(result, result.plan.views or ViewWishes(), hides_device)
    drawing = below_each_other([one.column for one in seen])
    is_svg = Path(path).suffix.lower() == ".svg"
    write_bytes(path, svg(drawing).encode() if is_svg else painted(drawing))


def _seen(result: PlanResult, wishes: ViewWishes, hides_device: bool) -> tuple[SeenStent, ...]:
    """Views of each stent; errors as of `Sight.told`."""
    stents, frame = result.told.final_stents, result.inputs.frame
    struts = () if hides_device else strut_curves(stents)
    walls = result.inputs.surface.surface, result.treatment.surface
    return tuple(
        SeenStent(
            one.number,
            Sight(stent_stretch(one, result.told_lesions), result.vessel, frame).told(wishes),
            walls,
            struts,
        )
        for one in stents
    )
