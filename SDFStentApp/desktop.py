"""Event loop and desktop of the panel, as the page has them."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from .tables import TableItem


class AsyncTimer:
    """A timer of the module's `Clock`, run by asyncio's event loop; a repeated timer lets all other
    work have its turn."""

    WAIT_S = 0.001
    """Waiting for threads is short: they advance anyway, and best beside the drawing of a frame."""

    TURN_S = (0.002, 0.002)

    def __init__(self, call: Callable[[], Any], milliseconds: float, isRepeated: bool) -> None:
        self._call, self._seconds, self._isRepeated = call, milliseconds / 1000, isRepeated
        self._waiting: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Begin to wait, or begin anew."""
        self.stop()
        self._waiting = asyncio.get_running_loop().call_later(self._seconds, self._run)

    def stop(self) -> None:
        """Cancel the pending call."""
        if self._waiting is not None:
            self._waiting.cancel()
        self._waiting = None

    def isActive(self) -> bool:
        """Whether a call is still to come."""
        return self._waiting is not None

    def _run(self) -> None:
        self._waiting = None
        if self._isRepeated:
            self.start()  # first: the call may stop it
        self._call()


class Shortcut:
    """A key of the panel, which belongs to a widget or to the whole page."""

    def __init__(
        self, key: str, widget: Any, action: Callable[[], Any], is_everywhere: bool
    ) -> None:
        self.key, self._action = key, action
        self._name = None if is_everywhere else widget.objectName
        self._is_enabled = True

    def setEnabled(self, is_enabled: bool) -> None:
        self._is_enabled = is_enabled

    def press(self, name: Any) -> None:
        """Act as the key, pressed in a widget of this name."""
        if self._is_enabled and self._name in (None, name):
            self._action()


class PageDesktop:
    """Files, cells and keys of the page, asked as the panel's `QtDesktop`: the page has asked for a
    file before the panel does, and `answering` sets the answer."""

    _answer = ""

    @classmethod
    @contextlib.contextmanager
    def answering(cls, path: Path) -> Iterator[None]:
        """Answer every question for a file or a folder with this path within the block."""
        cls._answer = str(path)
        try:
            yield
        finally:
            cls._answer = ""

    def openFile(self, *_question: Any) -> str:
        return self._answer

    def openFiles(self, *_question: Any) -> list[str]:
        return [self._answer] if self._answer else []

    saveFile = folder = openFile

    def show(self, path: Any) -> None:
        """Do nothing: the browser keeps and shows what was written."""

    def cell(
        self,
        text: str = "",
        isSelectable: bool = True,
        isEditable: bool = False,
        isChecked: bool | None = None,
    ) -> TableItem:
        return TableItem(text, isEditable, isChecked)

    def isChecked(self, cell: TableItem) -> bool:
        return bool(cell.is_checked)

    def fitColumns(self, table: Any) -> None:
        """Do nothing: the browser fits them."""

    def onKey(
        self, key: str, widget: Any, action: Callable[[], Any], isEverywhere: bool = False
    ) -> Shortcut:
        shortcut = Shortcut(key, widget, action, isEverywhere)
        widget.shortcuts.append(shortcut)
        return shortcut

    def onEvent(self, widget: Any, kind: str, action: Callable[[], Any]) -> Callable[[], None]:
        """Do nothing: size and style of the page are the browser's."""
        return lambda: None

    def layOut(self) -> None:
        """Do nothing: the browser lays the page out."""
