"""Options from parameters: of the method, and of a stent."""

from __future__ import annotations

import argparse
from typing import Any

from ..parameter import Parameter
from ..plan import Plan, method_parameters, plan_of_method
from .argument_types import number


def add_parameter(
    group: argparse._ActionsContainer, parameter: Parameter, default: Any, dest: str = ""
) -> None:
    """The option of a parameter; `dest` is its attribute where that is not the option's name."""
    option = f"--{parameter.option}"
    more: dict[str, Any] = {"dest": dest or parameter.option.replace("-", "_")}
    if not (parameter.names or parameter.is_number):
        words = f"do not {parameter.does}" if default else parameter.does
        group.add_argument(option, action=f"store_{not default}".lower(), help=words, **more)
        return
    told = [parameter.unit, "" if default is None else f"default {default}".removesuffix(".0")]
    words = " ".join([parameter.does, *[f"({', '.join(filter(None, told))})"][: any(told)]])
    if parameter.names:
        group.add_argument(option, choices=parameter.names, default=default, help=words, **more)
    else:
        metavar = parameter.unit.upper() or "F"
        group.add_argument(
            option, type=number, metavar=metavar, default=default, help=words, **more
        )


def add_method(command: argparse.ArgumentParser) -> None:
    """How it is deployed: the parameters of the method that have an option, in their order."""
    group = command.add_argument_group("method")
    for name, parameter in method_parameters().items():
        if parameter.option:
            add_parameter(group, parameter, Plan().method[name], name)


def method_of(options: argparse.Namespace) -> Plan:
    """A plan without stents and files, with the parameters that were asked for."""
    parameters = method_parameters().items()
    return plan_of_method({name: getattr(options, name) for name, one in parameters if one.option})
