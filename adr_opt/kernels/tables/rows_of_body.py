"""Connections chosen from bodies at times, several at once."""

from ..core.compile import kernel
from ..core.memory import borrowed
from . import on_demand, timetable


@kernel
def from_source(source, origins, ready, destinations, delta_v, arrival):
    """Connections computed on demand.

    Parameters
    ----------
    source : adr_opt.kernels.tables.on_demand.Source
    origins : (legs,) int64
    ready : (legs,) float64
        Since when a chaser is free there [s].
    destinations : (legs,) int64
    delta_v, arrival : (legs,) float64
        Written: [m/s], [s]; +inf where there is none.
    """
    for leg in range(destinations.size):
        delta_v[leg], arrival[leg] = on_demand.chosen(
            source, origins[leg], destinations[leg], ready[leg]
        )


@kernel
def from_rules(rules, origins, ready, destinations, delta_v, arrival):
    """The same from the timetable of a mission, whether filled or on demand."""
    rules = borrowed(rules)
    for leg in range(destinations.size):
        delta_v[leg], arrival[leg] = timetable.lookup(
            rules.table, origins[leg], destinations[leg], ready[leg]
        )
