"""When services may begin, stated once more."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...problem.instance import Instance

FloatArray = npt.NDArray[np.float64]


class Openings(NamedTuple):
    """Times at which a service may begin, if nothing but windows limits them.

    Attributes
    ----------
    opens, latest : (intervals,) float64
        Ascending; each interval has room for a capture [s].
    """

    opens: FloatArray
    latest: FloatArray

    def begins(self, arrivals: npt.ArrayLike) -> FloatArray:
        """Starts of services after arrivals; +inf where there is none [s]."""
        times = np.asarray(arrivals, dtype=np.float64)
        opens = np.append(self.opens, np.inf)
        begins: FloatArray = np.maximum(times, opens[np.searchsorted(self.latest, times)])
        return begins


def openings_of(instance: Instance, service_s: FloatArray) -> tuple[Openings, ...]:
    """Openings of all bodies.

    Parameters
    ----------
    instance : Instance
    service_s : (bodies,) float64
    """
    always = Openings(np.array([-np.inf]), np.array([np.inf]))
    found = [always] * instance.first_target
    for number, station in enumerate(instance.stations):
        if station.max_refuellings == 0:
            found[number] = Openings(np.empty(0), np.empty(0))
    for body, target in enumerate(instance.targets, start=instance.first_target):
        captured_s = service_s[body] if target.capture_s is None else target.capture_s
        opens, closes = instance.intervals_of(target).T
        latest = closes + SLACK_S - captured_s
        fits = opens <= latest
        found.append(Openings(opens[fits], latest[fits]))
    return tuple(found)
