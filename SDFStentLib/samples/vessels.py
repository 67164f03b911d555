"""Files of the sample vessels."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Sample(NamedTuple):
    """The files of a vessel, in mm and RAS."""

    surface: Path
    centerline: Path


NAMES = ("branching_pulmonary_artery", "arch_with_coarctation")
"""A pulmonary artery of a child with a stenosis of its left branch, and an aorta with a
coarctation; `benchmarks/phantoms/write_samples.py` has made them."""


def sample(name: str) -> Sample:
    """The files of one of `NAMES`."""
    folder = Path(__file__).parent
    return Sample(folder / f"{name}.vtp", folder / f"{name}_centerline.vtp")
