"""The options that say which stent it is."""

from __future__ import annotations

import argparse

from ..stent import KEPT
from .argument_types import number, path


def add_stent(command: argparse.ArgumentParser) -> None:
    """Which stent, how wide, and how it gets there."""
    stent = command.add_argument_group("stent")
    stent.add_argument(
        "--diameter",
        type=number,
        metavar="D",
        help="of the lumen that is deployed, mm; with --recoil of the balloon",
    )
    stent.add_argument(
        "--balloon",
        type=number,
        metavar="D",
        help="of the balloon, mm; the lumen is what recoil leaves of it",
    )
    stent.add_argument(
        "--recoil",
        type=number,
        metavar="F",
        help="part of the balloon's diameter that is lost (default with --balloon: 0.07, or 0.1 in "
        "a lumen below 3 mm or of less than a third of the balloon)",
    )
    stent.add_argument(
        "--redilate", type=number, metavar="D", help="then dilate the same stent to D, mm"
    )
    stent.add_argument(
        "--device", type=path, metavar="NAME", help="one of `sdfstent devices`; sets its lengths"
    )
    add_device_table(stent)
    stent.add_argument(
        "--foreshortening",
        type=number,
        metavar="F",
        help="part of the length that is lost on expansion (default: that of the device, 0.1 with "
        "--length and no device, else 0)",
    )
    stent.add_argument(
        "--keep",
        choices=KEPT,
        help="what stays where it is when the stent shortens (default its center, or the end by "
        "which it is placed)",
    )


def add_device_table(group: argparse._ActionsContainer) -> None:
    """Where rows of the user's own are."""
    group.add_argument(
        "--device-table", type=path, metavar="F", help="JSON with devices of your own, too"
    )
