"""Changes that follow from a value of a stent that is set: with a balloon its lumen, and so on.

All functions take the `Draft` of the stent and give changes of it: values by their paths in its
entry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ..stent import (
    USUAL_RECOIL,
    Balloon,
    Device,
    Shape,
    Stent,
    balloon_by_rule,
    balloon_leaving,
)
from .draft import Draft
from .paths import value_at
from .typed import to_document

Changes = dict[str, Any]
"""Values by their paths in the entry of a stent."""

NOT_KNOWN = float("nan")


def set_value(draft: Draft, path: str, value: Any) -> Changes:
    """Changes by setting a value: the value, and its consequences."""
    return _SET[path](draft, value) if path in _SET else {path: value}


def value_in_use(draft: Draft, path: str) -> Any:
    """Value in use at a path of its entry."""
    return _IN_USE[path](draft) if path in _IN_USE else value_at(draft.entry, path)


def with_device(draft: Draft, device: Device | None) -> Changes:
    """Changes for a device: the stent has its length and shortens so; its own length is kept."""
    if device is not None:
        return {"device": to_document(device), "device_shortening": True}
    usual = {"foreshortening_fraction": draft.usual_foreshortening}
    return {"device": None, "device_shortening": False, **usual}


def shaped(_draft: Draft, shape: Shape | None) -> Changes:
    """Changes for a shape, whose table says how wide it is; a plain one is a cylinder."""
    if shape is None or shape == Shape():
        return {"shape": None}
    wide = {"diameter": max(row[1] for row in shape.table)} if shape.table else {}
    return {"shape": to_document(shape), **wide}


def inflated(draft: Draft, diameter: float | None, recoil: float | None = None) -> Changes:
    """Expanded by a balloon, mm, whose recoil is given or by the rule; by none without one.

    By the rule it has that of the balloon before, or the usual one, until `in_lumen`.
    """
    if diameter is None:
        return {"balloon": None}
    former = draft.balloon
    if recoil is not None:
        return _left_by(Balloon(diameter, recoil))
    if former is None or former.is_given:
        return _left_by(balloon_by_rule(diameter, NOT_KNOWN))
    return _left_by(replace(former, diameter=diameter))


def by_rule(draft: Draft) -> tuple[Any, ...] | None:
    """Values that decide the recoil of its balloon; None where no rule chooses that."""
    balloon, entry = draft.balloon, draft.entry
    if balloon is None or balloon.is_given:
        return None
    wide = (entry["diameter"], None) if draft.is_lumen_set else (None, balloon.diameter)
    how = entry["foreshortening_fraction"], entry["whole_curve"], draft.length
    return (*wide, *how, str(entry["placement"]))


def with_usual_recoil(draft: Draft, place: Mapping[str, Any] | None) -> Stent:
    """The stent at a place, as the rule measures the lumen there: before its recoil is known.

    `InputError` as of `Draft.at`.
    """
    assert draft.balloon is not None
    usual = balloon_by_rule(draft.balloon.diameter, NOT_KNOWN)
    stent = draft.at(place)
    return replace(stent, diameter=usual.lumen_diameter, balloon=usual, shape=None)


def in_lumen(draft: Draft, lumen: float) -> Changes:
    """Changes of its balloon by the rule in a lumen, mm; none where it fits already.

    Where its own lumen was set last, that stays, and the balloon is the one that leaves it.
    """
    balloon = draft.balloon
    assert balloon is not None
    if not draft.is_lumen_set:
        found = balloon_by_rule(balloon.diameter, lumen)
        return {} if found == balloon else _left_by(found)
    found = balloon_leaving(draft.entry["diameter"], lumen)
    if found == balloon:
        return {}
    # Another diameter than it leaves says that the lumen was set.
    kept = draft.entry["balloon"]["diameter"]
    return {"balloon": to_document(replace(found, diameter=kept))}


def _left_by(balloon: Balloon) -> Changes:
    return {"balloon": to_document(balloon), "diameter": balloon.lumen_diameter}


def _balloon(draft: Draft) -> Balloon:
    """The balloon that it has, or would have."""
    lumen = draft.entry["diameter"]
    return draft.balloon or balloon_by_rule(lumen / (1 - USUAL_RECOIL), NOT_KNOWN)


def _switched(draft: Draft, is_used: bool) -> Changes:
    """Changes for a balloon that leaves its lumen, whatever the rule finds there, or for none."""
    if not is_used:
        return inflated(draft, None)
    # No balloon that recoils leaves a lumen of its own width: that counts as set, and stays.
    balloon = replace(_balloon(draft), diameter=draft.entry["diameter"])
    return {"balloon": to_document(balloon)}


def _inflated_to(draft: Draft, diameter: float) -> Changes:
    balloon = draft.balloon
    is_given = balloon is not None and balloon.is_given
    return inflated(draft, diameter, _balloon(draft).recoil_fraction if is_given else None)


def _recoiling(draft: Draft, recoil: float | None) -> Changes:
    return inflated(draft, _balloon(draft).diameter, recoil)


def _by_rule_or_not(draft: Draft, is_by_rule: bool) -> Changes:
    return _recoiling(draft, None if is_by_rule else _balloon(draft).recoil_fraction)


def _capped(draft: Draft, height: float) -> Changes:
    return shaped(draft, replace(draft.shape or Shape(), cap_height=height))


def _tabled(draft: Draft, rows: Any) -> Changes:
    """Settle a profile from a table, which says all diameters."""
    shape = draft.shape or Shape()
    shape = replace(shape, waist=None, start=None, end=None) if rows else shape
    return shaped(draft, replace(shape, table=rows))


def _shortened(_draft: Draft, fraction: float) -> Changes:
    return {"foreshortening_fraction": fraction, "device_shortening": False}


_IN_USE: dict[str, Callable[[Draft], Any]] = {
    "length": lambda draft: draft.length,
    "foreshortening_fraction": lambda draft: draft.foreshortening,
    "balloon": lambda draft: draft.balloon is not None,
    "balloon.diameter": lambda draft: _balloon(draft).diameter,
    "balloon.recoil_fraction": lambda draft: _balloon(draft).recoil_fraction,
    "balloon.by_rule": lambda draft: not _balloon(draft).is_given,
    "shape.cap_height": lambda draft: (draft.shape or Shape()).cap_height,
}
"""Functions for values in use by their paths, where these may differ from the values set."""

_SET: dict[str, Callable[[Draft, Any], Changes]] = {
    "foreshortening_fraction": _shortened,
    "balloon": _switched,
    "balloon.diameter": _inflated_to,
    "balloon.recoil_fraction": _recoiling,
    "balloon.by_rule": _by_rule_or_not,
    "shape.cap_height": _capped,
    "shape.table": _tabled,
}
"""Functions for changes by their paths, where setting a value has consequences."""
