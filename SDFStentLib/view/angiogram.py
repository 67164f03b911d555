"""A simulated angiogram: how dark contrast medium in the lumen makes every pixel.

By the law of Beer and Lambert a ray keeps the share exp(-a L) of its intensity, L being its length
within the lumen. Bones, tissue, scatter, noise and the blur of a moving heart are not simulated.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import Line, Surface
from ..units import Frame
from ..validation import Floats, Points
from .arm import ArmView
from .rays import Beam, path_lengths

ATTENUATION = 0.112
"""The attenuation by contrast medium, 1/mm: 22.4 cm^2/g, iodine at 40 keV, times 50 mg/mL of it,
the most in the phantom vessels of Gkanatsios et al., Med Phys 2002. It only sets how dark pictures
are."""

PIXELS = 512
"""Rows and columns of a picture."""


class Angiogram(NamedTuple):
    """Lengths of the rays to a detector within the lumen."""

    view: ArmView
    beam: Beam
    lengths: Floats
    """(rows, columns) within the lumen, mm; NaN where it has no inside."""

    def gray(self, attenuation: float = ATTENUATION, darkest: float | None = None) -> Gray:
        """The picture, 0 is black: of what passes, or, with `darkest`, as a subtraction.

        A subtraction is the logarithm of what passes with contrast medium over that without:
        linear in the length, black at the length `darkest`, mm.
        """
        lengths = np.nan_to_num(self.lengths)
        passed = np.exp(-attenuation * lengths) if darkest is None else 1 - lengths / darkest
        return np.rint(255 * np.clip(passed, 0, 1)).astype(np.uint8)

    def pixels(self, points: Points) -> Floats:
        """Places (n, 2) of points (n, 3): columns and rows, from the left upper corner."""
        return self.beam.flat(points)


Gray = NDArray[np.uint8]
"""A picture (rows, columns)."""


def beam_on(
    line: Line,
    radius: float,
    view: ArmView,
    frame: Frame,
    *,
    source: float | None = None,
    reach: float | None = None,
) -> Beam:
    """Rays that show a stretch of vessel with its surroundings, its middle at the isocenter.

    As far to every side as the pictures of reports look for a view: 1.3 times the length, and at
    least six radii.

    Parameters
    ----------
    line : Line
        The axis of the stretch, mm.
    radius : float
        Largest radius of the vessel, mm.
    view, frame
        View, and patient frame of the line.
    source : float, optional
        Distance of a point source from the isocenter, mm; without, rays are parallel.
    reach : float, optional
        Only lumen within this distance of the isocenter is shown, mm.
    """
    half = max(1.3 * line.length, 6 * radius)
    middle = line.at(line.length / 2)
    pixel = 2 * half / PIXELS
    return Beam(view.axes(frame), middle, (PIXELS, PIXELS), pixel, source, reach)


def angiogram(surface: Surface, view: ArmView, beam: Beam) -> Angiogram:
    """The angiogram of a lumen; `InputError` as of `path_lengths`."""
    return Angiogram(view, beam, path_lengths(surface, beam))
