"""Uncertainty of where bodies are: files that state it, and what element sets show of it."""

from .successive import SetsCompared, compared
from .table import read_target_errors
from .target_error import TargetError

__all__ = ["SetsCompared", "TargetError", "compared", "read_target_errors"]
