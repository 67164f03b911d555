"""Trees with narrowings of known place and depth: are they reported as they are?"""

from .bench import measured, table

__all__ = ["measured", "table"]
