"""The plan: one value that holds everything that determines a result.

`document` and `reader` turn it into JSON and back, `run` carries it out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..deformation import DeploymentSettings
from ..flow import Known
from ..parameter import Parameter
from ..stent import ByValue, InputFile, Stent
from ..treatment import VesselName
from ..units import Frame, are_apart, flipped, millimeters_per
from ..validation import InputError, Place, Points, as_place, check_is_a
from ..version import VERSION
from ..view import ViewWishes
from .typed import parameter_in

STRAIGHTENING = Parameter(
    "share of its bends that the axis of every stent loses, its length kept: 0 as it is, 1 "
    "straight",
    least=0.0,
    most=1.0,
    option="straighten",
)


class Marks(NamedTuple):
    """Places (3,), mm, that the user marked on a vessel."""

    root: Points | None = None
    """The centerline's end nearest to it is its root."""
    reference: tuple[Points, ...] = ()
    """Healthy vessel, against which lesions are measured."""
    names: tuple[VesselName, ...] = ()
    """Names by which vessels are called, each at a place."""
    frame: Frame | None = None
    """The frame of all places; None: the surface's."""

    def in_frame(self, frame: Frame | None) -> Marks:
        """Marks as a file of that frame has them."""
        if not are_apart(frame, self.frame):
            return self
        root = None if self.root is None else flipped(self.root)
        reference = tuple(flipped(place) for place in self.reference)
        return Marks(root, reference, tuple(one.turned() for one in self.names), frame)


@dataclass(frozen=True, eq=False)
class Plan(ByValue):
    """Stents in order, where they go, in what, and how. Plans with the same values are equal.

    Attributes
    ----------
    stents : tuple of Stent
        Stents in the order of deployment: later ones see the vessel as earlier ones left it.
        Lengths and points in mm, in the frame `frame`.
    surface, centerline : InputFile, optional
        Left out where a program has them in memory.
    units : {"mm", "cm", "m"}
        Unit of the files, and of the points in the plan's document.
    frame : "RAS", "LPS" or None
        Frame of the points; `None` is the surface's, whatever that is.
    settings : DeploymentSettings
    straightening_fraction : float
        See `STRAIGHTENING`.
    root : tuple of three floats, optional
        A point near the end of the centerline that is its root, mm, in the frame `frame`.
    reference : tuple of tuples of three floats
        One or two places of healthy vessel that the user marked, mm, in the frame `frame`; the
        lesion beside them is measured against them.
    names : tuple of VesselName
        Names of vessels by the user; places in mm, in the frame `frame`.
    flow : Known, optional
        Flow and pressures before treatment, as far as they are known, for which those after it are
        estimated.
    views : ViewWishes, optional
        Wishes for the views in which stents are shown; without, the usual ones.
    sdfstent_version : str
        Version of the program that made the plan.
    """

    stents: tuple[Stent, ...] = ()
    surface: InputFile | None = None
    centerline: InputFile | None = None
    units: str = "mm"
    frame: Frame | None = None
    settings: DeploymentSettings = field(default_factory=DeploymentSettings)
    straightening_fraction: float = 0.0
    sdfstent_version: str = VERSION
    root: Place | None = None
    reference: tuple[Place, ...] = ()
    flow: Known | None = None
    names: tuple[VesselName, ...] = ()
    views: ViewWishes | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "stents", tuple(self.stents))
        millimeters_per(self.units)
        if self.frame not in (None, "RAS", "LPS"):
            raise InputError(f"frame: expected RAS, LPS or none, got {self.frame!r}; choose one.")
        STRAIGHTENING.number(self.straightening_fraction, "straightening fraction")
        if self.flow is not None:
            check_is_a(self.flow, Known, "flow")
        if self.views is not None:
            check_is_a(self.views, ViewWishes, "views")
        for number, stent in enumerate(self.stents, start=1):
            if not isinstance(stent, Stent):
                raise InputError(
                    f"stent {number} of the plan: expected a Stent, got {type(stent).__name__}; "
                    "pass one."
                )

    def in_frame(self, frame: Frame | None) -> Plan:
        """Plan with all points in another patient frame; in this one where it has none yet."""
        if not are_apart(self.frame, frame):
            return replace(self, frame=frame)
        known = self.flow
        if known is not None and known.right is not None:
            known = replace(known, right=as_place(flipped(np.array(known.right))))
        stents = tuple(turned(stent) for stent in self.stents)
        return replace(self, stents=stents, frame=frame, flow=known).marked(self.marks)

    @property
    def marks(self) -> Marks:
        """Marks of the user on the vessel."""
        root = None if self.root is None else np.array(self.root)
        reference = tuple(np.array(place) for place in self.reference)
        return Marks(root, reference, self.names, self.frame)

    def marked(self, marks: Marks) -> Plan:
        """Plan with these marks, in its own frame."""
        here = marks.in_frame(self.frame)
        root = None if here.root is None else as_place(here.root)
        reference = tuple(as_place(place) for place in here.reference)
        return replace(self, root=root, reference=reference, names=here.names)

    def of_files(self, surface: str | None, centerline: str | None) -> Plan:
        """Plan for files by their paths, in place of what it names, where these are given."""
        return replace(
            self,
            surface=InputFile(surface) if surface else self.surface,
            centerline=InputFile(centerline) if centerline else self.centerline,
        )

    @property
    def method(self) -> dict[str, Any]:
        """The values of `method_parameters`, by name."""
        values = {name: getattr(self.settings, name) for name in self.settings.parameters()}
        return {**values, "straightening_fraction": self.straightening_fraction}


def method_parameters() -> dict[str, Parameter]:
    """Parameters of the method by name: those of the settings, and the straightening of axes."""
    return {**DeploymentSettings.parameters(), "straightening_fraction": STRAIGHTENING}


def parameter_at(path: str) -> Parameter:
    """The parameter at a path of a plan's document, such as "stents.length" or "flow.bsa"."""
    part, _, inside = path.partition(".")
    if part == "settings":
        return method_parameters()[inside]
    return parameter_in({"stents": Stent, "flow": Known, "views": ViewWishes}[part], inside)


def plan_of_method(values: Mapping[str, Any]) -> Plan:
    """A plan without stents and files, with some values of `method_parameters`.

    `InputError` for values that no parameter takes.
    """
    given = dict(values)
    straightening = given.pop("straightening_fraction", 0.0)
    settings = DeploymentSettings().with_changes(**given)
    return Plan(settings=settings, straightening_fraction=straightening)


def turned(stent: Stent) -> Stent:
    """The stent in the other patient frame, RAS or LPS: x and y of its placement negated."""
    placement = stent.placement
    if placement is None:
        return stent
    changes: dict[str, Any] = {
        name: flipped(value)
        for name, value in vars(placement).items()
        if isinstance(value, np.ndarray)
    }
    return replace(stent, placement=replace(placement, **changes))
