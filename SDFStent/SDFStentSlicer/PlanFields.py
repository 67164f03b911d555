"""Values of a plan in the panel: their paths, units, ranges and names."""

import enum
from typing import Any, NamedTuple

from slicer.i18n import tr as _

from SDFStentLib.plan import (
    NEW_STENT,
    Plan,
    method_parameters,
    parameter_at,
    sizing_parameters,
)


class Placement(enum.Enum):
    """Meaning of the points of a stent's handle."""

    CENTER = "center"
    DISTAL_END = "distal"
    PROXIMAL_END = "proximal"
    BETWEEN_POINTS = "between"
    ALONG_CURVE = "axis"
    AGAIN = "again"
    AT_LESION = "lesion"
    ON_BRANCH = "branch"

    def label(self):
        """The text in the panel."""
        return {
            Placement.CENTER: _("Middle at a point"),
            Placement.DISTAL_END: _("Distal end at a point"),
            Placement.PROXIMAL_END: _("Proximal end at a point"),
            Placement.BETWEEN_POINTS: _("Between two points"),
            Placement.ALONG_CURVE: _("Along a curve"),
            Placement.AGAIN: _("Dilates a stent again"),
            Placement.AT_LESION: _("At a lesion"),
            Placement.ON_BRANCH: _("On a branch"),
        }[self]

    @classmethod
    def of(cls, place):
        """The kind of a place in the document."""
        key = next(iter(place))
        return cls.BETWEEN_POINTS if key == "from" else cls.AGAIN if key == "stent" else cls(key)

    @property
    def place(self):
        """The place of a document of which no more than the kind is known: the rest is with the handle."""
        if self == Placement.BETWEEN_POINTS:
            return {"from": None, "to": None}
        return {"stent" if self == Placement.AGAIN else self.value: None}

    @property
    def usesHandleLength(self):
        """Whether the handle alone says how long the stent is."""
        return self in (Placement.BETWEEN_POINTS, Placement.ALONG_CURVE, Placement.AGAIN)

    @property
    def isByPoint(self):
        """Whether one point and its length say where the stent is."""
        return self in (Placement.CENTER, Placement.DISTAL_END, Placement.PROXIMAL_END)

    @property
    def isOfVessel(self):
        """Whether what the vessel has says where the stent is, and the handle follows."""
        return self in (Placement.AT_LESION, Placement.ON_BRANCH)

    @property
    def needsCenterline(self):
        """Whether the axis is that of the centerline."""
        return self not in (Placement.ALONG_CURVE, Placement.AGAIN)

    @property
    def pointCount(self):
        """Number of placed points that the handle needs."""
        return 2 if self in (Placement.BETWEEN_POINTS, Placement.ALONG_CURVE) else 1


def _fieldOf(name):
    first, *others = name.split("_")
    return first + "".join(map(str.capitalize, others))


def _inWords(name):
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name.replace('_', ' ')}"


class Range(NamedTuple):
    """Range of a number, in the library as in the panel, and its name."""

    low: float
    high: float
    words: str
    unit: str = " mm"


def _rangeOf(one, words, unit=" mm"):
    return Range(one.least, one.most, words, unit)


METHOD_PARAMETERS = {
    _fieldOf(name): (name, one)
    for name, one in method_parameters().items()
    if one.option and (one.names or one.unit)
}
"""Name and `Parameter` of the library for each field of `MethodParameters` that the panel shows."""

_WIDEST = parameter_at("stents.diameter").most
_SHORTENING = parameter_at("stents.foreshortening_fraction")
SIZING = sizing_parameters()
"""Parameters of a suggestion by name: the `Parameter` and its default."""

RANGES = {
    "diameter": Range(0.1, _WIDEST, "a diameter"),
    "length": Range(0.1, parameter_at("stents.length").most, "a length"),
    "foreshortening": Range(
        100 * _SHORTENING.least, 100 * _SHORTENING.most, "a foreshortening", " %"
    ),
    "redilation": Range(0.0, _WIDEST, "a redilation"),
    **{
        field: Range(0.0 if one.is_optional else one.lowest, one.most, _inWords(name))
        for field, (name, one) in METHOD_PARAMETERS.items()
        if one.unit
    },
    "straightening": Range(0.0, 100.0, "a straightening", " %"),
    "flowMean": Range(0.0, 60.0, "a mean flow", " L/min"),
    "flowPeak": Range(0.0, 200.0, "a peak flow", " L/min"),
    "inletPressure": Range(0.0, 300.0, "a pressure at the inlet", " mmHg"),
    "wedgePressure": Range(0.0, 300.0, "a wedge pressure", " mmHg"),
    "splitRight": Range(0.0, 99.0, "a share of the flow to the right", " %"),
    "flowBsa": Range(0.0, parameter_at("flow.bsa").most, "a body surface area", " m2"),
    "suggestRatio": _rangeOf(SIZING["ratio"][0], "a ratio to the adjacent vessel", ""),
    "suggestMargin": _rangeOf(SIZING["margin"][0], "a margin"),
}


