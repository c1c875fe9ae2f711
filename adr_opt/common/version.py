"""Version of the package, read from its metadata."""

__version__ = "2.0.0"
