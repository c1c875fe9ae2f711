"""Tests of third-party planners: :func:`validate_planner`, case by case."""

from __future__ import annotations

from .cases import CASES
from .validate import Fault, PlannerFault, validate_planner

__all__ = ["CASES", "Fault", "PlannerFault", "validate_planner"]
