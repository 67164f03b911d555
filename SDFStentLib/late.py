"""Names and modules that are imported when they are first asked for."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def late_names(
    package: str, names_by_module: Mapping[str, Sequence[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names lie in its modules.

    Parameters
    ----------
    package : str
        `__name__` of the package.
    names_by_module : mapping of str to sequence of str
        For every module, relative to the package, the names that are taken from it.
    """
    module_of = {name: module for module, names in names_by_module.items() for name in names}

    def late(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f".{module_of[name]}", package), name)

    def table() -> list[str]:
        return sorted(sys.modules[package].__all__)

    return late, table


def postpone(name: str) -> None:
    """Let a module of a package be executed when something in it is first asked for.

    For a module that another package imports with all that its parent has, and that nobody uses.
    One that is imported already, or is not there, stays as it is.
    """
    parent, _, own = name.rpartition(".")
    spec = None if name in sys.modules else importlib.util.find_spec(name)
    if spec is None or spec.loader is None:
        return
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    setattr(sys.modules[parent], own, module)
