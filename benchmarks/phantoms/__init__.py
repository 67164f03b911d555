"""Synthetic vessels with exactly known axes, radii and openings."""

from .cavopulmonary import cavopulmonary_connection as cavopulmonary_connection
from .phantoms import arch_with_coarctation as arch_with_coarctation
from .phantoms import bent_tube as bent_tube
from .phantoms import branching_pulmonary_artery as branching_pulmonary_artery
from .phantoms import hairpin_tube as hairpin_tube
from .phantoms import helix_tube as helix_tube
from .phantoms import stenosed_tube as stenosed_tube
from .phantoms import straight_tube as straight_tube
from .phantoms import tube_with_neighbor as tube_with_neighbor
from .tree import vascular_tree as vascular_tree
from .value import Phantom as Phantom
from .value import TrueOpening as TrueOpening
from .value import TrueVessel as TrueVessel
