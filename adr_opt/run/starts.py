"""Start plans in the forms in which callers give them."""

from __future__ import annotations

from collections.abc import Iterable

from ..plan.plan import Plan

Start = Plan | Iterable[int | str] | Iterable[Iterable[int | str]]
"""A plan, or its bodies in order; for several chasers, one sequence each."""
