"""Many deployments of one plan: a sweep document, its cases, and a store that is always whole.

Names listed here are imported when first asked for: workers set their threads before NumPy loads.
"""

from .cases import Cases as Cases
from .cases import SweepCase as SweepCase
from .document import load_sweep as load_sweep
from .document import sweep_from_document as sweep_from_document
from .document import sweep_schema as sweep_schema
from .estimate import Tally as Tally
from .estimate import duration_in_words as duration_in_words
from .estimate import estimated as estimated
from .estimate import last_tally as last_tally
from .executors import worker_count as worker_count
from .manifest import write_manifest as write_manifest
from .reader import Cohort as Cohort
from .runner import run_sweep as run_sweep
from .value import Patient as Patient
from .value import Sweep as Sweep
