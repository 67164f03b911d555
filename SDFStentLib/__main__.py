"""`python -m SDFStentLib` is the command `sdfstent`."""

import os
import sys

from .cli import INTERRUPTED, end_at_once

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Libraries of linear algebra read how many threads they start. Products here are thin: more
threads than one double the processor's work, and gain nothing."""


def main() -> int:
    """The command line, which ends in a sentence also when its imports are interrupted."""
    end_at_once()
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    from .cli import main as command

    code = command()
    if code == INTERRUPTED:
        # An interruption that came while text was executed (as dataclasses do) is remembered by
        # Python, which would end by the signal although it was handled.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
