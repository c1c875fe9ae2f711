"""Connections chosen from one body to some others at one time."""

from ..core.compile import kernel
from ..core.memory import borrowed
from . import on_demand, timetable


@kernel
def from_source(source, body, ready, destinations, delta_v, arrival):
    """Connections computed on demand.

    Parameters
    ----------
    source : adr_opt.kernels.tables.on_demand.Source
    body : int
    ready : float
        Since when a chaser is free there [s].
    destinations : (destinations,) int64
    delta_v, arrival : (destinations,) float64
        Written: [m/s], [s]; +inf where there is none.
    """
    for place in range(destinations.size):
        delta_v[place], arrival[place] = on_demand.chosen(source, body, destinations[place], ready)


@kernel
def from_rules(rules, body, ready, destinations, delta_v, arrival):
    """The same from the timetable of a mission, whether filled or on demand."""
    rules = borrowed(rules)
    for place in range(destinations.size):
        delta_v[place], arrival[place] = timetable.lookup(
            rules.table, body, destinations[place], ready
        )
