"""Resources of a partial route: their extension by a leg, and dominance between routes.

The resources of the resource-constrained shortest paths that all planners look for. A leg with the
service or refuelling that follows it extends them by :func:`extend`, and one set of them dominates
another by :func:`dominates`. Both stand here alone, but for :mod:`adr_opt.judge`, which states them
again, on purpose. A further resource (a variance, a class of masses) is a field of
:class:`Resources`, what these two functions say of it, and a column of :func:`columns`; a limit on
what is counted is a field of :class:`CountLimits` and a line of :func:`may_service`. Searches that
keep millions of labels hold counts as one number, :func:`counts_of`.

Code that relaxes or sorts resources has no sets of them to compare, and says so. Walks count ΔV in
whole slots, sixteen at a time (:mod:`solvers.walks.sweeps`). Networks know the least that has been
used by any way to a node (:mod:`solvers.models.solver_network`, the windows of `ortools`). Fronts
along an order are staircases that are searched by halving (:mod:`.schedule`,
:mod:`solvers.orders.fronts`). That one *connection* dominates another is a rule of its own, of
departures and arrivals (:mod:`adr_opt.kernels.legs.connections`).
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from .loads import after_service, first_tank, full_tank, may_stand_for

One = Any
"""A number, or an array of them in :func:`columns` of many routes."""


class Resources(NamedTuple):
    """The resources of a partial route.

    Attributes
    ----------
    time : float
        Since when the chaser is free [s].
    left : float
        ΔV left [m/s].
    since : int
        Targets serviced since the last refuelling.
    serviced : int
        Targets serviced.
    kits : int
        Kits aboard.
    """

    time: One
    left: One
    since: One
    serviced: One
    kits: One


class CountLimits(NamedTuple):
    """Limits on the counts of a chaser; :data:`ANY` where there is none.

    Attributes
    ----------
    targets : int
        Targets serviced.
    between : int
        Targets serviced since the last refuelling.
    """

    targets: int
    between: int


ANY = (1 << 20) - 1
"""Count that no mission reaches."""


@inlined
def limits_in(row):
    """Limits from a row of numbers, in the order of their fields."""
    return CountLimits(int(row[0]), int(row[1]))


@inlined
def may_service(here, limits):
    """Whether counts allow one more service."""
    return here.serviced < limits.targets and here.since < limits.between


@inlined
def at_start(ready, kits, loads, budget):
    """Resources at the start, from a ready time [s] and a number of kits aboard."""
    nothing = np.int64(0)
    return Resources(ready, first_tank(loads, budget, kits), nothing, nothing, np.int64(kits))


@inlined
def extend(here, destination, refuels, delta_v, end, loads, budget):
    """Resource extension by a leg and the service or refuelling that follows it.

    Parameters
    ----------
    here : Resources
        Before the leg.
    destination : int
    refuels : bool
        Whether the destination is a station, where the tank is filled.
    delta_v : float
        Of the leg [m/s].
    end : float
        Of the service or refuelling [s].
    loads : Loads or None
    budget : float
        As in :class:`.rules.Rules` [m/s].

    Returns
    -------
    Resources
        With less than 0 left, and else of no meaning, where the service cannot be made.
    """
    if refuels:
        full = full_tank(loads, budget, here.kits)
        return Resources(end, full, np.int64(0), np.int64(here.serviced), np.int64(here.kits))
    left, kits = after_service(loads, destination, here.kits, here.left - delta_v)
    return Resources(
        end, left, np.int64(here.since + 1), np.int64(here.serviced + 1), np.int64(kits)
    )


@inlined
def dominates(one, other, loads, limits):
    """Whether one route dominates another at the same body: it allows every continuation of it.

    It is free no later, which is enough since a chaser may wait, has no less left, has counted no
    more of what is limited, and its kits will do for those of the other. Which targets are done is
    for the caller to compare. Whether they may refuel is not compared: at one body either all have
    serviced a target since they refuelled, or none has.

    Parameters
    ----------
    one, other : Resources
    loads : Loads or None
    limits : CountLimits
    """
    return (
        one.time <= other.time
        and one.left >= other.left
        and (limits.targets == ANY or one.serviced <= other.serviced)
        and (limits.between == ANY or one.since <= other.since)
        and may_stand_for(loads, one.kits, other.kits)
    )


@kernel
def columns(shape):
    """Storage for the resources of many routes: an array for each field."""
    return Resources(
        np.empty(shape),
        np.empty(shape),
        np.empty(shape, np.int32),
        np.empty(shape, np.int32),
        np.empty(shape, np.int32),
    )


@inlined
def at(held, place):
    """The resources at an index of such columns."""
    return Resources(
        held.time[place],
        held.left[place],
        np.int64(held.since[place]),
        np.int64(held.serviced[place]),
        np.int64(held.kits[place]),
    )


@inlined
def put(held, place, resources):
    """Write resources to an index of such columns."""
    held.time[place], held.left[place] = resources.time, resources.left
    held.since[place], held.serviced[place] = resources.since, resources.serviced
    held.kits[place] = resources.kits


COUNT_BITS = 21
"""Bits of a count in a packed number."""


@inlined
def counts_of(resources):
    """Counts packed in one number: services, those since the last refuelling, kits."""
    since = resources.since << COUNT_BITS
    return resources.serviced + since + (resources.kits << 2 * COUNT_BITS)


@inlined
def with_counts(time, left, counts):
    """Resources with packed counts."""
    mask = (1 << COUNT_BITS) - 1
    return Resources(
        time,
        left,
        np.int64(counts >> COUNT_BITS & mask),
        np.int64(counts & mask),
        np.int64(counts >> 2 * COUNT_BITS),
    )


def kits_alone(kits):
    """Packed counts at the start of a route, by the number of kits aboard."""
    return kits << 2 * COUNT_BITS
