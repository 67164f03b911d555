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
from ..stent import laid_along, stent_lattice
from ..treatment import TreatedStent
from ..units import MILLIMETERS
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

    Lines with the cell arrays `Stent` (number in the plan), `Ring` and `IsLink`. With a straight
    stent mesh, along z and its middle at z = 0, that mesh once for every stent, with `Stent`. One
    that is dilated again is there once, as it lies in the end.

    Parameters
    ----------
    path : path
    result : PlanResult
    mesh : SurfaceFile, optional

    Raises
    ------
    InputError
        The file cannot be written.
    """
    check_is_a(result, PlanResult, "result")
    surface, stents = result.inputs.surface, result.treatment.final_stents
    per_unit = MILLIMETERS[surface.units]
    if mesh is None:
        struts = _struts(stents)
        polydata = polydata_from_lines(struts.points / per_unit, [*struts.lines])
        arrays = {"Stent": struts.stent, "Ring": struts.ring, "IsLink": struts.is_link}
    else:
        body = mesh.surface
        points: Floats = np.concatenate([laid_along(body.points, s.stent, s.axis) for s in stents])
        starts = len(body.points) * np.arange(len(stents))
        triangles = (body.triangles + starts[:, None, None]).reshape(-1, 3)
        polydata = polydata_from_arrays(points / per_unit, triangles)
        arrays = {"Stent": np.repeat([one.number for one in stents], len(body.triangles))}
    add_arrays(polydata, {}, arrays)
    set_frame_of_polydata(polydata, surface.frame)
    write_bytes(check_writable(path), encode_vtp(polydata))


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
