"""The wall follows one stent, radius step by radius step, to the prescribed lumen."""

from .deployment import Deployment as Deployment
from .deployment import deploy as deploy
from .profiles import BLENDS as BLENDS
from .profiles import FALLOFFS as FALLOFFS
from .proxy import Proxy as Proxy
from .proxy import ProxyState as ProxyState
from .settings import RULES as RULES
from .settings import DeploymentSettings as DeploymentSettings
from .values import FINE as FINE
from .values import NEARLY_DONE as NEARLY_DONE
from .values import DeploymentResult as DeploymentResult
from .values import DeploymentState as DeploymentState
