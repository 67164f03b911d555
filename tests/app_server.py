"""`sdfstent app` as a process of its own, for tests."""

import os
import shutil
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from importlib.util import find_spec
from pathlib import Path

import psutil
from child_processes import INTERRUPTIBLE, PATIENCE, PROJECT

IS_APP_INSTALLED = all(map(find_spec, ("slicer", "trame", "trame_rca", "aiohttp")))
"""Looked for only: to import them takes seconds, in every process that collects tests."""
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
"""The browser that looks at its pages; started so that only the page asks for anything."""
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)


class AppServer:
    """The server, started with some arguments; its own temporary files go into `folder`.

    A `browser` is a command that gets the address, as if there were a screen; default: none.
    """

    def __init__(
        self, folder: Path, *arguments: str | Path, browser: str | Path | None = None
    ) -> None:
        self.folder = folder
        folder.mkdir(exist_ok=True)
        # Not a pipe: one that nobody reads would block pages that write much.
        self._said = Path(f"{folder}-said.txt")
        environment = {
            name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
        }
        if browser is None:
            arguments = ("--no-browser", *arguments)
        else:
            environment |= {"BROWSER": str(browser), "WAYLAND_DISPLAY": "of-the-tests"}
        with self._said.open("wb") as said:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "SDFStentLib", "app", *map(str, arguments)],
                cwd=PROJECT,
                env={
                    **environment,
                    "TMPDIR": str(folder),
                    "XDG_STATE_HOME": f"{folder}-state",
                    "OMP_NUM_THREADS": "1",
                },
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
                **INTERRUPTIBLE,
            )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line.startswith("Open http://"), self.said()
        self.address = line.split()[1]
        self.origin, self.token = self.address.rstrip("/").rsplit("/", 1)

    def pages(self) -> list[psutil.Process]:
        """The processes behind its pages, without the one that waits for the next page and listens
        nowhere yet."""
        children = psutil.Process(self.process.pid).children(recursive=True)
        return [child for child in children if child.net_connections()]

    def said(self) -> str:
        """Everything that the server and its pages have written to stderr so far."""
        return self._said.read_text(encoding="utf-8")

    def interrupt(self) -> str:
        """Press Ctrl-C and return what was written."""
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=PATIENCE)
        return self.said()

    def close(self) -> None:
        if self.process.poll() is None:
            self.interrupt()


def get(url: str, **headers: str) -> tuple[int, str, str]:
    """Status, text and final address."""
    request = urllib.request.Request(url, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return answer.status, answer.read().decode(errors="replace"), answer.url
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(errors="replace"), url
