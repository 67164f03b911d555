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
    command.add_argument("--json", action="store_true", help="print JSON instead of sentences")


def add_acceptance(command: argparse.ArgumentParser) -> None:
    """Files that are not those of a plan."""
    command.add_argument(
        "--accept-changed-inputs",
        action="store_true",
        help="go on although a file is not the one that the plan was made with",
    )
