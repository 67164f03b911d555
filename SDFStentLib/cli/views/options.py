"""The options of `views`, and what they say of the C-arm."""

from __future__ import annotations

import argparse
import csv
import os
from pathlib import Path

from ...parameter import parameters_of
from ...stent import Stent
from ...validation import InputError, as_number
from ...view import ArmView, ViewWishes
from ..option_table import (
    FRAME,
    MARKS,
    OTHER_PLACES,
    SURFACE,
    TALK,
    UNITS,
    USUAL_PLACE,
    add_parameter,
    add_table,
)


def add_views(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    command.description = (
        "The C-arm angles that show a lesion, or another part of a vessel, with the least "
        "foreshortening and the fewest vessels over it, and how narrow it looks from there; "
        "with a picture, simulated angiograms. Research use only."
    )
    add_table(command, SURFACE)
    place = command.add_argument_group("what is looked at")
    add_table(
        place, "--at-lesion N  that lesion, numbered as `measure` lists them (default: the first)"
    )
    add_table(place, USUAL_PLACE)
    add_parameter(place, parameters_of(Stent)["length"])
    add_table(place, OTHER_PLACES + MARKS)
    arm = command.add_argument_group("the C-arm")
    for one in parameters_of(ViewWishes).values():
        if one.option:
            add_parameter(arm, one, getattr(ViewWishes(), one.option.replace("-", "_")))
    add_table(
        arm,
        FRAME
        + """\
--view A A ...  tell of this view, too: LAO and CRA, RAO and CAU are negative; may be repeated
--limits F  CSV with rows LAO,CRA,CAU: how far it gets to head and feet there, with the table
""",
    )
    add_table(
        command.add_argument_group("output"),
        """\
-o, --output F  angiograms and the map of all angles, .png or .svg
--after SURFACE2  the treated vessel, shown below
--parallel  rays that do not part; else the source is 780 mm from the isocenter
--reach MM  leave out lumen farther than this from what is looked at
--subtracted  gray as in a subtraction, linear in the length within the lumen
--json F  write all numbers, those of the map, too
""",
    )
    add_table(command, UNITS + TALK)


def wishes_of(options: argparse.Namespace) -> ViewWishes:
    """Wishes for the arm; `InputError` for angles that no arm has."""
    table = () if options.limits is None else read_limits(options.limits)
    return ViewWishes(options.lao_rao, options.cra_cau, options.apart, table=table)


def views_of(options: argparse.Namespace) -> tuple[ArmView, ...]:
    """The views that are asked about."""
    found = []
    for primary, secondary in options.view:
        primary = as_number(primary, "--view", unit="degrees", minimum=-180, maximum=180)
        secondary = as_number(secondary, "--view", unit="degrees", minimum=-90, maximum=90)
        found.append(ArmView(primary, secondary))
    return tuple(found)


def read_limits(path: str | os.PathLike[str]) -> tuple[tuple[float, float, float], ...]:
    """Rows LAO,CRA,CAU of a CSV file, degrees; a first row of words is a heading.

    Raises
    ------
    InputError
        A file that cannot be read, or rows of anything else.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: expected a table of text that can be read, got {error}."
        ) from error
    rows = [row for row in csv.reader(text.splitlines()) if any(map(str.strip, row))]
    if rows and not _are_numbers(rows[0]):
        rows = rows[1:]
    wrong = next((row for row in rows if len(row) != 3 or not _are_numbers(row)), None)
    if wrong is not None or not rows:
        got = "none" if wrong is None else ",".join(wrong)
        raise InputError(
            f"{path}: expected rows of three numbers LAO,CRA,CAU in degrees, got {got}; RAO is a "
            "negative LAO."
        )
    return tuple((float(row[0]), float(row[1]), float(row[2])) for row in rows)


def _are_numbers(row: list[str]) -> bool:
    try:
        [float(value) for value in row]
    except ValueError:
        return False
    return True
