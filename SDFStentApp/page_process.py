"""The process behind a page, as the server sees it: it is started, waited for,
visited and ended."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
import signal
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

from aiohttp import web

from SDFStentLib.interpreter import own_program

READY_WITHIN_S = 90.0
FIRST_VISIT_WITHIN_S = 120.0
END_WITHIN_S = 3.0
ALLOCATION = {
    "MALLOC_ARENA_MAX": "2",
    "MALLOC_TRIM_THRESHOLD_": "1000000",
    "MALLOC_MMAP_THRESHOLD_": "1000000",
    "OMP_NUM_THREADS": "1",
}
"""Environment of the process. Otherwise each of its many short threads would hold on to memory
that it has freed; and pages share the processors already. Arrays of less than a megabyte, of which
a preview makes hundreds, are reused."""


class PageProcess:
    """The process of one page, made with a running event loop: it gets ready, and opens its files
    when it is `wanted`.

    `on_end(page)` is called once, when it has ended, by itself or by `end`.
    """

    def __init__(
        self, opening: dict[str, Any], kept_s: float, on_end: Callable[[PageProcess], None]
    ) -> None:
        self.name, self.secret = secrets.token_urlsafe(9), secrets.token_urlsafe(24)
        self._kept_s, self._on_end = kept_s, on_end
        self._process: asyncio.subprocess.Process | None = None
        self._workshop = tempfile.TemporaryDirectory(prefix="sdfstent-page-")
        self._starting = asyncio.ensure_future(_started(self._workshop.name))
        self._visitors: list[web.WebSocketResponse] = []
        self._leaving: asyncio.TimerHandle | None = None
        loop = asyncio.get_running_loop()
        self._port: asyncio.Future[int] = loop.create_future()
        self._is_wanted = asyncio.Event()
        self._opening = {**opening, "secret": self.secret}
        self._life = asyncio.ensure_future(self._live())

    def wanted(self, opening: dict[str, Any]) -> None:
        """Show the page, with more settings for its opening; the process ends unless a browser
        visits it soon."""
        self._opening |= opening
        self._is_wanted.set()
        self._leave_after(FIRST_VISIT_WITHIN_S)

    async def port(self) -> int:
        """The port on which the process listens. Raises `RuntimeError` with a sentence if it could
        not start."""
        return await asyncio.shield(self._port)

    @contextlib.contextmanager
    def visited(self, browser: web.WebSocketResponse) -> Iterator[None]:
        """Count a browser as connected to the page within the block."""
        self._visitors.append(browser)
        if self._leaving is not None:
            self._leaving.cancel()
        try:
            yield
        finally:
            self._visitors.remove(browser)
            if not self._visitors:
                self._leave_after(self._kept_s)

    async def leave_others(self, browser: web.WebSocketResponse) -> None:
        """Disconnect all other browsers, since the picture has the size of one window."""
        others = [other for other in self._visitors if other is not browser and other.prepared]
        await asyncio.gather(*(other.close() for other in others))

    async def end(self) -> None:
        """End the process and wait until it is gone."""
        # A start that is given up half-way leaves a child that nobody waits for.
        await asyncio.wait([self._starting])
        if self._starting.exception() is None:
            process = self._starting.result()
            assert process.stdin is not None
            if self._process is None or not self._is_wanted.is_set():
                kill(process)  # it has not been told anything yet
            process.stdin.close()
            done, _ = await asyncio.wait([self._life], timeout=END_WITHIN_S)
            if not done:
                kill(process)
        await asyncio.gather(self._life, return_exceptions=True)

    def _leave_after(self, seconds: float) -> None:
        def leave() -> None:
            self._ending = asyncio.ensure_future(self.end())

        self._leaving = asyncio.get_running_loop().call_later(seconds, leave)

    async def _live(self) -> None:
        try:
            self._process = process = await asyncio.shield(self._starting)
            assert process.stdin is not None
            assert process.stdout is not None
            ended = asyncio.ensure_future(process.wait())
            wanted = asyncio.ensure_future(self._is_wanted.wait())
            await asyncio.wait([ended, wanted], return_when=asyncio.FIRST_COMPLETED)
            wanted.cancel()
            if not ended.done():
                process.stdin.write(json.dumps(self._opening).encode() + b"\n")
            await self._become_ready(process)
            await process.wait()
        finally:
            await self._over()

    async def _become_ready(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        try:
            line = await asyncio.wait_for(process.stdout.readline(), READY_WITHIN_S)
            self._port.set_result(int(line))
        except (ValueError, asyncio.TimeoutError):
            self._port.set_exception(
                RuntimeError(
                    "The page could not be started; the terminal of sdfstent app says why."
                )
            )
            self._port.exception()  # nobody may have asked yet
            kill(process)

    async def _over(self) -> None:
        """Clean up after the process has ended for whatever reason, and notify the server."""
        if self._leaving is not None:
            self._leaving.cancel()
        if self._process is not None and self._process.returncode is None:
            kill(self._process)
            await self._process.wait()
        self._workshop.cleanup()
        if not self._port.done():
            self._port.set_exception(RuntimeError("The page was closed before it was ready."))
            self._port.exception()
        self._on_end(self)


def kill(process: asyncio.subprocess.Process) -> None:
    """Kill a process by its number: `Process.kill` may reap a process that has ended by itself
    before asyncio does, which then warns."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(process.pid, getattr(signal, "SIGKILL", signal.SIGTERM))


async def _started(workshop: str) -> asyncio.subprocess.Process:
    """Start the process in a session of its own: Ctrl-C in the terminal reaches only the server,
    which then ends the process.

    Its own temporary files are in the `workshop`.
    """
    command, environment = own_program("SDFStentApp.process")
    return await asyncio.create_subprocess_exec(
        *command,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        cwd=workshop,  # Python looks for modules there, too
        env={**ALLOCATION, **environment, "TMPDIR": workshop},
        start_new_session=True,
    )
