"""Enumeration of all routes where arrivals are functions of time: all orders, all rows."""

from __future__ import annotations

import math
from itertools import pairwise

from adr_opt.problem.instance import Instance

SLACK = 1e-6


def arrival_of(points: list[tuple[float, float]], ready: float) -> float:
    """Earliest arrival by a function, from its definition: the least over all later departures."""
    if ready > points[-1][0] + SLACK:
        return math.inf
    found = [lands for leaves, lands in points if leaves >= ready - SLACK]
    for (a, x), (b, y) in pairwise(points):
        if a <= ready <= b and a < b:
            found.append(x + (y - x) * (ready - a) / (b - a))
    # Of a jump at the ready time the earlier end counts, which the first list has.
    return min(found)


def best_route(instance: Instance) -> tuple[float, float]:
    """Most prizes with all required targets, and the least cost of that; −inf if there is none."""
    chaser, mission = instance.chaser, instance.mission
    stations = [station.name for station in instance.stations]
    targets = {target.name: target for target in instance.targets}
    given, by_time = instance.given, instance.objective.cost == "duration"
    most = len(targets) if chaser.max_targets is None else chaser.max_targets
    required = {name for name, target in targets.items() if target.required}
    end_at = None if isinstance(chaser.end, str) else chaser.end.station
    best = (-math.inf, -math.inf)

    def legs(i: str, j: str, ready: float) -> list[tuple[float, float]]:
        function = given.functions and given.functions.of_pair(i, j)
        if function is not None:
            points = list(zip(function.departure.tolist(), function.arrival.tolist(), strict=True))
            return [(arrival_of(points, ready), function.cost)]
        leaves, lands, costs = given.of_pair(i, j)
        rows = zip(leaves.tolist(), lands.tolist(), costs.tolist(), strict=True)
        return [(arrival, cost) for departure, arrival, cost in rows if departure >= ready - SLACK]

    def go_on(here: str, time: float, left: float, cost: float, done: frozenset[str]) -> None:
        nonlocal best
        if required <= done and end_at in (None, here):
            prize = math.fsum(targets[name].prize for name in done)
            paid = (time if done else 0.0) if by_time else cost
            best = max(best, (prize, -paid))
        for there in [*stations, *targets]:
            is_station = there in stations
            if there == here or there in done or (is_station and here in stations):
                continue
            if not is_station and len(done) == most:
                continue
            windows, capture, service = [[0.0, math.inf]], 0.0, 0.0
            if not is_station:
                target, service = targets[there], mission.service_s
                windows = instance.intervals_of(target).tolist()
                capture = service if target.capture_s is None else target.capture_s
            for arrival, delta_v in legs(here, there, time):
                begins = [max(arrival, opens) for opens, _ in windows]
                fit = [
                    begin
                    for begin, (_, closes) in zip(begins, windows, strict=True)
                    if begin + capture <= closes + SLACK
                ]
                end = min(fit, default=math.inf) + service
                if end > mission.duration_s + SLACK or delta_v > left + SLACK:
                    continue
                rest = chaser.tank.delta_v_m_s if is_station else left - delta_v
                go_on(there, end, rest, cost + delta_v, done if is_station else done | {there})

    go_on(chaser.start.station, chaser.available_s[0], chaser.tank.delta_v_m_s, 0.0, frozenset())
    return best[0], -best[1]
