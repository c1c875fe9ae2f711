"""The best plan of a small mission by enumeration: the yardstick for planners and bounds.

All sets of targets and all bodies to be at, with every way worth having to get there over every
connection. The rules are read from the instance here once more, plainly.
"""

from __future__ import annotations

import math

import numpy as np

from adr_opt.common.constants import SLACK_M_S, SLACK_S
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs.found import GIVEN
from adr_opt.legs.connections import Connections
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, Expense, TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit


@kernel
def _enumerate(  # noqa: PLR0913
    first_leg,
    departure,
    arrival,
    delta_v,
    service,
    opens,
    closes,
    first_target,
    stations,
    start,
    begin,
    full,
    at_start,
    most,
    between,
    takes,
    kits,
    kit,
    dry,
    exhaust,
    weighs,
    limited,
    tows,
    last,
    steps,
):
    """All labels (set, body, time, left, cost, parent); lists of a set and a body are chained.

    What is left is a ΔV, or the mass of a chaser that has ``exhaust`` m/s; ``full`` is that of a
    full tank with the kits still aboard, and ``at_start`` of the tank that it begins with. Where
    expenses ``weigh`` masses the cost is what had to be carried: a
    label has the ΔV of its first tank, and the mass at the start that kits and towed objects have
    taken which are left behind, or all of it once that tank is done. Of stations that are
    ``limited`` each label has how often it refuelled there, and by how many kilograms. ``tows`` are
    time, ΔV and mass of what is towed, body by body, and no tow ends after ``last``. ``steps`` are
    body, time and loss of prizes that fall: the loss of a service that ends later. A label has the
    sum of them last. Of targets at most ``between`` are serviced before a refuelling and after it.
    """
    bodies = service.size
    sets = 1 << (bodies - first_target)
    room = 1024
    where = np.empty((room, 3), np.int64)  # set, body, parent
    what = np.empty((room, 3))  # time, left, ΔV
    more = np.zeros(
        (room, 4 + 2 * stations)
    )  # ΔV of the first tank, mass, whether it is done, uses, loss
    chain = np.empty(room, np.int64)
    since = np.zeros(room, np.int64)  # targets since the last refuelling
    head = np.full((sets, bodies), -1)
    where[0, 0], where[0, 1], where[0, 2] = 0, start, -1
    what[0, 0], what[0, 1], what[0, 2] = begin, at_start[kits], 0.0
    chain[0] = -1
    head[0, start] = 0
    count = 1
    for done in range(sets):
        size, aboard = 0, kits
        for j in range(bodies - first_target):
            size += done >> j & 1
            aboard -= (done >> j & 1) * takes[first_target + j]
        if aboard < 0:
            continue
        # Those at targets first: from there others of the same set come to be at stations.
        for turn in range(2):
            for i in range(bodies):
                at_station = i < stations
                if at_station != (turn == 1):
                    continue
                label = head[done, i]
                while label >= 0:
                    for j in range(bodies):
                        if j == i or (j < stations and (at_station or i == start)):
                            continue
                        if stations <= j < first_target:
                            continue
                        after = done
                        if j >= first_target:
                            bit = 1 << (j - first_target)
                            if done & bit or size == most or since[label] == between:
                                continue
                            after = done | bit
                            if takes[j] > aboard:
                                continue
                        for c in range(first_leg[i, j], first_leg[i, j + 1]):
                            if departure[c] < what[label, 0] - SLACK_S:
                                continue
                            end = max(arrival[c], opens[j]) + service[j]
                            if end > closes[j]:
                                continue
                            end += tows[j, 0]
                            if end > last:
                                continue
                            left, least = what[label, 1] - delta_v[c], 0.0
                            if exhaust > 0.0:
                                left = what[label, 1] * math.exp(-delta_v[c] / exhaust)
                                least = (dry + aboard * kit) * math.exp(-SLACK_M_S / exhaust)
                            if left < least:
                                continue
                            left = full[aboard] if j < stations else left - kit * takes[j]
                            if tows[j, 1] > 0.0:
                                kept = math.exp(-tows[j, 1] / exhaust)
                                left = (left + tows[j, 2]) * kept - tows[j, 2]
                                if left < least:
                                    continue
                            cost = 0.0 if weighs else what[label, 2] + delta_v[c] + tows[j, 1]
                            now = more[label].copy()
                            if weighs and now[2] == 0.0:
                                now[0] += delta_v[c]
                                lifted = math.exp(now[0] / exhaust)
                                now[1] += lifted * kit * takes[j]
                                if tows[j, 1] > 0.0:
                                    now[1] += lifted * tows[j, 2] * math.expm1(tows[j, 1] / exhaust)
                                    now[0] += tows[j, 1]
                                if j < stations:
                                    now[1] += lifted * (dry + aboard * kit)
                                    now[0], now[2] = 0.0, 1.0
                            if j < stations and limited[j]:
                                now[3 + 2 * j] += 1.0
                                if exhaust > 0.0:
                                    before = what[label, 1] * math.exp(-delta_v[c] / exhaust)
                                    now[4 + 2 * j] += full[aboard] - before
                            lost = 0.0
                            for step in range(steps.shape[0]):
                                if steps[step, 0] == j and end > steps[step, 1] + SLACK_S:
                                    lost = max(lost, steps[step, 2])
                            now[now.size - 1] += lost
                            visits = since[label] + 1 if j >= first_target else 0
                            other = head[after, j]
                            while other >= 0:
                                if (
                                    what[other, 0] <= end
                                    and what[other, 1] >= left
                                    and what[other, 2] <= cost
                                    and more[other, 2] == now[2]
                                    and (since[other] <= visits or between >= bodies)
                                ):
                                    worse = False
                                    for column in range(now.size):
                                        worse = worse or more[other, column] > now[column]
                                    if not worse:
                                        break
                                other = chain[other]
                            if other >= 0:
                                continue
                            if count == room:
                                where = np.concatenate((where, np.empty((room, 3), np.int64)))
                                what = np.concatenate((what, np.empty((room, 3))))
                                chain = np.concatenate((chain, np.empty(room, np.int64)))
                                since = np.concatenate((since, np.empty(room, np.int64)))
                                more = np.concatenate((more, np.empty((room, now.size))))
                                room *= 2
                            where[count, 0], where[count, 1], where[count, 2] = after, j, label
                            what[count, 0], what[count, 1], what[count, 2] = end, left, cost
                            more[count], since[count] = now, visits
                            chain[count] = head[after, j]
                            head[after, j] = count
                            count += 1
                    label = chain[label]
    return where[:count], what[:count], more[:count]


