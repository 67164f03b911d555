"""The server of `sdfstent app`: it checks the token, starts a process for every page, and passes
frames and clicks on.

A page is a process with a scene of its own: one that is slow or fails does not affect the others,
and nothing is left of one that is closed.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import logging
import os
import secrets
import signal
import sys
import tempfile
import webbrowser
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import aiohttp
from aiohttp import web

from .chunks import LARGEST_UPLOAD, Chunks
from .kept import KeptPlans
from .page_process import PageProcess
from .process import HEADER

INDEX = "index.html"
LAUNCHER = "paraview/"
"""The address where trame's client first asks for a new process; after an empty answer it uses the
one that has served it."""

KEPT_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    # Vue compiles its templates; whatever a page does, it talks to nobody else.
    "Content-Security-Policy": "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "connect-src 'self' blob: data:; frame-ancestors 'none'; form-action 'self'; base-uri 'self'",
}
WAY = (
    '<!DOCTYPE html><meta http-equiv="refresh" content="0; url={address}"><title>SDF Stent</title>'
)
LARGEST_MESSAGE = 64 * 2**20
HEARTBEAT_S = 30.0
"""Time between two signs of life that a browser has to give."""
NOT_PASSED_ON = {"host", "connection", "upgrade", "cookie", HEADER.lower()}


class ServerSettings(NamedTuple):
    """The settings of the command line. `opening` is what every page begins with."""

    host: str
    port: int
    opens_browser: bool
    kept_s: float
    """Time for which a closed page waits to be opened again."""
    most_pages: int
    plans: Path | None
    """Folder where plans are kept for a day; None: they are not kept."""
    opening: dict[str, Any]


class Server:
    """The server, which answers only addresses below a random token. `say(line)` writes a line for
    the user."""

    def __init__(self, settings: ServerSettings, say: Callable[[str], None]) -> None:
        self.settings, self._say = settings, say
        self.token = secrets.token_urlsafe(24)
        self.pages: dict[str, PageProcess] = {}
        self._kept = KeptPlans(settings.plans)
        self._first: PageProcess | None = None
        self._spare: PageProcess | None = None
        self._client: aiohttp.ClientSession | None = None
        self._way: Path | None = None

    async def run(self, stop: asyncio.Event) -> None:
        """Serve until `stop` is set, and then end all pages."""
        app = web.Application()
        app.router.add_route("*", "/{path:.*}", self._answer)
        runner = web.AppRunner(app, access_log=None, logger=_logger(), shutdown_timeout=1.0)
        await runner.setup()
        try:
            async with aiohttp.ClientSession(auto_decompress=False) as self._client:
                site = web.TCPSite(runner, self.settings.host, self.settings.port)
                await site.start()
                self._begin(runner.addresses[0][1])
                await stop.wait()
        finally:
            await self._end_all()
            await runner.cleanup()

    def _begin(self, port: int) -> None:
        host = f"[{self.settings.host}]" if ":" in self.settings.host else self.settings.host
        address = f"http://{host}:{port}/{self.token}/"
        self._say(f"Open {address}")
        if not _is_loopback(self.settings.host):
            self._say(
                "Other machines can reach it, and what passes can be read on the way: put a proxy with TLS in front of it."
            )
        if self._kept.root is not None:
            self._say(f"Plans are kept for a day in {self._kept.root}")
        self._say("Ctrl-C ends it.")
        self._first = self._start()  # it opens what there is to show while the browser starts
        if self.settings.opens_browser and _has_screen():
            self._show(address)

    def _show(self, address: str) -> None:
        """Open the address with a file that only its owner can read: everybody on this machine sees
        the arguments of a browser."""
        file, name = tempfile.mkstemp(suffix=".html")
        self._way = Path(name)
        with open(file, "w", encoding="utf-8") as way:
            way.write(WAY.format(address=address))
        asyncio.get_running_loop().run_in_executor(None, webbrowser.open, self._way.as_uri())

    def _start(self, name: str = "") -> PageProcess:
        """Start a page, which goes on with the plan of the page `name`."""
        page, self._spare = self._spare or self._prepared(), None
        page.name = name or page.name
        page.wanted({"kept": self._kept.folder(page.name)})
        self.pages[page.name] = page
        return page

    def _prepared(self) -> PageProcess:
        return PageProcess(self.settings.opening, self.settings.kept_s, self._forget)

    def _keep_one_ready(self) -> None:
        if self._spare is None and len(self.pages) < self.settings.most_pages:
            self._spare = self._prepared()

    def _forget(self, page: PageProcess) -> None:
        if self.pages.get(page.name) is page:
            del self.pages[page.name]
        if page is self._first:
            self._first = None
        if page is self._spare:
            self._spare = None

    async def _end_all(self) -> None:
        if self._way is not None:
            self._way.unlink(missing_ok=True)
        left = [*self.pages.values(), self._spare]
        await asyncio.gather(*(page.end() for page in left if page is not None))

    async def _answer(self, request: web.Request) -> web.StreamResponse:
        token, slash, rest = request.match_info["path"].partition("/")
        if not hmac.compare_digest(token.encode(errors="replace"), self.token.encode()):
            return _sentence(
                403, "This address is not complete: use the one that sdfstent app has printed."
            )
        name, _, tail = rest.partition("/")
        page = self.pages.get(name)
        if page is not None:
            try:
                return await self._pass(request, page, tail)
            except _PageHasFailed:
                await page.end()  # a browser may see it before we hear of it
        if tail not in ("", INDEX):
            return _sentence(404, "This page was closed.")
        way = "../" * rest.count("/") if slash else f"{token}/"
        return await self._new_page(way, name if self._kept.has(name) else "")

    async def _new_page(self, way: str, name: str) -> web.StreamResponse:
        """Send the browser to a page of its own; `way` leads to just below the token, behind
        whatever proxy."""
        page = None
        if not name:
            page, self._first = self._first, None
        if page is None and len(self.pages) >= self.settings.most_pages:
            most = self.settings.most_pages
            return _sentence(
                503, f"{most} pages are open, which is as many as there may be: close one."
            )
        page = page or self._start(name)
        try:
            await page.port()
        except RuntimeError as error:
            return _sentence(500, str(error))
        self._keep_one_ready()
        raise web.HTTPFound(f"{way}{page.name}/{INDEX}", headers=KEPT_HEADERS)

    async def _pass(self, request: web.Request, page: PageProcess, tail: str) -> web.StreamResponse:
        """Pass a request on to a page. Raises `_PageHasFailed` if the page cannot be reached."""
        if request.headers.get("Upgrade", "").lower() == "websocket":
            if not _is_own(request):
                return _sentence(403, "Another site has asked for this page.")
            return await self._pass_messages(request, page, tail)
        return await self._pass_answer(request, page, tail or INDEX)

    async def _pass_answer(
        self, request: web.Request, page: PageProcess, tail: str
    ) -> web.StreamResponse:
        assert self._client is not None
        if (request.method, tail) == ("POST", LAUNCHER):
            return web.json_response(None, headers=KEPT_HEADERS)
        if request.method not in ("GET", "HEAD"):
            return _sentence(405, "Pages are only read.")
        headers = _passed_on(request, page)
        with _reaching():
            url = f"http://127.0.0.1:{await page.port()}/{tail}"
            async with self._client.request(
                request.method, url, headers=headers, params=request.query, allow_redirects=False
            ) as found:
                body = await found.read()
        kept = ("Content-Type", "Content-Encoding")
        answer = {key: found.headers[key] for key in kept if key in found.headers}
        return web.Response(status=found.status, body=body, headers={**answer, **KEPT_HEADERS})

    async def _pass_messages(
        self, request: web.Request, page: PageProcess, tail: str
    ) -> web.StreamResponse:
        assert self._client is not None
        browser = web.WebSocketResponse(
            max_msg_size=LARGEST_MESSAGE, compress=False, heartbeat=HEARTBEAT_S
        )
        chunks = Chunks(LARGEST_UPLOAD + LARGEST_MESSAGE)
        with page.visited(browser):
            with _reaching():
                inside = await self._client.ws_connect(
                    f"http://127.0.0.1:{await page.port()}/{tail}",
                    headers={HEADER: page.secret},
                    max_msg_size=LARGEST_MESSAGE,
                )
            try:
                await browser.prepare(request)
                await page.leave_others(browser)
                sent = _pass_on(browser, inside, chunks.are_bounded)
                await _until_one_ends([sent, _pass_on(inside, browser)])
            finally:
                await inside.close()
            await browser.close()
        return browser


class _PageHasFailed(Exception):
    """Raised if a page does not answer any more."""


@contextlib.contextmanager
def _reaching() -> Iterator[None]:
    """Turns connection errors within the block into `_PageHasFailed`. Ask only a page in it: a
    browser that is gone is no fault of the page."""
    try:
        yield
    except (aiohttp.ClientConnectionError, RuntimeError) as error:
        raise _PageHasFailed from error


def _is_own(request: web.Request) -> bool:
    """Whether the request does not come from another site; only browsers name the origin."""
    origin = request.headers.get("Origin")
    return origin is None or origin.partition("://")[2] == request.host


def _logger() -> logging.Logger:
    """The logger of the server, without complaints about clients that do not speak HTTP: they are
    answered anyway."""
    logger = logging.getLogger("sdfstent.app")
    logger.addFilter(
        lambda record: (
            not (
                record.exc_info and isinstance(record.exc_info[1], aiohttp.http.HttpProcessingError)
            )
        )
    )
    return logger


def _passed_on(request: web.Request, page: PageProcess) -> dict[str, str]:
    kept = {k: v for k, v in request.headers.items() if k.lower() not in NOT_PASSED_ON}
    return {**kept, HEADER: page.secret}


async def _pass_on(
    source: Any, target: Any, may_pass: Callable[[bytes], bool] = lambda _data: True
) -> None:
    """Pass messages from one side to the other, as long as both are open and the messages may pass;
    texts are left out, since they mean nothing here."""
    async for message in source:
        if message.type == aiohttp.WSMsgType.BINARY:
            if not may_pass(message.data):
                return
            await target.send_bytes(message.data)


async def _until_one_ends(ways: list[Awaitable[None]]) -> None:
    tasks = [asyncio.ensure_future(way) for way in ways]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _has_screen() -> bool:
    """Whether a browser could open a window: one in the terminal would take that over."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _sentence(status: int, text: str) -> web.Response:
    return web.Response(status=status, text=f"SDF Stent: {text}\n", headers=KEPT_HEADERS)


def serve(settings: ServerSettings, say: Callable[[str], None]) -> None:
    """Serve until Ctrl-C or SIGTERM."""

    async def until_signal() -> None:
        stop = asyncio.Event()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(NotImplementedError):  # Windows
                loop.add_signal_handler(number, stop.set)
        await Server(settings, say).run(stop)

    asyncio.run(until_signal())
