"""The wall follows one stent, radius step by radius step, to the prescribed lumen."""

from __future__ import annotations

from .deployment import Deployment, deploy
from .profiles import BLENDS, FALLOFFS
from .proxy import Proxy, ProxyState
from .settings import RULES, DeploymentSettings
from .values import DeploymentResult, DeploymentState

__all__ = [
    "BLENDS",
    "FALLOFFS",
    "RULES",
    "Deployment",
    "DeploymentResult",
    "DeploymentSettings",
    "DeploymentState",
    "Proxy",
    "ProxyState",
    "deploy",
]


def __dir__() -> list[str]:
    return __all__
