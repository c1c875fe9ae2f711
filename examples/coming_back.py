"""Remainder of a visiting order when it returns to the true, time-dependent costs."""

from __future__ import annotations

from collections.abc import Iterable

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.mission.order_repair import as_it_is, mended


def come_back(solver: str, mission: adr_opt.Mission, order: Iterable[int]) -> adr_opt.Plan:
    """Make a plan of an order of bodies (by number) and print how many visits survive."""
    order = [int(body) for body in order]
    result = certify(mission, solver, mended(mission, order), seed=0, runtime_s=0.0)
    if result.plan is None or adr_opt.check(mission.instance, result.plan):
        raise RuntimeError(f"the mended order of {solver} is no legal plan")
    own = adr_opt.solve(mission, method="beam", seed=0)
    for visits, what in (
        (order, f"promised by {solver} at the costs it was given"),
        (as_it_is(mission, order), "survive as they are, up to the first leg that does not fit"),
        (result.sequence, "survive with refuelling put in and misfits left out"),
        (own.sequence, "by the planner 'beam', which knows the true costs"),
    ):
        print(f"{sum(body != 0 for body in visits or ()):3d} visits {what}")
    return result.plan
