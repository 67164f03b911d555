"""The stents of a plan as a file to look at, or a straight mesh of the user's in their place."""

from __future__ import annotations

import os
from typing import NamedTuple

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
)
from ..geometry import Surface
from ..stent import laid_along, stent_lattice
from ..treatment import TreatedStent, TreatmentResult
from ..units import MILLIMETERS, Frame
from ..validation import Flags, Floats, Indices, Points, check_is_a
from .run import PlanResult


class _Struts(NamedTuple):
    """Of all stents together; lines (m, p), the rest (m,)."""

    points: Points
    lines: Indices
    stent: Indices
    ring: Indices
    is_link: Flags


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
        Of the user's own, mm: along z, its middle at z = 0.
    unit : float
        Of the points, mm.
    frame : str, optional
        What the file says of their frame: RAS or LPS.
    """
    stents = result.final_stents
    if mesh is None:
        struts = _struts(stents)
        polydata = polydata_from_lines(struts.points / unit, [*struts.lines])
        arrays = {"Stent": struts.stent, "Ring": struts.ring, "IsLink": struts.is_link}
    else:
        points: Floats = np.concatenate([laid_along(mesh.points, s.stent, s.axis) for s in stents])
        starts = len(mesh.points) * np.arange(len(stents))
        triangles = (mesh.triangles + starts[:, None, None]).reshape(-1, 3)
        polydata = polydata_from_arrays(points / unit, triangles)
        arrays = {"Stent": np.repeat([one.number for one in stents], len(mesh.triangles))}
    add_arrays(polydata, {}, arrays)
    set_frame_of_polydata(polydata, frame)
    return encode_vtp(polydata)


def _struts(stents: tuple[TreatedStent, ...]) -> _Struts:
    found = [stent_lattice(one.stent, one.axis) for one in stents]
    starts = np.cumsum([0, *(len(one.points) for one in found)])
    return _Struts(
        np.concatenate([one.points for one in found]),
        np.concatenate([one.lines + start for one, start in zip(found, starts, strict=False)]),
        np.repeat([one.number for one in stents], [len(one.lines) for one in found]),
        np.concatenate([one.ring for one in found]),
        np.concatenate([one.is_link for one in found]),
    )
