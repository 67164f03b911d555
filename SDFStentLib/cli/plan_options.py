"""Options of the commands that carry out plans."""

from __future__ import annotations

import argparse

from .argument_types import path


def add_comparison(command: argparse.ArgumentParser) -> None:
    """The options of `compare`."""
    command.description = (
        "Carry out several plans of one patient and show them side by side: what every plan does "
        "to lumen, lesions, branches and wall, with pictures by one camera, on one page."
    )
    command.add_argument(
        "plans", type=path, nargs="+", metavar="PLAN", help="two or more; JSON, see docs/plan.md"
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="DIR|PAGE.html",
        required=True,
        help="page to write, or folder for page and JSON",
    )
    add_acceptance(command)
    command.add_argument(
        "--picture", type=path, metavar="F", help="before and after every plan, as .png"
    )
    add_hiding(command)
    command.add_argument("--json", action="store_true", help="print JSON instead of sentences")


def add_acceptance(command: argparse.ArgumentParser) -> None:
    """Files that are not those of a plan."""
    command.add_argument(
        "--accept-changed-inputs",
        action="store_true",
        help="go on although a file is not the one that the plan was made with",
    )


def add_device_file(group: argparse._ActionsContainer) -> None:
    """The stents as they are drawn."""
    group.add_argument(
        "--export-device", type=path, metavar="F", help="rings and struts of the stents, as .vtp"
    )
    group.add_argument(
        "--device-mesh",
        type=path,
        metavar="F",
        help="with --export-device: this straight mesh, along z and centered, laid along the axis",
    )
    add_hiding(group)


def add_hiding(group: argparse._ActionsContainer) -> None:
    """Pictures without what no product looks like."""
    group.add_argument(
        "--hide-device", action="store_true", help="pictures without the struts of the stents"
    )
