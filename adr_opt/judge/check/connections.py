"""Random checks of connections: flown again by the physics of `check`, and tested for dominance.

A bound says something about all plans only if all connections are there. So for some departures all
sequences are worked out once more, plainly (:mod:`.sequences`), and each has to be matched by a
connection that leaves no earlier, arrives no later and costs no more, up to the resolution.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_S
from ...kernels.legs import burns as burn_kernels
from ...kernels.orbits.body_rows import launched
from ...legs.connection_finder import ConnectionFinder
from ...legs.connections import Connections
from ...legs.families.family import StatedLeg, Way
from ...legs.families.registry import families, registered_of
from ...plan.leg_kinds import SHORT
from ...plan.plan import Burn, Leg, burns_of
from ...problem.instance import Instance
from .altitude import Heights
from .leg import Physics, check_transfer
from .lifetime import CONTROLLED_M, NEAR, is_uncontrolled, outstays
from .routes import begin_of, service_s
from .sequences import ways_after
from .tow import may_end_far
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S

DEPARTURES_SHARE = 0.1
"""Number of sampled departures per connection flown again."""

PAIRS = 200
"""Maximum number of pairs to draw connections from, as each pair takes time."""

ROUNDED_S = 16.0 + 2e-3
"""Largest rounding of departures where planes drift [s]."""

SINKING_S = 7200.0 + 60.0
"""Time before a body has sunk too low in which no connection to or from it is required [s]."""

NO_RULES = frozenset({"burns", "eccentricity", "given"})
"""Violations that concern only the form of a leg."""


class Sampled(NamedTuple):
    """Outcome of the sampling.

    Attributes
    ----------
    connections, departures : int
    faults : tuple of str
        Of each kind the first, if any.
    """

    connections: int
    departures: int
    faults: tuple[str, ...]


def sample_connections(
    instance: Instance, connecting: ConnectionFinder, number: int, seed: int
) -> Sampled:
    """Fly a sample of connections again, and search for better ones at their departures.

    Parameters
    ----------
    instance : Instance
    connecting : ConnectionFinder
    number : int
        Connections to fly, drawn from a few pairs.
    seed : int
    """
    rng = np.random.default_rng(seed)
    names, launches = instance.names, instance.launches
    pairs = [
        (i, j)
        for i in range(len(names))
        for j in range(len(names))
        if i != j and i not in launches and j not in launches
    ]
    if not pairs or number == 0:
        return Sampled(0, 0, ())
    drawn = rng.permutation(len(pairs))[:PAIRS]
    physics, resolution = Physics.of(instance, connecting.drive), connecting.planning_resolution_m_s
    flown = departures = 0
    wrong: list[str] = []
    missing: list[str] = []
    for turn, at in enumerate(drawn):
        i, j = pairs[at]
        there = instance
        if i in connecting.ends.launched:
            physics.left[i] = launched(physics.left[i], physics.elements[j])
            if connecting.drive is None:  # no drift leads from a launch
                transfer = instance.transfer.replace(max_drift_s=0.0)
                there = instance.replace(transfer=transfer)
        found = connecting.of_pair(i, j, resolution)
        # What was spent before the start goes off the tank with the first leg: no cost of it.
        found = replace(found, delta_v=found.delta_v - connecting.spent_m_s(i))
        share = -(-(number - flown) // (len(drawn) - turn))
        size = min(share, found.departure.size)
        # Lower bounds on what legs cost are none that are flown.
        if connecting.drive is None or not connecting.relaxed:
            for c in rng.choice(found.departure.size, size, replace=False):
                wrong += _faults(connecting, physics, found, i, j, int(c))
            flown += size
        for _ in range(max(1, round(DEPARTURES_SHARE * share))):
            time = float(rng.uniform(0.0, instance.mission.duration_s))
            ways = list(ways_after(there, physics, connecting.drive, i, j, time))
            for family in registered_of(instance):
                ways += family.ways(connecting.ends.of(i, j), time)
            departures += bool(ways)
            missing += [
                f"no connection from {names[i]!r} to {names[j]!r} is as good as the one that "
                f"leaves at {way.departure:.6g} s, arrives at {way.arrival:.6g} s and costs "
                f"{way.delta_v:.6g} m/s"
                for way in ways
                if not _is_matched(instance, found, way, resolution)
                and not _is_barred(instance, physics, way, i, j)
            ]
    return Sampled(flown, departures, (*wrong[:1], *missing[:1]))


def _faults(
    connecting: ConnectionFinder, physics: Physics, found: Connections, i: int, j: int, c: int
) -> Iterator[str]:
    """Violations that `check` finds in a connection."""
    instance, names = connecting.instance, connecting.instance.names
    departure, arrival = float(found.departure[c]), float(found.arrival[c])
    laps, delta_v = int(found.revolutions[c]), float(found.delta_v[c])
    leaves, burns = departure, tuple[Burn, ...]()
    said = (
        f"the connection from {names[i]!r} to {names[j]!r} that leaves at {departure!r} s "
        f"cannot be flown"
    )
    stated, family = StatedLeg(departure, arrival, laps), families()[found.family[c]]
    if family.kind is SHORT:
        # The least ΔV for eccentric ends has no burns, so none of it is asked for here.
        times, vectors, phases = burn_kernels.burns_between(
            physics.leaving(i, departure), physics.elements[j], 0.0, physics.rule, *stated
        )
        leaves = float(times[0])
        if not np.isfinite(np.column_stack([times, vectors])).all():
            yield f"{said}: no crossing of the line of nodes leads to its arrival"
            return
        names_of = tuple(burn_kernels.PHASES[phase] for phase in phases)
        burns = burns_of(times, vectors, names_of)
    elif family in registered_of(instance):
        flown = family.flown(connecting.ends.of(i, j), stated)
        leaves, burns = flown.departure, burns_of(*flown.manoeuvres)
    leg = Leg(
        kind=family.kind.name,
        origin=names[i],
        destination=names[j],
        ready_s=departure,
        departure_s=leaves,
        arrival_s=arrival,
        end_s=arrival,
        delta_v_m_s=delta_v,
        delta_v_left_m_s=0.0,
        phasing_revolutions=max(laps, 0),
        burns=burns,
    )
    for violation in check_transfer(
        instance, physics, instance.chasers[connecting.chaser], 1, leg, (i, j), departure
    ):
        if violation.rule not in NO_RULES:
            yield f"{said}: {violation.rule}: {violation.message}"


def _is_matched(instance: Instance, found: Connections, way: Way, resolution: float) -> bool:
    """Whether a transfer is not required, or a connection is as good."""
    if way.delta_v > instance.largest_tank_m_s or way.arrival > instance.mission.duration_s:
        return True
    early = way.early + (ROUNDED_S if instance.nodes_drift else TIME_TOLERANCE_S)
    most = way.delta_v + resolution + DELTA_V_TOLERANCE_M_S
    as_good = (
        (found.departure >= way.departure - early)
        & (found.arrival <= way.arrival + TIME_TOLERANCE_S)
        & (found.delta_v <= most)
    )
    return bool(as_good.any())


def _is_barred(instance: Instance, physics: Physics, way: Way, i: int, j: int) -> bool:
    """Whether a body has sunk too low, or a tow from it may end too far from its circle.

    Connections leave these bodies out (docs/model.md section 1.5). This is found out here by the
    physics of `check`.
    """
    if physics.given is not None:
        return False
    heights, at_station, begins = Heights(instance), j < instance.first_target, way.arrival
    if not at_station:
        target = instance.targets[j - instance.first_target]
        towed = physics.towed.get(target.name)
        if outstays(instance, target, towed, NEAR):
            return True
        if is_uncontrolled(instance, target, towed, CONTROLLED_M):
            return True
        stay = service_s(instance, physics.elements[j], at_station)
        capture = stay if target.capture_s is None else target.capture_s
        begins = begin_of(instance.intervals_of(target), begins, capture - SLACK_S)
    ends = [(i, way.departure), (j, begins + service_s(instance, physics.elements[j], at_station))]
    for body, time_s in ends:
        name = instance.names[body]
        tow = physics.towed.get(name)
        if tow is not None and body == i:
            time_s -= tow.time_s
        if heights.perigee_m(name, time_s + SINKING_S) < heights.least_m(name):
            return True
        if tow is not None and may_end_far(tow, time_s, instance.oblateness_m2):
            return True
    return False
