"""The end of a computation that was told to stop."""


class TimeIsOver(Exception):
    """An evaluation was broken off."""
