"""Tables of contents: the public names of a package, said once."""

from __future__ import annotations

import ast
import importlib
import inspect
import sys
from typing import Any


def list_contents(package: str) -> None:
    """Give a package `__all__`, `__dir__` and `__getattr__` by the imports of its own source.

    Public is what it imports as itself, `from .line import cut as cut`, which type checkers take
    for an export, too. What stands under `if TYPE_CHECKING` is imported when it is first asked for.

    Parameters
    ----------
    package : str
        `__name__` of the package.
    """
    module_of: dict[str, str] = {}
    for node in ast.walk(ast.parse(inspect.getsource(sys.modules[package]))):
        if isinstance(node, ast.ImportFrom):
            own = [one.name for one in node.names if one.name == one.asname]
            module_of |= dict.fromkeys(own, f".{node.module}")
    names = sorted(module_of)

    def late(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(importlib.import_module(module_of[name], package), name)

    vars(sys.modules[package]).update(__all__=names, __dir__=lambda: names, __getattr__=late)
