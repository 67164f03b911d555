"""The numbers that a file will hold: their floating type and their unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..validation import InputError, Points, as_number


@dataclass(frozen=True)
class Precision:
    """Precision of stored coordinates: the certificate is about the stored numbers.

    Attributes
    ----------
    dtype : numpy dtype
        A floating type.
    scale : float
        File units per mm.

    Raises
    ------
    InputError
        A `dtype` that is no floating type, or a `scale` not above 0.
    """

    dtype: DTypeLike = np.float64
    scale: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "dtype", _floating_type(self.dtype))
        object.__setattr__(self, "scale", as_number(self.scale, "scale", above=0))

    def stored(self, points: Points) -> Points:
        """The numbers that a file of this type and unit would hold, as float64 (n, 3).

        Not to be changed: where nothing has to be converted they are the given points themselves.
        `InputError` for coordinates that are too large for the type.
        """
        with np.errstate(over="ignore"):
            stored = points if self.scale == 1 else points * self.scale
            stored = stored.astype(self.dtype, copy=False).astype(np.float64, copy=False)
        if stored is not points and not np.all(np.isfinite(stored)):
            raise InputError(
                f"points: expected coordinates that fit into {self.dtype}, got some too large for "
                f"it after scaling by {self.scale:g}; store them as float64."
            )
        return stored


def _floating_type(value: Any) -> np.dtype[Any]:
    try:
        kind = np.dtype(value)
    except TypeError:
        kind = np.dtype(object)
    if kind.kind != "f":
        raise InputError(f"dtype: expected a floating type such as float32, got {kind}.")
    return kind
