"""A timetable shared by the points of a trade-off, as far as possible.

Tanks have no part in the timetable of two-body motion: missions that differ in them share it as it
is, whatever an hour is worth. Connections of a shorter mission are those of a longer one that
arrive in time, exactly, since none is dominated by one that arrives later
(``ConnectionFinder.shortened``); only the choice among them is made anew.
Where planes drift a larger tank may leave out what a smaller one needs: a connection that saves
less than the resolution against one that only the larger tank can pay. So there each tank has
connections of its own.
"""

from __future__ import annotations

import math

from ...legs.connection_finder import ConnectionFinder
from ...mission.problem import Problem, problem_of
from ...problem.instance import Instance
from .axes import PointLimits, Tanks, counts_masses, with_drive


def variant(instance: Instance, limits: PointLimits, *, tanks: Tanks) -> Instance:
    """The instance of a point; tanks that are not varied stay unchanged.

    ``tanks`` says what of them is.
    """
    changed = with_drive(instance, limits.thrust_n, limits.isp_s)
    return changed.with_limits(limits.duration_s, **tanks.changes(limits.delta_v_m_s))


def slack_m_s(instance: Instance) -> float:
    """Largest excess cost of a plan on the connections of a larger tank [m/s].

    Each leg as much as the resolution, where connections that save less are left out. There is no
    such limit where masses count: what is aboard, or towed, takes part in each leg.
    """
    if not instance.nodes_drift and instance.transfer.departure_spacing_s == 0.0:
        return 0.0
    if counts_masses(instance):
        return math.inf
    return instance.transfer.delta_v_resolution_m_s * (2 * len(instance.targets) + 2)


class Shared:
    """Problems for the points of one instance.

    Parameters
    ----------
    instance : Instance
    longest_s : float
        The longest duration of all points [s].
    tanks : Tanks
        What is varied of tanks.
    """

    def __init__(self, instance: Instance, longest_s: float, *, tanks: Tanks) -> None:
        self._instance, self.longest_s, self._tanks = instance, longest_s, tanks
        self._of_tank: dict[PointLimits | None, Problem] = {}

    def problem(self, limits: PointLimits) -> Problem:
        """The problem of a point, reusing what is known of its timetable."""
        changes = self._tanks.changes(limits.delta_v_m_s)
        return self._longest(limits).with_limits(limits.duration_s, **changes)

    def _longest(self, limits: PointLimits) -> Problem:
        """Longest mission with the same tank, or with any if tanks make no difference."""
        longest = limits._replace(duration_s=self.longest_s)
        instance = variant(self._instance, longest, tanks=self._tanks)
        key = longest if ConnectionFinder(instance).depends_on_tank else None
        if key not in self._of_tank:
            if key is not None:
                self._of_tank.clear()  # they are large, and tanks come one after the other
            self._of_tank[key] = problem_of(instance)
        return self._of_tank[key]
