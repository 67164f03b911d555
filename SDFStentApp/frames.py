"""The times at which frames are drawn: one at a time, coarse ones while something moves, a sharp
one when it rests."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import Any, Protocol

from trame_rca.encoders import RcaImageEncoder

MOST_FRAMES_PER_S = 30.0
MOVING_QUALITY, STILL_QUALITY = 60, 90
"""Quality of the JPEG, percent."""

TURNS_TO_BEGIN = 3
"""Turns of the event loop that two timers without delay need: one tells the session of a change,
the other begins its work."""

STILL_AFTER_S = 0.4
"""The view rests when nothing has moved for this time: with a shorter one, a slow machine would
draw sharp frames in between."""


class Drawn(Protocol):
    """The view whose frames are drawn."""

    def picture(self, isCoarse: bool) -> tuple[Any, int, int]:
        """The colors (rows, columns, 3), the number of columns and the number of rows."""
        ...


class FrameScheduler:
    """A render scheduler of trame-rca, made with a running event loop.

    A frame is drawn by the event loop, encoded beside it, and sent before the next one is drawn:
    who waits for `isBehind` to end before the next change never makes pictures that nobody sees.
    `on_frame()` is called before one is drawn, and what it begins in the next two turns of the
    event loop goes on beside the drawing; `count` is how often that was.
    """

    target_fps = MOST_FRAMES_PER_S

    def __init__(self, rca: Drawn, on_frame: Callable[[], None] = lambda: None) -> None:
        self.rca, self.count, self._on_frame = rca, 0, on_frame
        self._push: Callable[[bytes, dict[str, Any]], None] | None = None
        self._wanted, self._isDrawing = asyncio.Event(), False
        self._task = asyncio.ensure_future(self._run())

    @property
    def isBehind(self) -> bool:
        """Whether a change has not been sent yet."""
        return self._wanted.is_set() or self._isDrawing

    def set_push_callback(self, callback: Callable[[bytes, dict[str, Any]], None]) -> None:
        """Send frames with this function."""
        self._push = callback

    def schedule_render(self) -> None:
        """Draw a frame soon, because something looks different."""
        self._wanted.set()

    def reset(self) -> None:
        """Do nothing: no picture depends on the one before."""

    async def close(self) -> None:
        """Draw no more."""
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        # Ends with `close`.
        while True:
            await self._wanted.wait()
            # Ends when nothing has moved for a while.
            while self._wanted.is_set():
                begun = loop.time()
                await self._begin()
                await self._frame(isCoarse=True)
                await asyncio.sleep(max(0.0, begun + 1 / self.target_fps - loop.time()))
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._wanted.wait(), STILL_AFTER_S)
            await self._frame(isCoarse=False)

    async def _begin(self) -> None:
        self.count += 1
        self._on_frame()
        for _turn in range(TURNS_TO_BEGIN):
            await asyncio.sleep(0)

    async def _frame(self, isCoarse: bool) -> None:
        self._wanted.clear()
        self._isDrawing = True
        quality = MOVING_QUALITY if isCoarse else STILL_QUALITY
        try:
            picture = self.rca.picture(isCoarse)
            encode = RcaImageEncoder.TURBO_JPEG.encode
            content, about, _ = await asyncio.to_thread(encode, *picture, quality)
            if self._push is not None:
                self._push(content, about)
        except Exception:
            logging.exception("A frame could not be drawn.")  # the next one may be
        finally:
            self._isDrawing = False
