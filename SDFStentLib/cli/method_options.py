"""The options that say how a stent is deployed."""

from __future__ import annotations

import argparse

from ..plan import Plan
from .argument_types import number

_DEFAULTS = Plan().settings


def add_method(command: argparse.ArgumentParser) -> None:
    """How it is deployed."""
    method = command.add_argument_group("method")
    for name, default, what in (
        ("influence", _DEFAULTS.influence_distance, "distance at which the deformation ends, mm"),
        ("smoothing", _DEFAULTS.smoothing_width, "width of the smooth minimum, mm"),
        ("capsule", _DEFAULTS.capsule_length, "length of a capsule, mm"),
        ("tissue-gap", _DEFAULTS.tissue_gap, "kept between the stent and other lumens' walls, mm"),
    ):
        method.add_argument(
            f"--{name}",
            type=number,
            metavar="MM",
            default=default,
            help=f"{what} (default {default:g})",
        )
    longest = {
        rule: _DEFAULTS.with_changes(rule=rule).step_rule().step for rule in _DEFAULTS.names["rule"]
    }
    steps = ", ".join(f"{step:g} with {rule}" for rule, step in longest.items())
    method.add_argument("--step", type=number, metavar="MM", help=f"radius step (default {steps})")
    method.add_argument("--falloff", choices=_DEFAULTS.names["falloff"], default=_DEFAULTS.falloff)
    method.add_argument("--blend", choices=_DEFAULTS.names["blend"], default=_DEFAULTS.blend)
    method.add_argument(
        "--smooth-axis",
        type=number,
        metavar="MM",
        default=_DEFAULTS.axis_smoothing,
        help="smooth the axis over that length first, such as a hand-drawn or shaky one",
    )
    method.add_argument(
        "--straighten",
        type=number,
        metavar="F",
        default=0.0,
        help="share of its bends that the axis loses, 0 to 1, its length kept",
    )
    method.add_argument("--rule", choices=_DEFAULTS.names["rule"], default=_DEFAULTS.rule)
    method.add_argument(
        "--no-compensation",
        action="store_true",
        help="bring only the vertices, not the lumen, to the prescribed diameter",
    )
