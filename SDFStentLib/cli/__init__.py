"""The shell: `sdfstent deploy`, `run`, `measure`, `check`, `suggest`, `devices` and the others.

Signals are taken before the commands are imported.
"""

from .command import main as main
from .signals import INTERRUPTED as INTERRUPTED
from .signals import end_at_once as end_at_once
