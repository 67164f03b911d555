"""Flow in three dimensions, before a stent and after it: meshed here, solved elsewhere, read."""

from .conditions import Conditions as Conditions
from .conditions import Cycle as Cycle
from .conditions import End as End
from .folder import DOCUMENT as DOCUMENT
from .folder import FILES as FILES
from .folder import Origin as Origin
from .folder import state_section as state_section
from .folder import write_cases as write_cases
from .prepared import Cut as Cut
from .prepared import Mesh as Mesh
from .prepared import Prepared as Prepared
from .prepared import State as State
from .prepared import prepare as prepare
from .remesh import Wishes as Wishes
from .results import CaseResult as CaseResult
from .results import Found as Found
from .solver import GET_IT as GET_IT
from .solver import UNSTEADY as UNSTEADY
from .solver import Simulated as Simulated
from .solver import has_solver as has_solver
from .solver import read_results as read_results
from .solver import solve_cases as solve_cases
