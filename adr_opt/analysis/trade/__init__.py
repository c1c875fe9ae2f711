"""What budgets and durations buy: plans and bounds of many variants of one instance."""

from .axes import Axis, parse_axis
from .points import Point, Tradeoff
from .run import tradeoff

__all__ = ["Axis", "Point", "Tradeoff", "parse_axis", "tradeoff"]
