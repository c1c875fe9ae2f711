"""Where the bodies of a refined plan are at any time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...sources.ephemerides import Ephemeris, ephemerides_of
from .bodies import Gravity, moved
from .states import state_of


class Whereabouts:
    """States of bodies: as their ephemerides report, or moved freely from the epoch.

    Parameters
    ----------
    refined : RefinedPlan
    reported : mapping
        Ephemerides of bodies that have one, if it was refined onto them.
    """

    def __init__(self, refined: RefinedPlan, reported: Mapping[str, Ephemeris]) -> None:
        self.gravity: Gravity = refined.gravity
        self._at_epoch = {body.name: state_of(body) for body in refined.bodies}
        self._reported = reported

    @classmethod
    def of(cls, instance: Instance, refined: RefinedPlan) -> Self:
        """Those of a refined plan of an instance.

        Raises
        ------
        InputError
            It was refined onto ephemerides that are missing, or others than the instance says.
        """
        if refined.ephemerides is None:
            return cls(refined, {})
        known = ephemerides_of(instance)
        names = [body.name for body in refined.bodies if body.name in known.bodies]
        return cls(refined, {name: known.of(name) for name in names})

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(self._at_epoch)

    def is_reported(self, name: str) -> bool:
        """Whether the states of a body are those of its ephemeris."""
        return name in self._reported

    def source_of(self, name: str) -> str:
        """Source of the states of a body, in words."""
        return "as its ephemeris says" if self.is_reported(name) else "from the state at the epoch"

    def state(self, name: str, time_s: float) -> Array:
        """State of a body at a time since the epoch, shape (6,) [m, m/s]."""
        if name in self._reported:
            return self._reported[name].state(time_s)
        return moved(self._at_epoch[name], time_s, self.gravity)

    def along(self, name: str, times_s: Array) -> Array:
        """States of a body at times in order, shape (times, 6) [m, m/s]."""
        if name in self._reported:
            return self._reported[name].state(times_s)
        found = np.empty((times_s.size, 6))
        now, before_s = self._at_epoch[name], 0.0
        for at, time_s in enumerate(times_s.tolist()):
            now = moved(now, time_s - before_s, self.gravity)
            found[at], before_s = now, time_s
        return found
