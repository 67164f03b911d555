"""Virtual stenting of vessel surfaces: NumPy in, NumPy out, millimeters everywhere.

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

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .centerline import Centerline as Centerline
    from .certificate import certify as certify
    from .certificate import check_surface as check_surface
    from .deformation import Deployment as Deployment
    from .deformation import DeploymentSettings as DeploymentSettings
    from .deformation import deploy as deploy
    from .field import CapsuleChain as CapsuleChain
    from .files import read_axis as read_axis
    from .files import read_centerline as read_centerline
    from .files import read_surface as read_surface
    from .files import write_centerline as write_centerline
    from .files import write_surface as write_surface
    from .geometry import Precision as Precision
    from .geometry import Surface as Surface
    from .lumen import diameter_profile as diameter_profile
    from .plan import Plan as Plan
    from .plan import compare as compare
    from .plan import load_plan as load_plan
    from .plan import run_plan as run_plan
    from .plan import save_plan as save_plan
    from .report import before_after_picture as before_after_picture
    from .report import plan_report as plan_report
    from .report import stent_rows as stent_rows
    from .report import write_report as write_report
    from .stent import AlongAxis as AlongAxis
    from .stent import AtCenter as AtCenter
    from .stent import AtDistalEnd as AtDistalEnd
    from .stent import AtProximalEnd as AtProximalEnd
    from .stent import BetweenPoints as BetweenPoints
    from .stent import Device as Device
    from .stent import Stent as Stent
    from .stent import stent_axis as stent_axis
    from .treatment import Treatment as Treatment
    from .treatment import extract_centerline as extract_centerline
    from .validation import DeploymentError as DeploymentError
    from .validation import InputError as InputError
    from .version import __version__ as __version__
    from .vessel import find_lesions as find_lesions
    from .vessel import lesion_after as lesion_after

_CONTENTS = {
    "centerline": "Centerline",
    "certificate": "certify check_surface",
    "deformation": "Deployment DeploymentSettings deploy",
    "field": "CapsuleChain",
    "files": "read_axis read_centerline read_surface write_centerline write_surface",
    "geometry": "Precision Surface",
    "lumen": "diameter_profile",
    "plan": "Plan compare load_plan run_plan save_plan",
    "report": "before_after_picture plan_report stent_rows write_report",
    "stent": "AlongAxis AtCenter AtDistalEnd AtLesion AtProximalEnd BetweenPoints Device OnBranch "
    "Stent stent_axis",
    "treatment": "Treatment extract_centerline",
    "validation": "DeploymentError InputError",
    "version": "__version__",
    "vessel": "find_lesions lesion_after",
}
"""The names of every room above, for late imports: type checkers take them from there."""

_ROOM_OF = {name: room for room, names in _CONTENTS.items() for name in names.split()}
__all__ = sorted(_ROOM_OF)


def __getattr__(name: str) -> Any:
    if name not in _ROOM_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_ROOM_OF[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
