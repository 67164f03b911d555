"""Options that mean the same in several commands."""

from __future__ import annotations

import argparse
from typing import Any

from ..units import MILLIMETERS
from .argument_types import number, path


def add_surface(command: argparse.ArgumentParser) -> None:
    """The vessel, which comes first."""
    command.add_argument("surface", type=path, metavar="SURFACE", help="VTP, VTK, STL, PLY or OBJ")


def add_point(group: argparse._ActionsContainer, name: str, what: str, **more: Any) -> None:
    """A point in the unit and frame of the files."""
    # `options.from` is no Python.
    dest = "from_point" if name == "from" else name
    group.add_argument(
        f"--{name}", dest=dest, type=number, nargs=3, metavar=("X", "Y", "Z"), help=what, **more
    )


def add_points(group: argparse._ActionsContainer, name: str, what: str) -> None:
    """Points, each by an option of its own; none by default."""
    add_point(group, name, what, action="append", default=[])


def add_vessel_marks(place: argparse._ActionsContainer) -> None:
    """What the user marks on the vessel: its proximal end, and where it is healthy."""
    add_point(
        place,
        "root",
        "the end of the centerline near this point is proximal (default: the tree tells)",
    )
    add_points(
        place,
        "reference",
        "healthy vessel that the lesion beside it is measured against; once or twice",
    )


def add_units(group: argparse._ActionsContainer) -> None:
    """The unit of the files."""
    group.add_argument(
        "--units", choices=list(MILLIMETERS), default="mm", help="of the files (default mm)"
    )


def add_json(command: argparse.ArgumentParser) -> None:
    """Numbers for a program."""
    command.add_argument("--json", action="store_true", help="print JSON instead of sentences")


def add_talk(command: argparse.ArgumentParser, *, verbose: bool = False) -> None:
    """How much is said; `verbose` where not all of it is said at once."""
    if verbose:
        command.add_argument("--verbose", action="store_true", help="say all of it")
    command.add_argument("--quiet", action="store_true", help="say nothing but errors")
    command.add_argument("--debug", action="store_true", help="show where an error came from")
