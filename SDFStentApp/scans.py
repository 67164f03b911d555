"""Segmentations on a page: a process of its own makes the vessel."""

from __future__ import annotations

import asyncio
import json
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from SDFStentLib.interpreter import own_program
from SDFStentLib.validation import DeploymentError, InputError

from .page_process import kill
from .preparing import CENTERLINE, SURFACE


class Scans:
    """Makes a vessel of one segmentation at a time, in new folders of `home`.

    `on_share(share)` hears of what is done, None in the end; `on_labels(words)` of labels to choose
    from; `on_vessel(surface, centerline, said)` of two files and what there is to say of them;
    `on_error(error)` of what was wrong.
    """

    def __init__(
        self,
        home: Path,
        on_share: Callable[[float | None], None],
        on_labels: Callable[[list[str]], None],
        on_vessel: Callable[[Path, Path, str], None],
        on_error: Callable[[Exception], None],
    ) -> None:
        self._home = home
        self._on_share, self._on_labels = on_share, on_labels
        self._on_vessel, self._on_error = on_vessel, on_error
        self._task: asyncio.Task[None] | None = None

    def prepare(self, path: Path, number: int) -> None:
        """Begin with a label by its number among those of the file, -1 for the only one."""
        self.stop()
        self._task = asyncio.ensure_future(self._prepare(path, number))

    def stop(self) -> None:
        """Make no vessel; the process ends at once."""
        if self._task is not None:
            self._task.cancel()
            self._task = None
            self._on_share(None)

    async def _prepare(self, path: Path, number: int) -> None:
        self._on_share(0.0)
        self._home.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder = Path(tempfile.mkdtemp(prefix="scan-", dir=self._home))
        try:
            answer = await self._answer(path, number, folder)
        except Exception as error:
            answer = {"error": error}
        finally:
            if not (folder / CENTERLINE).is_file():
                shutil.rmtree(folder, ignore_errors=True)
        self._task = None
        self._on_share(None)
        if "error" in answer:
            self._on_error(answer["error"])
        elif "labels" in answer:
            self._on_labels(answer["labels"])
        else:
            said = "\n".join(answer["said"])
            self._on_vessel(folder / SURFACE, folder / CENTERLINE, said)

    async def _answer(self, path: Path, number: int, folder: Path) -> dict[str, Any]:
        """The last line of the process, without shares."""
        arguments = str(path), str(number), str(folder)
        command, environment = own_program("SDFStentApp.preparing", *arguments)
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env=environment,
        )
        answer: dict[str, Any] = {}
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                answer = json.loads(line)
                if "share" in answer:
                    self._on_share(answer["share"])
            await process.wait()
        finally:
            if process.returncode is None:
                kill(process)
        if not answer or "share" in answer:
            raise DeploymentError(
                f"{path}: the vessel could not be made, its process has ended; is there enough "
                "memory?"
            )
        if "error" in answer:
            raise InputError(answer["error"])
        return answer
