"""Drawn missions whose arrivals are functions of time."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import Given, among, of_rows, only
from adr_opt.problem.given_functions import Functions, of_breakpoints
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

SPAN_S = 100.0
"""Duration of the missions, about [s]."""


def drawn_function(rng: np.random.Generator) -> np.ndarray:
    """Breakpoints of a function that never overtakes, with flat parts or jumps or without."""
    count = int(rng.integers(1, 7))
    departure = np.sort(rng.integers(0, int(0.9 * SPAN_S), count)).astype(float)
    for at in range(2, count):
        if departure[at] == departure[at - 2]:
            departure[at:] += 1.0
    arrival = departure + rng.integers(3, 25, count) + rng.random(count) * rng.integers(0, 2)
    return np.column_stack([departure, np.maximum.accumulate(arrival)])


def timed_mission(seed: int, *, all_required: bool = False) -> Instance:
    """A mission of two to five targets with rules on and off, some pairs with lists beside."""
    rng = np.random.default_rng(seed)
    targets, stations = int(rng.integers(2, 5)), int(rng.integers(1, 3))
    names = [f"s{number}" for number in range(stations)]
    names += [f"t{number}" for number in range(targets)]
    lists = bool(rng.random() < 0.4)
    by_delta_v = bool(not all_required and rng.random() < 0.5)
    pairs, rows = [], []
    for i in names:
        for j in names:
            if i == j or rng.random() < (0.05 if all_required else 0.15):
                continue
            cost = float(rng.integers(0, 5)) if by_delta_v else 0.0
            if lists and rng.random() < 0.3:
                for _ in range(int(rng.integers(1, 4))):
                    leaves = float(rng.integers(0, int(0.9 * SPAN_S)))
                    cost = float(rng.integers(0, 5)) if by_delta_v else 0.0
                    rows.append((i, j, leaves, leaves + float(rng.integers(2, 25)), cost))
            else:
                pairs.append((i, j, drawn_function(rng), cost))
    given = _given(rows, of_breakpoints(pairs, names), names)
    made = Instance(
        name=f"timed-{seed}",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=tuple(Station(name=name) for name in names[:stations]),
        targets=tuple(_target(name, rng, all_required=all_required) for name in names[stations:]),
        chasers=(
            Chaser(
                name="van",
                start=AtStation(station="s0"),
                end=AtStation(station=names[stations - 1]) if rng.random() < 0.5 else "anywhere",
                tank=Tank(delta_v_m_s=float(rng.integers(4, 12)) if by_delta_v else 1.0),
                max_targets=None if all_required or rng.random() < 0.7 else targets - 1,
            ),
        ),
        mission=MissionSettings(
            duration_s=SPAN_S * (1.3 if all_required else float(rng.choice([0.6, 1.0]))),
            service_s=float(rng.choice([0.0, 2.0, 5.5])),
            refuel_revolutions=0.0,
        ),
        objective=Objective(cost="duration" if all_required or rng.random() < 0.5 else "delta-v"),
        transfer=TransferSettings(given=GivenFile(functions="f.json")),
    )
    return made.with_given(given)


def _given(rows: list[tuple[str, str, float, float, float]], functions: Functions, names) -> Given:
    if not rows:
        return only(functions)
    columns = zip(*rows, strict=True)
    keys = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    made = {key: np.array(values) for key, values in zip(keys, columns, strict=True)}
    return of_rows(made, names).with_functions(functions)


def _target(name: str, rng: np.random.Generator, *, all_required: bool) -> Target:
    opens = float(rng.choice([0.0, 0.0, 20.0, 35.0]))
    closes = None if rng.random() < 0.5 else opens + float(rng.integers(20, 80))
    return Target(
        name=name,
        prize=float(rng.integers(1, 5)),
        required=all_required or bool(rng.random() < 0.15),
        window_s=(opens, closes),
    )


def captured_timed(seed: int, *, all_required: bool = False) -> Instance:
    """The same with several windows of each target, and captures shorter than services."""
    rng, instance = np.random.default_rng([1, seed]), timed_mission(seed, all_required=all_required)
    service_s = instance.mission.service_s or 0.0
    targets = []
    for target in instance.targets:
        edges = np.sort(rng.integers(0, 100, 2 * int(rng.integers(2, 6)))).astype(float)
        windows = [*edges[:-2].reshape(-1, 2).tolist(), (float(edges[-2]), None)]
        capture_s = float(rng.choice([0.0, 0.5, 1.0])) * service_s
        targets.append(target.replace(window_s=(0.0, None), windows_s=windows, capture_s=capture_s))
    return instance.replace(targets=tuple(targets))


def two_chasers(seed: int) -> Instance:
    """The same for two chasers with other tanks and times, which count ΔV."""
    instance = timed_mission(seed)
    rng, van = np.random.default_rng([2, seed]), instance.chasers[0]
    other = van.replace(
        name="cart",
        tank=Tank(delta_v_m_s=float(rng.integers(2, 12))),
        available_s=(float(rng.choice([0.0, 10.0])), None),
    )
    return instance.replace(chasers=(van, other), objective=Objective(cost="delta-v"))


def alone(instance: Instance, chaser: int, dealt: tuple[int, ...]) -> Instance:
    """The mission of one chaser with the targets that are its own."""
    mine = [target for target, its in zip(instance.targets, dealt, strict=True) if its == chaser]
    names = [*(station.name for station in instance.stations), *(each.name for each in mine)]
    fewer = instance.with_given(among(instance.given, names))
    return fewer.replace(targets=tuple(mine), chasers=(instance.chasers[chaser],))
