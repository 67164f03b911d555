"""Names of vessels by the user, as JSON, with the face or the place of each."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..files import read_text
from ..treatment import VesselName
from ..units import MILLIMETERS
from ..validation import InputError, Place, as_path, one_line
from .json_document import in_words, number, parsed, scaled, text_value, unscaled


def load_names(path: str | os.PathLike[str], units: str = "mm") -> tuple[VesselName, ...]:
    """Read names of vessels; places in a unit, as the surface that they are of.

    Raises
    ------
    InputError
        A file that cannot be read, no JSON, or what is no name of a vessel.
    """
    path = as_path(path)
    document = parsed(read_text(path, "names of vessels in JSON"), str(path))

    def place(value: Any, where: str) -> Place:
        if not isinstance(value, list) or len(value) != 3:
            raise _no_place(where, value)
        x, y, z = (scaled(number(one, where), MILLIMETERS[units]) for one in value)
        return x, y, z

    return read_names(document, str(path), place)


def read_names(
    value: Any, where: str, place: Callable[[Any, str], Place]
) -> tuple[VesselName, ...]:
    """The names in a document; `place` reads a point, mm.

    Raises
    ------
    InputError
        What is no object of names, or a name that is empty, that two vessels have, or that stands
        for neither a place nor a face.
    """
    if not isinstance(value, Mapping):
        raise InputError(
            f'{where}: expected names of vessels, such as {{"LPA": [9.3, -77.5, -55.5]}}, got '
            f"{in_words(value)}; give every name a place in its vessel, or the id of a face."
        )
    found: dict[str, VesselName] = {}
    for text, at in value.items():
        name = one_line(text_value(text, where).strip())
        if not name:
            raise InputError(f"{where}: expected a name, got an empty one; name the vessel.")
        if name in found:
            raise InputError(
                f"{where}: expected another name for every vessel, got {name!r} twice; change one."
            )
        here = f"{where}: {name!r}"
        if isinstance(at, int) and not isinstance(at, bool):
            found[name] = VesselName(name, at)
        elif isinstance(at, Sequence) and not isinstance(at, str):
            found[name] = VesselName(name, place(at, here))
        else:
            raise _no_place(here, at)
    return tuple(found.values())


def names_document(names: Sequence[VesselName], units: str) -> dict[str, Any]:
    """Names as in a document, places in a unit as `Decimal`."""
    factor = MILLIMETERS[units]
    return {
        one.name: one.at if isinstance(one.at, int) else [unscaled(x, factor) for x in one.at]
        for one in names
    }


def _no_place(where: str, value: Any) -> InputError:
    return InputError(
        f"{where}: expected three numbers, a place in the vessel, or the id of a face at its end, "
        f"got {in_words(value)}; correct it."
    )
