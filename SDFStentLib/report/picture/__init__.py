"""A picture of the vessel before and after."""

from __future__ import annotations

from .picture import render_before_after

__all__ = [
    "render_before_after",
]


def __dir__() -> list[str]:
    return __all__
