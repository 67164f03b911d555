"""`python -m SDFStentLib` is the command `sdfstent`."""

import os
import sys

from .cli import INTERRUPTED, end_at_once


def main() -> int:
    """The command line, which ends in a sentence also when its imports are interrupted."""
    end_at_once()
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
