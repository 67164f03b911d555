"""Files to look at a plan: its stents, and the surface at every step."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from ..files import (
    SurfaceFile,
    add_arrays,
    check_writable,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    set_frame_of_polydata,
    write_bytes,
    write_surface,
)
from ..geometry import Surface
from ..treatment import TreatmentResult, TreatmentState
from ..units import MILLIMETERS, Frame
from ..validation import check_is_a
from .run import PlanResult


def write_device(
    path: str | os.PathLike[str], result: PlanResult, mesh: SurfaceFile | None = None
) -> None:
    """Write the deployed stents of a plan as VTP, in unit and frame of its surface.

    Parameters
    ----------
    path : path
    result : PlanResult
    mesh : SurfaceFile, optional
        As for `device_vtp`.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    check_is_a(result, PlanResult, "result")
    surface = result.inputs.surface
    body = None if mesh is None else mesh.surface
    content = device_vtp(result.treatment, body, MILLIMETERS[surface.units], surface.frame)
    write_bytes(check_writable(path), content)


def device_vtp(
    result: TreatmentResult,
    mesh: Surface | None = None,
    unit: float = 1.0,
    frame: Frame | None = None,
) -> bytes:
    """The deployed stents of a treatment, to look at, as the content of a VTP file.

    Lines with the cell arrays `Stent` (number in the plan), `Ring` and `IsLink`. With a straight
    stent mesh that mesh once for every stent, with `Stent`. One that is dilated again is there
    once, as it lies in the end.

    Parameters
    ----------
    result : TreatmentResult
    mesh : Surface, optional
        Mesh of the user's own, mm: along z, its middle at z = 0.
    unit : float
        Length of the points' unit, mm.
    frame : str, optional
        Patient frame for the file's header: RAS or LPS.
    """
    stents = result.final_stents
    if mesh is None:
        found = [one.lattice() for one in stents]
        points = np.concatenate([one.points for one in found])
        starts = np.cumsum([0, *(len(one.points) for one in found)])
        lines = [
            line + start for one, start in zip(found, starts, strict=False) for line in one.lines
        ]
        polydata = polydata_from_lines(points / unit, lines)
        counts = [len(one.lines) for one in found]
        arrays = {
            "Stent": np.repeat([one.number for one in stents], counts),
            "Ring": np.concatenate([one.ring for one in found]),
            "IsLink": np.concatenate([one.is_link for one in found]),
        }
    else:
        points = np.concatenate([one.laid(mesh.points) for one in stents])
        starts = len(mesh.points) * np.arange(len(stents))
        triangles = (mesh.triangles + starts[:, None, None]).reshape(-1, 3)
        polydata = polydata_from_arrays(points / unit, triangles)
        arrays = {"Stent": np.repeat([one.number for one in stents], len(mesh.triangles))}
    add_arrays(polydata, {}, arrays)
    set_frame_of_polydata(polydata, frame)
    return encode_vtp(polydata)


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
        """Whether a file's name is one of an earlier run's."""
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
