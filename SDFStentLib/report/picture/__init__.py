"""Pictures of the vessel before and after, drawn by VTK in a process of its own."""

from __future__ import annotations

from .alternatives import alternatives_picture
from .picture import before_after_picture

__all__ = ["alternatives_picture", "before_after_picture"]


def __dir__() -> list[str]:
    return __all__
