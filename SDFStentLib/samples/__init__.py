"""Two synthetic vessels as files: a surface with face ids, and its centerline."""

from .vessels import NAMES as NAMES
from .vessels import Sample as Sample
from .vessels import sample as sample
