"""`python -m SDFStentLib` is the command `sdfstent`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
