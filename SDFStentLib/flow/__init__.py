"""What a narrowing costs: pressure, and blocks for a solver."""

from .pressure import ADULT as ADULT
from .pressure import TOO_LOW as TOO_LOW
from .pressure import TURBULENCE as TURBULENCE
from .pressure import Blood as Blood
from .pressure import PressureBand as PressureBand
from .pressure import VesselBlock as VesselBlock
from .pressure import pressure_band as pressure_band
from .pressure import vessel_block as vessel_block
