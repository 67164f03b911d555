"""The surface at every step, as files that ParaView plays."""

from __future__ import annotations

import re
from pathlib import Path

from ..files import SurfaceFile, write_surface
from ..treatment import TreatmentState

_OWN = re.compile(r"steps\.pvd|step_\d+\.vtp")


class StepFiles:
    """States that are kept while the stent expands, and written in the end.

    Parameters
    ----------
    every : float
        Keep a state only when the diameter has grown by this, mm, and the last one of each stent.
    """

    def __init__(self, every: float = 0.0) -> None:
        self.every = every
        self._kept: list[TreatmentState] = []
        self._surface: SurfaceFile | None = None

    @staticmethod
    def is_own(name: str) -> bool:
        """Whether a file of that name is one of an earlier run."""
        return _OWN.fullmatch(name) is not None

    def take(self, surface: SurfaceFile, state: TreatmentState) -> None:
        """Keep a state if its diameter is far enough from that of the last one kept."""
        self._surface = surface
        last = self._kept[-1] if self._kept else None
        is_new = last is None or last.number != state.number
        if last is None or is_new:
            self._kept.append(state)
            return
        growth = 2 * (state.deployment.radius - last.deployment.radius)
        if growth >= self.every - 1e-9 or state.deployment.fraction >= 1:
            self._kept.append(state)

    def write(self, folder: Path) -> None:
        """Write `step_0000.vtp` and so on, and `steps.pvd`, which lists them."""
        folder.mkdir()
        assert self._surface is not None
        entries = []
        for number, state in enumerate(self._kept):
            name = f"step_{number:04d}.vtp"
            write_surface(folder / name, self._surface, state.points())
            entries.append(f'    <DataSet timestep="{state.fraction:.9g}" part="0" file="{name}"/>')
        text = "\n".join(
            [
                '<?xml version="1.0"?>',
                '<VTKFile type="Collection" version="0.1">',
                "  <Collection>",
                *entries,
                "  </Collection>",
                "</VTKFile>",
                "",
            ]
        )
        (folder / "steps.pvd").write_text(text, encoding="utf-8")
