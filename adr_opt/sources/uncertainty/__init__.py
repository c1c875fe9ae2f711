"""Position uncertainty of bodies, from files that state it or from successive element sets."""

from .successive import SetsCompared, compared
from .table import read_target_errors
from .target_error import TargetError

__all__ = ["SetsCompared", "TargetError", "compared", "read_target_errors"]
