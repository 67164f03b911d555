"""What a word of the command line is taken for."""

from __future__ import annotations

import argparse


def number(text: str) -> float:
    """A number."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r}") from None


def whole(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a whole number, got {text!r}") from None


def path(text: str) -> str:
    """The name of a file, a folder or a device."""
    # Nothing would be taken for the working folder, or for an option that is left out.
    if not text:
        raise argparse.ArgumentTypeError("expected a file or folder, got nothing")
    return text
