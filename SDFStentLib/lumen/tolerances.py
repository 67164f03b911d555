"""Differences of lengths, widths and places that do not count, and the reach of a vessel's own
wall."""

from __future__ import annotations

import numpy as np

ROUNDING = 1e-9
"""Share of a length, or mm, by which rounding may change what was calculated."""

NOTHING = 1e-6
"""Length, mm, that is no more than rounding along a whole way: a loop that goes on by less may
never end."""

TOLERANCE = 1e-4
"""Promised gain, mm, below which a search for a sphere ends where its radius is to be right to a
tenth of a percent; spheres that are told go on to `Until`. Where a lumen is flat the middle is
known far less well than the radius, and ways that go on from there part at a junction: at 0.01
they led up to 15 mm apart, by how the search begins."""

ALIKE = 1.01
"""Ratio of two widths of a lumen up to which they are the same width, and of the distance of wall
from a sphere's center to its radius up to which it touches that."""

ROUNDS = 200
"""Most steps of a search; one that is not done by then ends where it is."""

PAIRS = 1 << 21
"""Pairs of a place and a part of the surface that are looked at together: bounds the memory, to
some 10 MB for each of the temporaries. The fewer parts the better."""

AT_ONCE = 16
"""Number of stations of which the parts of the surface are looked at together."""

CENTERED = 0.5
"""Distance from the middle of a vessel or of an opening, in its radii, up to which a place lies
about in the middle; farther aside it may be in another pocket, or lead past the opening."""

WITHIN = 0.9
"""Share of the distance from the middle to the wall within which a place is surely in the lumen."""

FINEST = 0.1
"""Length along a vessel, and width of one, mm, below which nothing is looked for."""

OWN_WIDTH = 1.5
"""Ratio of a width to that of the lumen there up to which both are of one vessel: its section, its
end, its wall from place to place. What is wider is the vessel from which this one comes, or goes on
into a branch."""

FARTHEST = 4.0
"""Distance from the axis of a vessel, in distances from there to its nearest wall, beyond which no
wall is its own."""

END_REACH = 1.1
"""Distance from the end of a vessel, in radii of a sphere, within which that may touch what closes
the end; a tenth for a cap that leans or is round, or the sag of a bend."""

ACROSS = np.cos(np.deg2rad(30.0))
"""Cosine between an axis and the normal of wall from which on that is a cap across the axis."""

ASKEW = np.cos(np.deg2rad(60.0))
"""Cosine between a vessel and the normal of its end, however that is cut or bulged, or the axis of
a stent that goes along it."""
