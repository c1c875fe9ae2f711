"""Trade-offs of budget and duration: plans and bounds of many variants of one instance."""

from .axes import Axis, parse_axis
from .frontier import Ending, frontier
from .points import Point, Tradeoff
from .run import tradeoff

__all__ = ["Axis", "Ending", "Point", "Tradeoff", "frontier", "parse_axis", "tradeoff"]
