"""The options of `app`."""

from __future__ import annotations

import argparse

from .argument_types import number, path, whole
from .common_options import add_talk, add_units


def add_app(command: argparse.ArgumentParser) -> None:
    """Add them to a command."""
    command.description = (
        "Serve the panel of the Slicer module as a page for the browser, to this machine only "
        "unless told otherwise. Ctrl-C ends it."
    )
    command.add_argument(
        "input", type=path, metavar="SURFACE|PLAN.json", nargs="?", help="what a page begins with"
    )
    command.add_argument("--centerline", type=path, metavar="F", help="of the surface")
    add_units(command)
    command.add_argument(
        "--demo", action="store_true", help="begin with a synthetic patient instead"
    )
    command.add_argument(
        "--folder",
        type=path,
        metavar="DIR",
        action="append",
        default=[],
        help="whose files pages may open, with those below; may be repeated. Without one: none",
    )
    serving = command.add_argument_group("server")
    serving.add_argument(
        "--host", default="127.0.0.1", help="address to listen at (default 127.0.0.1)"
    )
    serving.add_argument(
        "--port", type=whole, metavar="N", default=0, help="0, the default: one that is free"
    )
    serving.add_argument(
        "--no-browser", action="store_true", help="only say the address, which has a secret in it"
    )
    serving.add_argument(
        "--pages", type=whole, metavar="N", default=8, help="open at the same time (default 8)"
    )
    serving.add_argument(
        "--keep",
        type=number,
        metavar="S",
        default=30.0,
        help="that a closed page waits to be opened again (default 30)",
    )
    add_talk(command)
