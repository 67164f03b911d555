"""Pictures of the vessel before and after, drawn by VTK in a process of its own."""

from .alternatives import alternatives_picture as alternatives_picture
from .picture import before_after_picture as before_after_picture