CHOICE_LABELS = {
    "rule": {"events": _("adaptive"), "published": _("as in the paper")},
    "falloff": {
        "compact": _("gradual (as in the paper)"),
        "wendland": _("steep (Wendland)"),
        "cosine": _("gradual (half cosine)"),
    },
    "blend": {
        "linear": _("gradual (as in the paper)"),
        "quadratic": _("steeper (quadratic)"),
        "exponential": _("steepest (exponential)"),
    },
}
"""The texts in the panel for the library's keys, by parameter."""

KEPT_LABELS = {
    "center": _("Center"),
    "proximal": _("Proximal end"),
    "distal": _("Distal end"),
}
"""The texts in the panel for what a stent can keep, by the library's word."""

REMEDIES = {
    "foreshortening": _(" (in Device, untick As known of the device or move Foreshortening)"),
    "unusual": _(" (in Flow, tick Unusual flow is meant so)"),
}
"""Remedies that the library's sentences advise, as the panel calls them."""


ML_PER_S = 1000 / 60
"""Milliliters per second in one liter per minute."""

UNITS = {
    " %": (lambda value: 100 * value, lambda value: value / 100),
    " L/min": (lambda value: value / ML_PER_S, lambda value: value * ML_PER_S),
}
"""Conversions by the unit behind a number: from the plan to the panel, and back. All other numbers are as in the plan."""


class PlanField(NamedTuple):
    """A value of the plan as Python code has it: its path, its unit in the panel, and what stands for none."""

    path: str
    unit: str = ""
    none: Any = None

    def shown(self, value):
        """A value of the plan as in the panel."""
        if value is None:
            return self.none
        return UNITS[self.unit][0](value) if self.unit in UNITS else value

    def planned(self, value):
        """A value of the panel as in the plan."""
        if self.none is not None and value == self.none:
            return None
        return UNITS[self.unit][1](value) if self.unit in UNITS else value


class PlaceField(PlanField):
    """The kind of a placement; setting it forgets the place of another kind."""

    def shown(self, value):
        return Placement.of(value)

    def planned(self, value):
        return value.place if isinstance(value, Placement) else value


STENT = {
    "label": PlanField("name"),
    "foreshortening": PlanField("foreshortening_fraction", " %"),
    "placement": PlaceField("placement"),
    "wholeCurve": PlanField("whole_curve"),
    "deviceShortening": PlanField("device_shortening"),
    "redilation": PlanField("redilation", none=0.0),
}
STENT |= {
    name: PlanField(name) for name in NEW_STENT if name not in {one.path for one in STENT.values()}
}
METHOD = {
    field: PlanField(f"settings.{name}", none=0.0 if one.is_optional else None)
    for field, (name, one) in METHOD_PARAMETERS.items()
} | {"straightening": PlanField("settings.straightening_fraction", " %")}
FLOW = {
    "flowMean": PlanField("flow.mean", " L/min", 0.0),
    "flowPeak": PlanField("flow.peak", " L/min", 0.0),
    "inletPressure": PlanField("flow.inlet", none=0.0),
    "wedgePressure": PlanField("flow.wedge", none=0.0),
    "splitRight": PlanField("flow.split_right", " %", 0.0),
    "flowBsa": PlanField("flow.bsa", none=0.0),
    "flowUnusual": PlanField("flow.unusual", none=False),
}
DEFAULTS = {"settings": Plan().method, "stents": [], "flow": None, "views": None, "inputs": {}}
STENT_FIELDS = (*STENT, "handle")
PATHS = {f"stents.selected.{one.path}": name for name, one in STENT.items()} | {
    one.path: name for name, one in {**METHOD, **FLOW}.items()
}
"""Names by path."""


def check(name, value):
    """Refuse a number beyond its range."""
    limits = RANGES.get(name)
    if None not in (limits, value) and not limits.low <= value <= limits.high:
        raise ValueError(f"{name}: expected {limits.low:g} to {limits.high:g}, got {value!r}")
    kind = METHOD_PARAMETERS.get(name)
    if kind is not None and kind[1].names:
        kind[1].choice(value, name)


def entryOf(values):
    """Changes of a stent, by names of Python code or those of the document, as in the document."""
    changes = {}
    for name, value in values.items():
        check(name, value)
        field = STENT.get(name)
        changes[field.path if field else name] = field.planned(value) if field else value
    return changes
