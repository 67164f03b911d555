"""Wishes for views as the entry of a document, as it is edited."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..view import ViewWishes
from .typed import from_document, to_document

ViewsEntry = Mapping[str, Any] | None
"""Fields of `ViewWishes` with their values of JSON; None or empty where all is as usual."""


def views_entry(wishes: ViewWishes | None) -> dict[str, Any] | None:
    """The entry of wishes."""
    return None if wishes is None else to_document(wishes) or None


def views_of(entry: ViewsEntry) -> ViewWishes | None:
    """Wishes of an entry; None where all is as usual, and of a view with one angle the other is 0.

    `InputError` for angles that no arm has.
    """
    if not entry:
        return None
    given, angles = dict(entry), ("lao", "cra")
    if any(given.get(name) is not None for name in angles):
        given |= {name: given.get(name) or 0.0 for name in angles}
    return from_document(ViewWishes, given, "views")
