"""The shell: `sdfstent deploy`, `run`, `measure`, `check`, `suggest`, `devices` and the others.

What is named here is imported when it is first asked for: signals are taken before anything else.
"""

from .shell import main as main
from .signals import INTERRUPTED as INTERRUPTED
from .signals import end_at_once as end_at_once
