"""The options that say which stent it is."""

from __future__ import annotations

import argparse

from ..parameter import parameters_of
from ..stent import Balloon, Shape, Stent, Waist
from .argument_types import number, path, whole
from .method_options import add_parameter

OF_STENT, OF_BALLOON = parameters_of(Stent), parameters_of(Balloon)


def add_length(group: argparse._ActionsContainer) -> None:
    """How long."""
    add_parameter(group, OF_STENT["length"], None)


def add_size(group: argparse._ActionsContainer) -> None:
    """How wide, or which device: what everyone needs."""
    add_parameter(group, OF_STENT["diameter"], None)
    add_device_name(group)


def add_stent(command: argparse.ArgumentParser) -> None:
    """How it gets there, beside `add_size`."""
    stent = command.add_argument_group("stent")
    for one in OF_BALLOON.values():
        add_parameter(stent, one, None)
    stent.add_argument(
        "--redilate", type=number, metavar="MM", help="then dilate the same stent to it (mm)"
    )
    add_device_more(stent)
    add_parameter(stent, OF_STENT["may_be_shortened"], False)
    add_parameter(stent, OF_STENT["keeps"], None)


def add_shape(command: argparse.ArgumentParser) -> None:
    """Where a stent is no cylinder."""
    shape = command.add_argument_group("shape")
    for one in parameters_of(Waist).values():
        add_parameter(shape, one, None)
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
    add_parameter(shape, parameters_of(Shape)["cap_height"], Shape().cap_height)


def add_device_name(group: argparse._ActionsContainer) -> None:
    """Which device."""
    group.add_argument(
        "--device", type=path, metavar="NAME", help="one of `sdfstent devices`; sets its lengths"
    )


def add_device_more(stent: argparse._ActionsContainer) -> None:
    """Where devices are, and what one loses of its length."""
    add_device_table(stent)
    add_parameter(stent, OF_STENT["foreshortening_fraction"], None)


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
