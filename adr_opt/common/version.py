"""The version of the package, as its metadata state it."""

__version__ = "0.9.0"
