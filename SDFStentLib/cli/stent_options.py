"""The options that say which stent it is."""

from __future__ import annotations

import argparse

from ..stent import KEPT
from .argument_types import number, path, whole


def add_size(group: argparse._ActionsContainer) -> None:
    """How wide, or which device: what everyone needs."""
    group.add_argument(
        "--diameter",
        type=number,
        metavar="D",
        help="of the lumen that is deployed, mm; with --recoil of the balloon",
    )
    add_device_name(group)


def add_stent(command: argparse.ArgumentParser) -> None:
    """How it gets there, beside `add_size`."""
    stent = command.add_argument_group("stent")
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
    add_device_more(stent)
    stent.add_argument(
        "--shortened",
        action="store_true",
        help="deploy it also where less than half of it can lie on the vessel",
    )
    stent.add_argument(
        "--keep",
        choices=KEPT,
        help="what stays where it is when the stent shortens (default its center, or the end by "
        "which it is placed)",
    )


def add_shape(command: argparse.ArgumentParser) -> None:
    """Where a stent is no cylinder."""
    shape = command.add_argument_group("shape")
    shape.add_argument("--waist", type=number, metavar="D", help="where it stays narrow, mm")
    shape.add_argument(
        "--waist-position",
        type=number,
        metavar="F",
        help="part of the length from the proximal end (default: where the vessel is narrowest)",
    )
    shape.add_argument(
        "--waist-length", type=number, metavar="MM", help="of the waist (default: of the stent)"
    )
    for name, end in (("start", "proximal"), ("end", "distal")):
        shape.add_argument(
            f"--flare-{name}",
            type=number,
            nargs=2,
            metavar=("D", "MM"),
            help=f"diameter of the {end} end, wider or narrower, and over which length",
        )
    shape.add_argument(
        "--profile",
        type=path,
        metavar="F",
        help="CSV with rows fraction,diameter in place of --diameter",
    )
    shape.add_argument(
        "--cap-height",
        type=number,
        metavar="F",
        default=1.0,
        help="how far it pushes beyond its ends, over the radius: 1 is half a sphere (default 1)",
    )


def add_device_name(group: argparse._ActionsContainer) -> None:
    """Which device."""
    group.add_argument(
        "--device", type=path, metavar="NAME", help="one of `sdfstent devices`; sets its lengths"
    )


def add_device_more(stent: argparse._ActionsContainer) -> None:
    """Where devices are, and what one loses of its length."""
    add_device_table(stent)
    stent.add_argument(
        "--foreshortening",
        type=number,
        metavar="F",
        help="part of the length that is lost on expansion (default: that of the device, 0.1 with "
        "--length and no device, else 0)",
    )


def add_device_table(group: argparse._ActionsContainer) -> None:
    """Where rows of the user's own are."""
    group.add_argument(
        "--device-table", type=path, metavar="F", help="JSON with devices of your own, too"
    )


def add_wishes(command: argparse.ArgumentParser) -> None:
    """Which lesion, how wide and how long beside it, and the plan to write."""
    command.add_argument(
        "-o", "--output", type=path, metavar="PLAN", help="to write (default SURFACE_plan.json)"
    )
    command.add_argument(
        "--lesion",
        type=whole,
        metavar="N",
        action="append",
        help="numbered as `measure` lists them; may be repeated (default 1, the tightest)",
    )
    command.add_argument(
        "--ratio",
        type=number,
        metavar="R",
        default=1.0,
        help="lumen over the smaller healthy vessel beside the lesion (default 1)",
    )
    command.add_argument(
        "--margin",
        type=number,
        metavar="MM",
        default=0.0,
        help="how far beyond both ends of the lesion (default 0)",
    )
    add_device_name(command)
    add_device_more(command)
