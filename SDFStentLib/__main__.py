"""`python -m SDFStentLib` is the command `sdfstent`."""

import os
import sys

from .cli import INTERRUPTED, end_at_once

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Variables by which libraries of linear algebra limit their threads. Products here are thin: more
than one thread doubles the processor's work, and gains nothing."""


def main() -> int:
    """Run the command line; it ends with a sentence even if its imports are interrupted."""
    end_at_once()
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    from .cli import main as command
    from .threads import are_busy

    code = command()
    if code == INTERRUPTED or are_busy():
        # An interruption that came while text was executed (as dataclasses do) is remembered by
        # Python, which would end by the signal although it was handled. Threads that are at work
        # when Python ends may end it by a signal, too.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
