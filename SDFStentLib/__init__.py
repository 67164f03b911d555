"""Virtual stenting of vessel surfaces: NumPy in, NumPy out, millimetres everywhere.

The main path, in six statements (`examples/` and the README have them with numbers):

1. read a surface and a centerline: `read_surface`, `read_centerline`;
2. choose a stent: `Stent`;
3. place it: `AtCenter` and its like, `stent_axis`;
4. build the capsule chain: `CapsuleChain.along`;
5. deploy: `Deployment`, `deploy`, several stents `Treatment`;
6. measure and certify: `diameter_profile`, `certify`.

`Plan` with `load_plan`, `save_plan`, `run_plan` is all of it in one document. Names that need vtk
are imported when they are first asked for.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .capsule_chain import CapsuleChain
from .centerline import Centerline
from .certificate import certify, check_surface
from .deployment import Deployment, deploy
from .metrics import diameter_profile, stenosis
from .placement import AlongAxis, AtCenter, AtDistalEnd, AtProximalEnd, BetweenPoints
from .plan import Plan
from .plan_document import save_plan
from .plan_reader import load_plan
from .settings import DeploymentSettings
from .stent import Stent, stent_axis
from .treatment import Treatment
from .validation import DeploymentError, InputError
from .version import VERSION as __version__

if TYPE_CHECKING:
    from .centerline_files import read_axis, read_centerline
    from .centerline_output import write_centerline
    from .picture import render_before_after
    from .plan_run import run_plan
    from .surface_files import read_surface
    from .surface_output import write_surface

__all__ = [
    "AlongAxis",
    "AtCenter",
    "AtDistalEnd",
    "AtProximalEnd",
    "BetweenPoints",
    "CapsuleChain",
    "Centerline",
    "Deployment",
    "DeploymentError",
    "DeploymentSettings",
    "InputError",
    "Plan",
    "Stent",
    "Treatment",
    "__version__",
    "certify",
    "check_surface",
    "deploy",
    "diameter_profile",
    "load_plan",
    "read_axis",
    "read_centerline",
    "read_surface",
    "render_before_after",
    "run_plan",
    "save_plan",
    "stenosis",
    "stent_axis",
    "write_centerline",
    "write_surface",
]

# Their modules import vtk, which takes longer than everything above together.
_LATE = {
    "read_axis": "centerline_files",
    "read_centerline": "centerline_files",
    "read_surface": "surface_files",
    "render_before_after": "picture",
    "run_plan": "plan_run",
    "write_centerline": "centerline_output",
    "write_surface": "surface_output",
}


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_LATE[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
