"""The process behind one page: `python -m SDFStentApp.process`, which the server
starts and ends."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

MODULE = Path(__file__).resolve().parents[1] / "SDFStent"
"""The folder of the Slicer module."""

HEADER = "X-SDFStent-Page"
"""Name of the header with the secret, without which this process answers no request."""


def prepare() -> None:
    """Load the modules that every page needs, which takes most of the time of its start."""
    os.environ["WSLINK_READY_MSG"] = ""
    if not os.environ.get("DISPLAY"):
        # Without a screen VTK finds this window by itself, but only after a warning.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    sys.path.append(str(MODULE))
    import_module("SDFStentApp.page")
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


async def run(opening: dict[str, Any], ready: Callable[[int], None]) -> None:
    """Serve one page on a port of this machine until the process ends; `ready` gets the port."""
    from trame.app import get_server

    from .page import Page, Plain

    server = get_server("sdfstent", client_type="vue3", translator=Plain())
    page = Page(server, {**opening, "module": MODULE})
    page.build()
    server.controller.on_server_bind.add(lambda bound: _guard(bound.app, opening["secret"]))
    server.controller.on_server_ready.add(lambda **_: _begin(page, ready))
    await server.start(
        port=0,
        host="127.0.0.1",
        thread=True,  # the signals are the server's that has started this process
        open_browser=False,
        show_connection_info=False,
        disable_logging=True,
        exec_mode="coroutine",
        timeout=0,
    )


def _begin(page: Any, ready: Callable[[int], None]) -> None:
    page.server.controller.rc_area_register(page.view.serve(page.take_edits))
    page.open_named()
    ready(page.server.port)


def _guard(app: Any, secret: str) -> None:
    """Answer only requests with the secret: other users of this machine can reach the port, too."""
    from aiohttp import web

    @web.middleware
    async def checked(request: web.Request, handler: Any) -> Any:
        if request.headers.get(HEADER) != secret:
            raise web.HTTPForbidden(text="This is the inside of SDF Stent.")
        return await handler(request)

    app.middlewares.append(checked)


def main() -> None:
    """Read the page's settings from the first line of stdin, write the port to stdout, and end when
    stdin ends."""
    answer = os.dup(1)
    os.dup2(2, 1)  # whatever others print is no answer

    def ready(port: int) -> None:
        os.write(answer, f"{port}\n".encode())

    def end_with_stdin() -> None:
        sys.stdin.read()
        shutil.rmtree(os.environ["TMPDIR"], ignore_errors=True)  # the server may be gone as well
        os._exit(0)

    prepare()
    line = sys.stdin.readline()
    if not line:
        end_with_stdin()
    threading.Thread(target=end_with_stdin, daemon=True).start()
    sys.argv = sys.argv[:1]
    asyncio.run(run(json.loads(line), ready))


if __name__ == "__main__":
    main()
