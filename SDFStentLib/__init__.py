"""Virtual stenting of vessel surfaces: NumPy in, NumPy out, millimetres everywhere.

A vessel's wall is a `Surface`, checked once; arrays become one by `Surface(points, triangles)`.

The main path, in six statements (`examples/` and the README have them with numbers):

1. read a surface and a centerline: `read_surface`, `read_centerline`;
2. choose a stent: `Stent`;
3. place it: `AtCenter` and its like, `stent_axis`;
4. build the capsule chain: `CapsuleChain.along`;
5. deploy: `Deployment`, `deploy`, several stents `Treatment`;
6. measure and certify: `diameter_profile`, `certify`.

`Plan` with `load_plan`, `save_plan`, `run_plan` is all of it in one document. Names are
imported when they are first asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .late import late_names
from .version import VERSION as __version__

if TYPE_CHECKING:
    from .centerline import Centerline
    from .certificate import certify, check_surface
    from .deformation import Deployment, DeploymentSettings, deploy
    from .field import CapsuleChain
    from .files import read_axis, read_centerline, read_surface, write_centerline, write_surface
    from .geometry import Precision, Surface
    from .measure import diameter_profile
    from .plan import Plan, compare, load_plan, run_plan, save_plan
    from .report import before_after_picture, plan_report, write_report
    from .stent import (
        AlongAxis,
        AtCenter,
        AtDistalEnd,
        AtProximalEnd,
        BetweenPoints,
        Device,
        Stent,
        stent_axis,
    )
    from .treatment import Treatment
    from .validation import DeploymentError, InputError
    from .vessel import find_lesions, lesion_after

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
    "Device",
    "InputError",
    "Plan",
    "Precision",
    "Stent",
    "Surface",
    "Treatment",
    "__version__",
    "before_after_picture",
    "certify",
    "check_surface",
    "compare",
    "deploy",
    "diameter_profile",
    "find_lesions",
    "lesion_after",
    "load_plan",
    "plan_report",
    "read_axis",
    "read_centerline",
    "read_surface",
    "run_plan",
    "save_plan",
    "stent_axis",
    "write_centerline",
    "write_report",
    "write_surface",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "centerline": ["Centerline"],
        "certificate": ["certify", "check_surface"],
        "deformation": ["Deployment", "DeploymentSettings", "deploy"],
        "field": ["CapsuleChain"],
        "files": [
            "read_axis",
            "read_centerline",
            "read_surface",
            "write_centerline",
            "write_surface",
        ],
        "geometry": ["Precision", "Surface"],
        "measure": ["diameter_profile"],
        "plan": ["Plan", "compare", "load_plan", "run_plan", "save_plan"],
        "report": ["before_after_picture", "plan_report", "write_report"],
        "stent": [
            "AlongAxis",
            "AtCenter",
            "AtDistalEnd",
            "AtProximalEnd",
            "BetweenPoints",
            "Device",
            "Stent",
            "stent_axis",
        ],
        "treatment": ["Treatment"],
        "validation": ["DeploymentError", "InputError"],
        "vessel": ["find_lesions", "lesion_after"],
    },
)
