"""Raised to end a computation that was told to stop."""


class TimeIsOver(Exception):
    """An evaluation was interrupted."""
