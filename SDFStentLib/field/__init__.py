"""The stent as a distance field: a chain of capsules, joined by a smooth minimum."""

from .capsule_chain import FOLDS as FOLDS
from .capsule_chain import CapsuleChain as CapsuleChain
from .capsule_chain import as_chain as as_chain
from .capsule_chain import radius_correction as radius_correction
from .chain_field import Field as Field
from .radius_shares import RadiusShares as RadiusShares
from .radius_shares import fractions_of as fractions_of
