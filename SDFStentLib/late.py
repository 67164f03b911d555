"""Names and modules that are imported when they are first asked for."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.machinery import ModuleSpec, PathFinder
from threading import RLock
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from importlib.abc import Loader

_ATTRIBUTE = "__getattr__"


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


class PartlyLate:
    """Finds packages of which some names are taken without all that the others need.

    The names come from the modules of the package that define them. Whatever else is asked of it,
    or where such a module or name is not there, the package is executed as it would be otherwise.

    Parameters
    ----------
    modules : mapping of str to mapping of str to str
        By package: for every name its module, relative to the package.
    """

    def __init__(self, modules: Mapping[str, Mapping[str, str]]) -> None:
        self._modules = modules

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """How to load one of the packages; None for everything else."""
        if name not in self._modules:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and spec.loader is not None:
            # A class of `importlib.abc` would take a hundredth of a second to import.
            spec.loader = cast("Loader", _PartlyLateLoader(spec.loader, self._modules[name]))
        return spec


class _PartlyLateLoader:
    """Executes a package when it is asked for anything but some of its names."""

    def __init__(self, loader: Loader, modules: Mapping[str, str]) -> None:
        self._loader, self._modules = loader, modules
        self._lock, self._is_executing, self._is_executed = RLock(), False, False

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """As without this."""
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Leave the package as it is but for a way to its names."""
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        vars(module)[_ATTRIBUTE] = partial(self._attribute, module)

    def _attribute(self, module: ModuleType, name: str) -> Any:
        if name in self._modules and not self._is_executing:
            with suppress(ImportError, AttributeError):
                own = importlib.import_module(f".{self._modules[name]}", module.__name__)
                return getattr(own, name)
        # Another thread waits here until all of it is there; what is executed itself does not.
        with self._lock:
            if self._is_executing:
                raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
            # Not by the way to names: the package may have put one of its own there meanwhile.
            if not self._is_executed:
                self._execute(module)
        return getattr(module, name)

    def _execute(self, module: ModuleType) -> None:
        ours = vars(module)[_ATTRIBUTE]
        self._is_executing = True
        try:
            self._loader.exec_module(module)
        finally:
            self._is_executing = False
        self._is_executed = True
        if vars(module)[_ATTRIBUTE] is ours:
            del vars(module)[_ATTRIBUTE]
