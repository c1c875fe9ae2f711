"""Version of the package, read from its metadata."""

__version__ = "0.9.0"
