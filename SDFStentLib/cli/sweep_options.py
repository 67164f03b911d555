"""The options of `sweep`."""

from __future__ import annotations

import argparse

from .argument_types import number, path, whole
from .common_options import add_talk


def add_sweep(command: argparse.ArgumentParser) -> None:
    """The options of `sweep`."""
    command.description = (
        "Carry out many deployments: the cases of a sweep document, on all cores or on a Dask "
        "cluster. Run again it goes on where it was interrupted. Exit codes: 0 every case is done "
        "and certified; 3 some are not certified; 4 some failed, or the sweep had to stop; 130 "
        "interrupted. What is whole is always kept."
    )
    command.add_argument(
        "sweep", type=path, nargs="?", metavar="SWEEP", help="JSON, see docs/cohorts.md"
    )
    command.add_argument("-o", "--output", type=path, metavar="DIR", help="folder of the cohort")
    command.add_argument(
        "--workers", type=whole, metavar="N", help="processes (default: one per core)"
    )
    command.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster, such as tcp://host:8786"
    )
    command.add_argument(
        "--time-limit",
        type=number,
        metavar="S",
        help="seconds for each case on this machine: then its worker is ended, and it has failed "
        "(default: that of the document, or none)",
    )
    command.add_argument(
        "--dry-run",
        action="store_true",
        help="tell how many cases, the first ones, and how long and large it will be",
    )
    command.add_argument(
        "--table", type=path, metavar="DIR", help="write the manifest of a cohort again"
    )
    command.add_argument(
        "--status", type=path, metavar="DIR", help="how far the sweep in a folder is"
    )
    add_talk(command)