def revolution_s(orbit: Orbit | None, dynamics: str) -> float:
    """Nodal period of a body: mean elements, secular rates.

    See docs/model.md section 1.

    0 without an orbit, where nothing is counted in it.
    """
    if orbit is None:
        return 0.0
    a, e, cosine = (
        orbit.semi_major_axis_m,
        orbit.eccentricity,
        math.cos(math.radians(orbit.inclination_deg)),
    )
    n = math.sqrt(398600.4418e9 / a**3)
    if dynamics == "two-body":
        return 2.0 * math.pi / n
    strength = 0.75 * 1.08262668e-3 * (6378137.0 / (a * (1.0 - e * e))) ** 2 * n
    perigee = strength * (5.0 * cosine**2 - 1.0)
    anomaly = n + strength * math.sqrt(1.0 - e * e) * (3.0 * cosine**2 - 1.0)
    return 2.0 * math.pi / (perigee + anomaly)


def tow_of(target: Target, instance: Instance) -> tuple[float, float, float]:
    """Time [s], ΔV [m/s] and mass [kg] of a tow: half an ellipse between two circles."""
    assert target.orbit is not None
    assert target.mass_kg is not None
    high, low = target.orbit.semi_major_axis_m, 6378137.0 + instance.mission.disposal_altitude_m
    mu, axis = 398600.4418e9, 0.5 * (high + low)
    delta_v = math.sqrt(mu / high) * (1.0 - math.sqrt(low / axis)) + math.sqrt(mu / low) * (
        math.sqrt(high / axis) - 1.0
    )
    ellipse = target.orbit.replace(semi_major_axis_m=axis, eccentricity=0.0)
    return 0.5 * revolution_s(ellipse, instance.dynamics), delta_v, target.mass_kg


