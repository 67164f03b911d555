"""Which wall is that of the stented lumen, by degrees.

The far wall of a neighbor faces away from the stent as well, but is joined to the stented lumen
only by walls that do not. A limit between own and foreign would let a hair's breadth decide
whether wall is drawn in by a millimeter or not, so wall becomes foreign little by little.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import connected
from ..validation import Floats

FOREIGN = 0.01
"""Share of the tissue gap from which on wall is foreign.

It keeps that share where it is turned from the stent by 64 degrees, none up to 60, all from 120 on.
"""


def own_share(sides: NDArray[np.int64], tissue: Floats, nearest: int) -> Floats:
    """How far vertices (n,) are wall of the lumen that one of them is of, from 1 to 0.

    As the links of a chain: the most foreign vertex on the best way there decides.

    Parameters
    ----------
    sides : (m, 2) array
        Vertices that are joined.
    tissue : (n,) array
        Share of the tissue gap that each keeps from the stent, in [0, 1].
    nearest : int
        A vertex of the stented lumen for certain, without tissue.
    """
    # Column by column: a reduction over rows of two takes several times as long.
    first, second = sides.T
    is_free, may_be = tissue == 0, tissue < FOREIGN
    joins_free = is_free[first] & is_free[second]
    # Free wall that hangs together is one node of what has to be searched.
    count, part = connected(len(tissue), first[joins_free], second[joins_free])
    keeps = np.zeros(count)
    keeps[part] = tissue
    bridges = part[sides[may_be[first] & may_be[second] & ~joins_free]]
    start, end = np.concatenate([bridges, bridges[:, ::-1]]).T
    worst = np.full(count, np.inf)
    worst[part[nearest]] = 0
    # Ends: every pass but the last lowers a value to one of finitely many.
    while True:
        reached = worst.copy()
        np.minimum.at(reached, end, np.maximum(worst[start], keeps[end]))
        if (reached == worst).all():
            break
        worst = reached
    return 1 - np.minimum(worst[part] / FOREIGN, 1)
