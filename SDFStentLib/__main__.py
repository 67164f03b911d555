"""`python -m SDFStentLib` is the command `sdfstent`."""

import gc
import os
import sys

from .cli import INTERRUPTED, end_at_once
from .late import PartlyLate, postpone

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Libraries of linear algebra read how many threads they start. Products here are thin: more
threads than one double the processor's work, and gain nothing."""

UNUSED = ("numpy.f2py", "numpy.ma", "numpy.polynomial", "numpy.testing")
"""SciPy takes everything from NumPy when it is imported. These take as long as the rest of it, and
nobody here needs them."""

UNWANTED = "vtkmodules.util.pickle_support"
"""VTK makes its data fit for pickling wherever this can be imported, and takes its communication
between processes and its old files along. Nobody here pickles them."""

PARTLY = {
    "scipy.spatial": {"KDTree": "_kdtree", "cKDTree": "_ckdtree"},
    "scipy.sparse.csgraph": {
        "connected_components": "_traversal",
        "depth_first_order": "_traversal",
        "dijkstra": "_shortest_path",
        "minimum_spanning_tree": "_min_spanning_tree",
    },
}
"""Where in SciPy lies what is used at every deployment. The rest of these packages imports linear
algebra and special functions, twice as long as NumPy takes: it is executed when it is asked for."""

GARBAGE = 100_000
"""So many objects are made before it is looked for cycles among them, which imports have none of: a
deployment and all that it imports are fewer."""


def main() -> int:
    """The command line, which ends in a sentence also when its imports are interrupted."""
    end_at_once()
    gc.set_threshold(GARBAGE)
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    for name in UNUSED:
        postpone(name)
    sys.modules.setdefault(UNWANTED, None)  # type: ignore[arg-type]
    sys.meta_path.insert(0, PartlyLate(PARTLY))
    from .cli import main as command

    code = command()
    # Nor is it looked for cycles among all of them when the process ends.
    gc.freeze()
    if code == INTERRUPTED:
        # An interruption that came while text was executed (as dataclasses do) is remembered by
        # Python, which would end by the signal although it was handled.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