def price_of_time(instance: Instance) -> float:
    """Price of a second of a chaser beyond its ΔV: as stated, or one resolution per mission."""
    if instance.objective.cost != "delta-v":
        return 0.0
    if instance.objective.time_m_s_per_day is not None:
        return instance.objective.time_m_s_per_day / 86400.0
    if instance.given is not None:
        return 0.0
    return instance.transfer.delta_v_resolution_m_s / instance.mission.duration_s


def labels_of(mission: Mission) -> tuple[np.ndarray, np.ndarray]:
    """The labels of :func:`labels_and_uses`, without the use of stations."""
    return labels_and_uses(mission)[:2]


def launch_s(mission: Mission) -> float:
    """Since when a chaser may fly: launches in their order if they are so long apart [s]."""
    instance, last = mission.instance, -math.inf
    apart = instance.mission.launch_separation_s
    for chaser in instance.chasers:
        since = chaser.available_s[0]
        if chaser.start == "anywhere" and apart is not None:
            since = last = max(since, last + apart)
        if chaser == mission.chaser:
            return since
    raise AssertionError("no chaser of the instance")


def labels_and_uses(mission: Mission) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All ways worth having to have done a set of targets and be at a body, see _enumerate."""
    instance = mission.instance
    chaser, first = mission.chaser, instance.first_target
    bodies = len(instance.names)
    stations = len(instance.stations)
    service, opens, closes = np.zeros(bodies), np.zeros(bodies), np.zeros(bodies)
    tows = np.zeros((bodies, 3))
    last = [instance.mission.duration_s]
    if chaser.available_s[1] is not None:
        last.append(chaser.available_s[1])
    for j, orbit in enumerate(instance.known_orbits):
        turn = revolution_s(orbit, instance.dynamics)
        closes[j] = min(last)
        if j < first:
            service[j] = instance.mission.refuel_revolutions * turn
            continue
        target = instance.targets[j - first]
        if instance.mission.service_s is not None:
            service[j] = instance.mission.service_s
        else:
            service[j] = (instance.mission.service_revolutions or 0.0) * turn
        opens[j] = target.window_s[0]
        if target.window_s[1] is not None:
            closes[j] = min(closes[j], target.window_s[1])
        if target.removal == "tow":
            tows[j] = tow_of(target, instance)
    # Where planes drift, what saves no more than the resolution is no part of the problem.
    resolution = 0.0
    if instance.dynamics == "j2":
        resolution = instance.transfer.delta_v_resolution_m_s
    if instance.given is None:
        pairs = [
            mission.timetable.connections(i, j, resolution_m_s=resolution)
            for i in range(bodies)
            for j in range(bodies)
        ]
    else:
        pairs = _as_given(mission)
    sizes = np.array([pair.departure.size for pair in pairs])
    ends = np.cumsum(sizes).reshape(bodies, bodies)
    first_leg = np.empty((bodies, bodies + 1), dtype=np.int64)
    first_leg[:, 1:] = ends
    first_leg[:, 0] = ends[:, 0] - sizes.reshape(bodies, bodies)[:, 0]
    takes = np.zeros(bodies, dtype=np.int64)
    takes[first:] = [target.removal == "kit" for target in instance.targets]
    most_kits = int(takes.sum()) if chaser.kits is None else min(chaser.kits, int(takes.sum()))
    tank, kit = chaser.tank, chaser.kit_mass_kg
    dry, exhaust = 0.0, 0.0
    if isinstance(tank, TankByMass):
        dry, exhaust = tank.dry_mass_kg, 9.80665 * tank.isp_s
        full = []
        for kits in range(most_kits + 1):
            empty = dry + kits * kit
            delta_v = exhaust * math.log((empty + tank.propellant_kg) / empty)
            full.append(empty * math.exp(delta_v * (1.0 - mission.margin) / exhaust))
    else:
        full = [tank.delta_v_m_s * (1.0 - mission.margin) + SLACK_M_S] * (most_kits + 1)
    steps = np.array(
        [
            (first + n, until_s, target.prize_until[0][1] - after)
            for n, target in enumerate(instance.targets)
            if target.prize_until
            for (until_s, _), after in zip(
                target.prize_until,
                [*(prize for _, prize in target.prize_until[1:]), target.prize],
                strict=True,
            )
        ]
    ).reshape(-1, 3)
    wheres, whats, uses, before = [], [], [], 0
    targets = len(instance.targets)
    weighs = instance.objective.cost == "expense" and dry > 0.0
    for kits in range(most_kits + 1):
        where, what, more = _enumerate(
            first_leg,
            np.concatenate([pair.departure for pair in pairs]),
            np.concatenate([pair.arrival for pair in pairs]),
            np.concatenate([pair.delta_v for pair in pairs]),
            service,
            opens,
            closes + SLACK_S,
            first,
            stations,
            instance.names.index(chaser.start_name),
            launch_s(mission),
            np.array(full),
            np.array(_at_start(chaser, full)),
            bodies if chaser.max_targets is None else chaser.max_targets,
            chaser.max_visits_between_refuels or bodies,
            takes,
            kits,
            kit,
            dry,
            exhaust,
            weighs,
            np.array([each.is_limited for each in instance.stations], np.bool_),
            tows,
            min(last) + SLACK_S,
            steps,
        )
        if instance.objective.cost == "expense":
            price = chaser.expense or Expense()
            aboard = kits - sum((where[:, 0] >> n & 1) * takes[first + n] for n in range(targets))
            lifted = np.exp(more[:, 0] / exhaust) if weighs else 0.0
            weight = more[:, 1] + (more[:, 2] == 0.0) * lifted * (dry + aboard * kit) - dry
            what[:, 2] = price.fixed
            if weighs:
                what[:, 2] += price.per_kg * weight + price.per_kg_squared * weight**2
            what[0, 2] = 0.0
        what[:, 2] += price_of_time(instance) * (what[:, 0] - launch_s(mission))
        where[1:, 2] += before
        wheres.append(where)
        whats.append(what)
        uses.append(more[:, 3:])
        before += len(where)
    # A chaser that brings kits back could have left them at home.
    return np.concatenate(wheres), np.concatenate(whats), np.concatenate(uses)


def _at_start(chaser: Chaser, full: list[float]) -> list[float]:
    """Content of the tank at the start: all of it, or as stated by the chaser."""
    tank = chaser.tank
    if isinstance(tank, TankByMass):
        if tank.initial_propellant_kg is None:
            return full
        # What is lacking is ΔV of the whole tank, also where a margin of it is kept back.
        empty = [tank.dry_mass_kg + kits * chaser.kit_mass_kg for kits in range(len(full))]
        return [
            each * (alone + tank.initial_propellant_kg) / (alone + tank.propellant_kg)
            for each, alone in zip(full, empty, strict=True)
        ]
    if tank.initial_delta_v_m_s is None:
        return full
    return [each - (tank.delta_v_m_s - tank.initial_delta_v_m_s) for each in full]


def _as_given(mission: Mission) -> list[Connections]:
    """All given connections of all pairs, including useless ones."""
    instance, given = mission.instance, mission.instance.given
    assert given is not None
    known = {name: number for number, name in enumerate(instance.names)}
    ends = np.array([known.get(name, -1) for name in given.names], dtype=np.int64)
    pairs = []
    for i in range(len(instance.names)):
        for j in range(len(instance.names)):
            rows = np.flatnonzero((ends[given.origin] == i) & (ends[given.destination] == j))
            if i in instance.launches or j in instance.launches:
                pairs.append(mission.timetable.connections(i, j))
                continue
            columns = (column[rows] for column in (given.departure, given.arrival, given.cost))
            numbers = np.zeros((2, rows.size), dtype=np.int8)
            numbers[1] = GIVEN
            pairs.append(Connections(*columns, *numbers))
    return pairs


def brute_force(mission: Mission) -> tuple[float, float, tuple[int, ...]]:
    """The most prizes, their least cost, and a sequence of bodies that has both.

    Prizes are −inf where no plan keeps to all rules.
    """
    instance, chaser = mission.instance, mission.chaser
    where, what, uses = labels_and_uses(mission)
    best: tuple[float, float, int] = (-math.inf, -math.inf, -1)
    needed = sum(1 << n for n, target in enumerate(instance.targets) if target.required)
    for label, ((done, body, _), (time, _, spent), use) in enumerate(
        zip(where, what, uses, strict=True)
    ):
        end = chaser.end if isinstance(chaser.end, str) else chaser.end.station
        if (done & needed) != needed or end not in ("anywhere", instance.names[body]):
            continue
        prizes = _collected(instance, int(done), float(use[-1]))
        by_time = instance.objective.cost == "duration"
        cost = (time if done else 0.0) if by_time else spent
        best = max(best, (prizes, -cost, label), key=lambda one: one[:2])
    sequence = []
    label = best[2]
    while label >= 0 and where[label, 2] >= 0:
        sequence.append(int(where[label, 1]))
        label = int(where[label, 2])
    return best[0], -best[1], tuple(reversed(sequence))


def _collected(instance: Instance, done: int, lost: float) -> float:
    """Sum of the prizes of a set of targets, each the greatest, less what they have fallen by."""
    chosen = [target for n, target in enumerate(instance.targets) if done >> n & 1]
    most = math.fsum(t.prize_until[0][1] if t.prize_until else t.prize for t in chosen)
    # Sums of losses in another order are the same losses.
    return round(most - lost, 9) if lost else most


Ways = dict[int, list[tuple[float, tuple[float, ...]]]]


def _keep(ways: Ways, done: int, cost: float, use: tuple[float, ...]) -> None:
    """Keep a way to do a set unless another one costs and takes no more."""
    known = ways.setdefault(done, [])
    new = (cost, *use)
    if any(all(a <= b for a, b in zip((c, *u), new, strict=True)) for c, u in known):
        return
    known[:] = [
        (c, u) for c, u in known if not all(a >= b for a, b in zip((c, *u), new, strict=True))
    ]
    known.append((cost, use))


def brute_force_campaign(campaign: Problem) -> tuple[float, float]:
    """The most prizes that all chasers together collect, and the least cost of that.

    Every partition of every set of targets among them. Prizes are −inf where no plan keeps to all
    rules.
    """
    instance = campaign.instance
    by_time = instance.objective.cost == "duration"
    limits = [math.inf] * (2 * len(instance.stations))
    for number, station in enumerate(instance.stations):
        if station.max_refuellings is not None:
            limits[2 * number] = station.max_refuellings
        if station.max_propellant_kg is not None:
            limits[2 * number + 1] = station.max_propellant_kg
    limits.append(math.inf)  # of what prizes have fallen by
    none = (0.0,) * len(limits)
    # For each set the ways to do it worth having: what they cost, and take of stations.
    together: Ways = {0: [(0.0, none)]}
    for mission in campaign.missions:
        end = (
            mission.chaser.end
            if isinstance(mission.chaser.end, str)
            else mission.chaser.end.station
        )
        ways: Ways = {}
        for (done, body, _), (time, _, spent), use in zip(*labels_and_uses(mission), strict=True):
            if end in ("anywhere", instance.names[body]):
                cost = spent if not by_time else (time if done else 0.0)
                _keep(ways, int(done), cost, tuple(use))
        after: Ways = {}
        for done, known in together.items():
            for more, added in ways.items():
                for cost, use in [] if done & more else known:
                    for and_cost, and_use in added:
                        taken = tuple(map(float.__add__, use, map(float, and_use)))
                        both = max(cost, and_cost) if by_time else cost + and_cost
                        if all(one <= most for one, most in zip(taken, limits, strict=True)):
                            _keep(after, done | more, both, taken)
        together = after
    needed = sum(1 << n for n, target in enumerate(instance.targets) if target.required)
    best = (-math.inf, -math.inf)
    for done, known in together.items():
        if known and done & needed == needed:
            for cost, use in known:
                best = max(best, (_collected(instance, done, use[-1]), -cost))
    return best[0], -best[1]
