"""The duration of a tour, and which rules it breaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .costs import delta_v_m_s
from .reading import Problem, Tour

SLACK_D, SLACK_M_S = 1e-6, 1e-6
"""What is over a limit by less passes, as where the contest was judged."""


@dataclass(frozen=True)
class Score:
    """What a tour comes to.

    Attributes
    ----------
    duration_d : float
        Arrival at the last target [d].
    delta_v_m_s : tuple of float
        Of the legs.
    exceptions : int
        Legs over the usual limit.
    violations : tuple of str
    """

    duration_d: float
    delta_v_m_s: tuple[float, ...]
    exceptions: int
    violations: tuple[str, ...]


def score(problem: Problem, tour: Tour) -> Score:
    """A tour by the rules: order, times, ΔV of each leg, exceptions."""
    broken = []
    order = [int(one) for one in tour.order]
    if sorted(order) != list(range(problem.targets)):
        return Score(np.nan, (), 0, ("not every target once",))
    legs = []
    ready = problem.begin_d
    times = zip(tour.departures_d, tour.flights_d, strict=True)
    for leg, (departure, flight) in enumerate(times):
        if departure < ready - SLACK_D:
            broken.append(f"leg {leg}: leaves at {departure:.6f} d, ready at {ready:.6f} d")
        if flight < problem.least_flight_d - SLACK_D:
            broken.append(f"leg {leg}: a flight of {flight:.6f} d")
        ready = float(departure + flight)
        legs.append(delta_v_m_s(problem, order[leg], order[leg + 1], departure, flight))
        if legs[-1] > problem.most_exception_m_s + SLACK_M_S:
            broken.append(f"leg {leg}: {legs[-1]:.3f} m/s")
    if ready > problem.longest_d + SLACK_D:
        broken.append(f"{ready:.3f} d in all")
    exceptions = sum(leg > problem.most_m_s for leg in legs)
    if exceptions > problem.exceptions:
        broken.append(f"{exceptions} legs over {problem.most_m_s:g} m/s")
    return Score(ready, tuple(legs), exceptions, tuple(broken))
