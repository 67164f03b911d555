"""Trees with narrowings of known place and depth: are they told as they are?"""

from .bench import measured, table

__all__ = ["measured", "table"]
