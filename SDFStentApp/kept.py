"""The plans of pages, kept on disk while the pages live and for a day: each page has a folder, with
the files that its browser has sent."""

from __future__ import annotations

import os
import re
import shutil
import time
from pathlib import Path

PLAN = "plan.json"
DAY_S = 86_400.0


def usual_folder() -> Path:
    """The folder where plans are kept unless another one is named: the user's folder for the state
    of programs."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "sdfstent" / "plans"


class KeptPlans:
    """The folders of the pages in `root`, each readable by its owner only; with None nothing is
    kept."""

    def __init__(self, root: Path | None) -> None:
        self.root = root
        if root is not None:
            self._forget_old(root)

    def folder(self, page: str) -> str | None:
        """The folder of a page."""
        return None if self.root is None else str(self.root / page)

    def has(self, page: str) -> bool:
        """Whether a plan is kept for a page of this name, which may be any text."""
        is_name = re.fullmatch(r"[\w-]+", page) is not None
        return self.root is not None and is_name and (self.root / page / PLAN).is_file()

    @staticmethod
    def _forget_old(root: Path) -> None:
        for folder in root.iterdir():
            plan = folder / PLAN
            since = (plan if plan.exists() else folder).stat().st_mtime
            if folder.is_dir() and time.time() - since > DAY_S:
                shutil.rmtree(folder, ignore_errors=True)
