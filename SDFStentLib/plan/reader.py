"""Plans as JSON documents: strict reading."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..files import read_text
from ..flow import Known
from ..stent import (
    AlongAxis,
    AtLesion,
    BetweenPoints,
    InputFile,
    OfStent,
    OnBranch,
    Placement,
    Stent,
)
from ..units import MILLIMETERS, Frame
from ..validation import InputError, Place, as_path, as_place
from ..view import ViewWishes
from .document import ALONG, POINT_PLACEMENTS, SCHEMA, SCHEMA_VERSION
from .json_document import (
    check_schema,
    in_words,
    number,
    parsed,
    scaled,
    section,
    sequence,
    text_value,
    truth,
)
from .plan import Plan, method_parameters, plan_of_method
from .typed import from_document
from .vessel_names import read_names

MOST_STENTS = 1000
"""The most stents of a plan, disabled ones too: far more than any patient gets."""

_PARTS = ("sdfstent_version", "inputs", "settings", "flow", "views")
"""Keys of a plan besides its stents."""

_INPUT_KEYS = ("units", "frame", "surface", "centerline", "root", "reference", "names")

_PLACE_KEYS = (
    *("center", "distal", "proximal", "from", "to", "axis", "stent"),
    *("lesion", "offset", "branch", "distance", "fraction"),
)
"""Keys of a placement."""

T = TypeVar("T")

AxisReader = Callable[[InputFile, str, Frame | None], AlongAxis]
"""Reads the curve of an axis file in a unit and a frame, mm."""


def load_plan(path: str | os.PathLike[str], *, accept_changed_inputs: bool = False) -> Plan:
    """Read a plan; paths in it are relative to its folder, curves in axis files are read.

    Parameters
    ----------
    path : path
    accept_changed_inputs : bool
        Read axis files also when they are not the ones that the plan was made with.

    Raises
    ------
    InputError
        A file that cannot be read, no JSON, another schema or version, or a key or a value that
        does not belong there, with its place.
    """
    from .inputs import read_axis_file  # vtk, for plans that name a file only

    path = as_path(path)
    folder = os.path.dirname(os.path.abspath(path))
    document = parsed(read_text(path, "a plan in JSON"), str(path))

    def read(file: InputFile, units: str, frame: Frame | None) -> AlongAxis:
        return read_axis_file(file, units, frame, accept_changed=accept_changed_inputs)

    try:
        return plan_from_document(document, folder, read)
    except InputError as error:
        raise error.labeled(f"{path}: ") from error


def plan_from_document(
    document: Any, folder: str | None = None, axis_reader: AxisReader | None = None
) -> Plan:
    """A plan from the values of its document.

    Parameters
    ----------
    document : mapping
        As `json.loads` gives it; fractions may be `Decimal`.
    folder : path, optional
        Folder of relative paths; the working folder by default.
    axis_reader : callable, optional
        Reads axis files; without it a plan that names one is refused.

    Raises
    ------
    InputError
        Another schema or version, unknown or missing keys, or values that do not belong there.
    """
    check_schema(document, SCHEMA, SCHEMA_VERSION, "this is no plan")
    section(document, "plan", ("schema", "version", "stents"), _PARTS)
    _check_count(document["stents"])
    inputs = section(document.get("inputs", {}), "inputs", (), _INPUT_KEYS)
    units, frame = _space(inputs)
    reader = _StentReader(units, frame, folder, axis_reader)
    made_by = {}
    if "sdfstent_version" in document:
        made_by = {"sdfstent_version": text_value(document["sdfstent_version"], "sdfstent_version")}
    more = {
        "stents": _each(document["stents"], "stents", reader.stent),
        "surface": _file(inputs.get("surface"), "inputs.surface", folder),
        "centerline": _file(inputs.get("centerline"), "inputs.centerline", folder),
        "root": None if inputs.get("root") is None else reader.place(inputs["root"], "inputs.root"),
        "reference": _each(inputs.get("reference", []), "inputs.reference", reader.place),
        "names": read_names(inputs.get("names", {}), "inputs.names", reader.place),
        "flow": _flow(document.get("flow"), reader),
        "views": _views(document.get("views")),
    }
    method = _method(document.get("settings", {}))
    plan = _named("settings", lambda: plan_of_method(method))
    return replace(plan, units=units, frame=frame, **more, **made_by)


def _check_count(stents: Any) -> None:
    count = len(sequence(stents, "stents"))
    if count > MOST_STENTS:
        raise InputError(
            f"stents: expected at most {MOST_STENTS:,}, got {count:,}; leave out those that are "
            "not deployed, or make several plans."
        )


def _space(inputs: Mapping[str, Any]) -> tuple[str, Frame | None]:
    """Unit and frame of the points."""
    units, frame = inputs.get("units", "mm"), inputs.get("frame")
    if not isinstance(units, str) or units not in MILLIMETERS:
        raise InputError(f"inputs.units: expected mm, cm or m, got {in_words(units)}; choose one.")
    if frame not in (None, "RAS", "LPS"):
        raise InputError(
            f"inputs.frame: expected RAS, LPS or null, got {in_words(frame)}; choose one."
        )
    return units, frame


def _flow(value: Any, reader: _StentReader) -> Known | None:
    if value is None:
        return None
    right = value.get("right") if isinstance(value, Mapping) else None
    made = {} if right is None else {"right": reader.place(right, "flow.right")}
    return from_document(Known, value, "flow", **made)


def _views(value: Any) -> ViewWishes | None:
    return None if value is None else from_document(ViewWishes, value, "views")


def _each(value: Any, where: str, read: Callable[[Any, str], T]) -> tuple[T, ...]:
    """The items of a list, each read with its place in the document."""
    items = enumerate(sequence(value, where))
    return tuple(read(item, f"{where}[{index}]") for index, item in items)


class _StentReader:
    """Reader of the stents of one document."""

    def __init__(
        self,
        units: str,
        frame: Frame | None,
        folder: str | None,
        axis_reader: AxisReader | None,
    ) -> None:
        self.units, self.frame, self.folder = units, frame, folder
        self.axis_reader = axis_reader

    def place(self, value: Any, where: str) -> Place:
        """A point as a plain tuple, mm."""
        return as_place(self._point(value, where))

    def stent(self, value: Any, where: str) -> Stent:
        made = {}
        if isinstance(value, Mapping) and "placement" in value:
            made = {"placement": self._placement(value["placement"], f"{where}.placement")}
        return from_document(Stent, value, where, **made)

    def _placement(self, value: Any, where: str) -> Placement | None:
        if value is None:
            return None
        given = section(value, where, (), _PLACE_KEYS)
        if set(given) == {"from", "to"}:
            ends = [self._point(given[key], f"{where}.{key}") for key in ("from", "to")]
            return _named(where, lambda: BetweenPoints(*ends))
        if set(given) == {"stent"}:
            return _named(where, lambda: OfStent(given["stent"]))
        if "lesion" in given or "branch" in given:
            return _named(where, lambda: read_place(given, where))
        if set(given) == {"axis"}:
            return self._axis(given["axis"], f"{where}.axis")
        if len(given) == 1 and set(given) <= set(POINT_PLACEMENTS):
            (key,) = given
            point = self._point(given[key], f"{where}.{key}")
            return _named(where, lambda: POINT_PLACEMENTS[key](point))
        raise InputError(
            f"{where}: expected one of center, distal, proximal, from with to, axis, stent, lesion "
            "(with an offset), or branch with distance or fraction, got "
            f"{', '.join(given) or 'nothing'}; name one."
        )

    def _axis(self, value: Any, where: str) -> AlongAxis:
        given = section(value, where, (), ("points", "file", "sha256"))
        if set(given) == {"points"}:
            points = _each(given["points"], f"{where}.points", self._point)
            return _named(where, lambda: AlongAxis(np.array(points)))
        if "file" not in given or "points" in given:
            raise InputError(
                f"{where}: expected either points or a file, got both or none; keep one."
            )
        file = _file(given, where, self.folder)
        assert file is not None
        if self.axis_reader is None:
            raise InputError(
                f"{where}.file: expected the curve's points, got a file, which can be read from "
                "a plan file only; load the plan from its file."
            )
        return self.axis_reader(file, self.units, self.frame)

    def _point(self, value: Any, where: str) -> NDArray[np.float64]:
        coordinates = sequence(value, where)
        if len(coordinates) != 3:
            raise InputError(f"{where}: expected three numbers, got {in_words(value)}; correct it.")
        factor = MILLIMETERS[self.units]
        return np.array([scaled(item, factor) for item in _each(coordinates, where, number)])


def read_place(given: Mapping[str, Any], where: str) -> AtLesion | OnBranch:
    """A place at a lesion or on a branch, of `placement_document`; `InputError` for none."""
    first, beside = ("lesion", ("offset",)) if "lesion" in given else ("branch", ALONG)
    others = set(given) - {first, *beside}
    if others:
        raise InputError(
            f"expected nothing beside a {first} but {' or '.join(beside)}, got "
            f"{', '.join(sorted(others))}; leave it out."
        )
    along = {
        key: _float(given[key], f"{where}.{key}") for key in beside if given.get(key) is not None
    }
    kind: type[AtLesion] | type[OnBranch] = AtLesion if first == "lesion" else OnBranch
    return kind(given[first], **along)


def _method(value: Any) -> dict[str, Any]:
    parameters = method_parameters()
    given = dict(section(value, "settings", (), tuple(parameters)))
    for key in given:
        where, parameter = f"settings.{key}", parameters[key]
        if parameter.names:
            text_value(given[key], where)
        elif not parameter.is_number:
            truth(given[key], where)
        elif not (parameter.is_optional and given[key] is None):
            given[key] = _float(given[key], where)
    return given


def _file(value: Any, where: str, folder: str | None) -> InputFile | None:
    if value is None:
        return None
    given = section(value, where, ("file",), ("sha256",))
    path = _path(given["file"], f"{where}.file")
    known = given.get("sha256")
    sha256 = None if known is None else text_value(known, f"{where}.sha256").lower()
    return _named(where, lambda: InputFile(path and os.path.join(folder or "", path), sha256))


def _path(value: Any, where: str) -> str:
    """The value if a file may have that name: bytes, also such that are no valid text, but no 0."""
    try:
        if isinstance(value, str) and b"\0" not in os.fsencode(value):
            return value
    except UnicodeEncodeError:
        pass
    raise InputError(f"{where}: expected the name of a file, got {in_words(value)}; correct it.")


def _float(value: Any, where: str) -> float:
    return float(number(value, where))


def _named(where: str, make: Callable[[], Any]) -> Any:
    """Value of `make()`; its complaint names the place in the document."""
    try:
        return make()
    except InputError as error:
        raise error.labeled(f"{where}: ") from error
