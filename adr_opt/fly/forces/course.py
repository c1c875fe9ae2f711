"""A leg up to its stand-off, flown piece by piece: burns, windows of thrust, and coasts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg
from .library import Moving, World
from .push import PushedWindow, pushes

BODY_STEPS = 72
"""Steps per revolution of bodies, which forces move by kilometres: within some metres a week."""


class Acting(NamedTuple):
    """Forces on the chaser and on the bodies, as the library has them."""

    chaser: Any
    body: Any


class LegCourse:
    """Burns and windows of thrust of a leg before its approach.

    Parameters
    ----------
    world : World
    acting : Acting
    leg : RefinedLeg

    Raises
    ------
    ArithmeticError
        No burn begins the approach.
    """

    def __init__(self, world: World, acting: Acting, leg: RefinedLeg) -> None:
        self._world, self.acting = world, acting
        self.burns = _burns_before(leg)
        self._pushes = () if leg.thrust is None else tuple(pushes(leg.thrust))

    def beside(
        self, chaser: Array, body: Array, start_s: float, end_s: float
    ) -> tuple[Array, Array]:
        """States of chaser and body at the end, before the burn there."""
        return self._flown(chaser, body, (start_s, end_s), self.burns)

    def alone(
        self, chaser: Array, start_s: float, end_s: float, burns: dict[float, Array]
    ) -> Array:
        """State of the chaser at the end, after the burn there; thrust as planned."""
        found, _ = self._flown(chaser, None, (start_s, end_s), burns)
        return kicked(found, burns, end_s)

    def _flown(
        self,
        chaser: Array,
        body: Array | None,
        span_s: tuple[float, float],
        burns: Mapping[float, Array],
    ) -> tuple[Array, Array]:
        now, end_s = span_s
        times = {*burns, *(time for push in self._pushes for time in push[:2]), end_s}
        for time in sorted(time for time in times if now < time <= end_s):
            chaser = kicked(chaser, burns, now)
            objects = [Moving(chaser, self.acting.chaser, self._push(now, time))]
            if body is not None:
                objects.append(Moving(body, self.acting.body, steps=BODY_STEPS))
            chaser, *rest = self._world.coast(objects, now, time)
            body = rest[0] if rest else None
            now = time
        return chaser, chaser if body is None else body

    def _push(self, start_s: float, end_s: float) -> PushedWindow | None:
        """Thrust between two times, with no beginning or end of a window between them."""
        for push in self._pushes:
            if push.begin_s <= start_s and end_s <= push.end_s:
                return push
        return None


def kicked(state: Array, burns: Mapping[float, Array], time_s: float) -> Array:
    """The state after the burn at a time, if there is one."""
    if time_s not in burns:
        return state
    found: Array = state + np.concatenate([np.zeros(3), burns[time_s]])
    return found


def _burns_before(leg: RefinedLeg) -> dict[float, Array]:
    """Burns before the approach, by time; those at one time together."""
    found: dict[float, Array] = {}
    for burn in leg.burns:
        if burn.phase == "approach":
            return found
        found[burn.time_s] = found.get(burn.time_s, np.zeros(3)) + np.array(burn.delta_v_m_s)
    raise ArithmeticError("no burn begins the approach; add the approach burns")
