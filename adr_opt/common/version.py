"""Version of the package, read from its metadata."""

__version__ = "1.1.0"
