"""Names of a package that are imported when they are first asked for."""

from __future__ import annotations

import importlib
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
