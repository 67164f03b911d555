"""Trees with narrowings of known place and depth: are they reported as they are?"""

from .bench import table

__all__ = ["table"]
