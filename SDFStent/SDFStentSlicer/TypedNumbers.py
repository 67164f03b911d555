"""Numbers that are typed: with a comma as with a point, and refused with a sentence rather than by cutting what does not fit."""

import math

import slicer

from SDFStentLib.validation import InputError


class TypedNumbers:
    """Watches all spin boxes of a panel. `attempt(action)` says why where an action raises.

    By itself a spin box takes no key that would lead beyond its ends, nor the comma of half the world: "7,5" became 7, "99" 9.
    """

    def __init__(self, panel, attempt):
        self._boxes = [
            TypedNumber(edit, attempt)
            for edit in slicer.util.findChildren(panel, className="QLineEdit")
            if edit.parent().property("singleStep") is not None
        ]


class TypedNumber:
    """A spin box and what is typed into its `edit`."""

    def __init__(self, edit, attempt):
        self._edit, self._box, self._attempt = edit, edit.parent(), attempt
        self._typed = None
        edit.setValidator(None)
        # Else every digit is a value of its own, and "99" has set 9 before it is refused.
        self._box.setProperty("keyboardTracking", False)
        edit.textEdited.connect(self._onTyped)
        self._box.editingFinished.connect(self._onFinished)

    def _onTyped(self, text):
        self._typed = text.replace(",", ".")
        if text != self._typed:
            at = self._edit.property("cursorPosition")
            self._edit.setText(self._typed)
            self._edit.setProperty("cursorPosition", at)

    def _onFinished(self):
        typed, self._typed = self._typed, None
        if typed is not None:
            self._attempt(lambda: self._take(typed))

    def _take(self, typed):
        value = self._numberOf(typed)
        least, most = (self._box.property(name) for name in ("minimum", "maximum"))
        if value is None or not least <= value <= most:
            unit, got = self._box.property("suffix"), self._wordsOf(typed)
            if value is not None:
                got = f"{value:g}{unit}"
            raise InputError(
                f"Expected {least:g} to {most:g}{unit}, got {got or 'nothing'}; it stays {self._box.property('value'):g}{unit}."
            )
        if self._box.property("value") != value:
            self._box.setProperty("value", value)

    def _numberOf(self, typed):
        """Number that was typed; None for what is none. A special text stands for the least one."""
        if typed.strip() == self._box.property("specialValueText").strip() != "":
            return self._box.property("minimum")
        try:
            value = float(self._wordsOf(typed))
        except ValueError:
            return None
        return value if math.isfinite(value) else None

    def _wordsOf(self, typed):
        """Text that was typed, without units: that of the box stays when all else is deleted, and one may have been typed."""
        text, unit = typed.strip(), self._box.property("suffix").strip()
        # Ends: every turn takes some of the text.
        while unit and text.endswith(unit):
            text = text.removesuffix(unit).rstrip()
        return text
