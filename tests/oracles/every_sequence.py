"""All flyable sequences of a departure, by trying every (k, m): the yardstick of choices."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from adr_opt.kernels.legs import co_elliptic, zones
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.problem.instance import Instance


class Flown(NamedTuple):
    """One sequence: times in seconds, the ΔV in m/s, the phasing radius in metres."""

    departure: float
    arrival: float
    delta_v: float
    revolutions: int
    radius: float


def sequences(
    pair: co_elliptic.Pair, rule: co_elliptic.TransferRule, departure: float, lead: float
) -> Iterator[Flown]:
    """All sequences between the altitude limits that no zone forbids."""
    lap = 2.0 * math.pi / pair.rate_j
    for k in range(rule.max_phasing_revolutions + 1):
        low = pair.shortest + k * pair.shortest_lap
        high = pair.longest + k * pair.longest_lap
        time = (3.0 * math.pi - lead + rule.standoff / pair.radius_j) / pair.rate_j
        time += math.ceil((low - time) / lap) * lap
        while time <= high:
            radius = co_elliptic.phasing_radius(pair, rule, k, time)
            if not zones.is_blocked(pair, rule, k, radius, departure):
                delta_v = co_elliptic.leg_delta_v(pair, rule, k, radius, departure, time, pair.turn)
                arrival = departure + time + rule.approach_revolutions * lap
                yield Flown(departure, arrival, delta_v, k, radius)
            time += lap


def of_pair(instance: Instance, i: int, j: int, since: float, until: float) -> list[list[Flown]]:
    """The sequences of each departure event of a pair between two times, in order of departure."""
    elements, rule = instance.orbits(), instance.transfer_rule()
    extra = float(instance.eccentricity_delta_v()[i, j])
    pair = co_elliptic.prepare(elements[i], elements[j], extra, rule, 0.0)
    half_period = 0.5 * ephemeris.period(elements[i, columns.RADIUS])
    half_turns = math.ceil((pair.phase_i + pair.rate_i * since) / math.pi)
    found = []
    while (departure := (half_turns * math.pi - pair.phase_i) / pair.rate_i) <= until:
        lead = (pair.phase_j + pair.rate_j * departure - math.pi * half_turns) % (2.0 * math.pi)
        found.append(list(sequences(pair, rule, departure, lead)))
        half_turns += 1
        assert len(found) < 2 + (until - since) / half_period
    return found
