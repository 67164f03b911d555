"""The version of the program, as in pyproject.toml."""

__version__ = VERSION = "0.2.0"
