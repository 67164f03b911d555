"""Sight of a stretch of vessel from anywhere: the best views, the facts of any, and a film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ...centerline import Centerline
from ...geometry import Surface
from ...treatment import Vessel
from ...units import Frame
from ...validation import Floats, InputError
from ...view import (
    ArmView,
    Beam,
    LesionSections,
    SeenView,
    Shown,
    ViewWishes,
    arm_view,
    working_views,
)
from ..facts import Facts
from .facts import BEST, SECOND, TYPED, WORST, Stenosis, Stretch, ToldViews, known_frame, view_facts
from .film import Film, beam_of, film_of


@dataclass(frozen=True, eq=False)
class Sight:
    """A stretch in its vessel before treatment.

    Parameters
    ----------
    stretch : Stretch
    vessel : Vessel
    known : "RAS", "LPS" or None
        The frame of both, as far as it is known.

    Raises
    ------
    InputError
        Without a frame there are no angles, without a centerline nobody knows what may lie in the
        way.
    """

    stretch: Stretch
    vessel: Vessel
    known: Frame | None

    def __post_init__(self) -> None:
        known_frame(self.known)
        if self.vessel.centerline is None:
            raise InputError(
                "expected a centerline, which tells what may lie in the way, got none; give one."
            )

    @property
    def frame(self) -> Frame:
        """Frame of stretch and vessel."""
        return known_frame(self.known)

    def told(self, wishes: ViewWishes | None, typed: Sequence[ArmView] = ()) -> ToldViews:
        """The best views, the worst, that of the wishes, and any others; as usual without wishes.

        `InputError` for a centerline without radii, or an arm that reaches no view.
        """
        wishes = wishes or ViewWishes()
        found = working_views(self._shown, wishes.limits, wishes.apart)
        asked = tuple(self._shown.seen_from(one) for one in (wishes.view, *typed) if one)
        roles = ((BEST, found.best), (SECOND, found.second), (WORST, found.worst))
        told = [(role, seen) for role, seen in roles if seen is not None]
        every = [*told, *((TYPED, one) for one in asked)]
        facts = tuple(self._facts(role, seen) for role, seen in every)
        return ToldViews(self.stretch, self.frame, wishes.limits, found, asked, facts)

    def facts_from(self, view: ArmView) -> Facts:
        """Facts from any view; `InputError` for a centerline without radii."""
        return self._facts(TYPED, self._shown.seen_from(view))

    def beam(self, view: ArmView) -> Beam:
        """The rays of its angiogram, with their middle and how much is seen."""
        return beam_of(self.stretch, view, self.frame)

    def film(self, wall: Surface, view: ArmView, struts: Sequence[Floats] = ()) -> Film:
        """The angiogram of a wall from there, with curves (m, p, 3) of stents, mm."""
        return film_of(self.stretch, wall, view, self.frame, struts)

    def _facts(self, role: str, seen: SeenView) -> Facts:
        over = [self.vessel.branch_names[number] for number in seen.over_it]
        toward = seen.view.axes(self.frame)[2]
        stenoses = [
            Stenosis(name, one.seen(toward), one.after.percent_diameter)
            for name, one in self._sections.items()
        ]
        return Facts(view_facts(role, seen, self.stretch.length, over, stenoses))

    @cached_property
    def _shown(self) -> Shown:
        return Shown(self._tree, self.stretch.line, self.stretch.radii, self.frame)

    @cached_property
    def _sections(self) -> Mapping[str, LesionSections]:
        """Sections of a lesion before, and after where it was treated."""
        lesion = self.stretch.lesion
        states = (("before", lesion), ("after", self.stretch.after))
        if lesion is None:
            return {}
        return {
            name: LesionSections(lesion, state, self._tree)
            for name, state in states
            if state is not None
        }

    @property
    def _tree(self) -> Centerline:
        assert self.vessel.centerline is not None
        return self.vessel.centerline


def view_toward(toward: Floats, frame: Frame) -> ArmView:
    """The view whose detector is in a direction (3,) of any length but zero."""
    return arm_view(toward, frame)


def view_axes(view: ArmView, frame: Frame) -> Floats:
    """(3, 3) right, up, and toward the detector of a view."""
    return view.axes(frame)
