"""The options that say how a stent is deployed."""

from __future__ import annotations

import argparse

from ..plan import Plan, method_parameters, plan_of_method
from .argument_types import number


def add_method(command: argparse.ArgumentParser) -> None:
    """How it is deployed: the parameters of the method that have an option, in their order."""
    group = command.add_argument_group("method")
    for name, parameter in method_parameters().items():
        if not parameter.option:
            continue
        option, default = f"--{parameter.option}", Plan().method[name]
        if parameter.names:
            words = f"{parameter.does} (default {default})"
            group.add_argument(
                option, dest=name, choices=parameter.names, default=default, help=words
            )
        elif parameter.least is None:
            words = f"do not {parameter.does}"
            group.add_argument(option, dest=name, action="store_false", help=words)
        else:
            told = [parameter.unit, "" if default is None else f"default {default:g}"]
            words = f"{parameter.does} ({', '.join(filter(None, told))})"
            metavar = parameter.unit.upper() or "F"
            group.add_argument(
                option, dest=name, type=number, metavar=metavar, default=default, help=words
            )


def method_of(options: argparse.Namespace) -> Plan:
    """A plan without stents and files, with the parameters that were asked for."""
    parameters = method_parameters().items()
    return plan_of_method({name: getattr(options, name) for name, one in parameters if one.option})
