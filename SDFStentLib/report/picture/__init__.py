"""Drawings: diameters as a figure, the vessel before and after by VTK in its own process."""

from .picture import alternatives_picture as alternatives_picture
from .picture import before_after_picture as before_after_picture
