"""Drawn missions of chasers with low thrust, and their optimum by enumeration with exact masses."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
from random_rules import freely

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import low_thrust, low_thrust_windows
from adr_opt.kernels.legs.low_thrust_arcs import Thrust
from adr_opt.legs.families.ends import AllEnds
from adr_opt.plan.tows import removals_of
from adr_opt.problem.drives import Drive, drive_of, since_j2000_s
from adr_opt.problem.instance import Instance

STEPS = 12
MASSES = 4
"""Number of masses to which a chaser may vent, and as which it may fly a leg."""


def electric(
    seed: int,
    *,
    targets: int = 4,
    chasers: int = 1,
    kits: bool = False,
    tows: bool = False,
    resolution_m_s: float = 0.5,
    free: bool = False,
) -> Instance:
    """A mission of some months in which not everything can be done."""
    rng = np.random.default_rng(seed)
    field = adr_opt.generate("sso", seed, targets=targets)
    duration = float(rng.uniform(60.0, 200.0)) * DAY_S / chasers
    fleet = []
    for number in range(chasers):
        fleet.append(
            {
                "name": f"chaser-{number}",
                "start": {"orbit": field.targets[number].orbit.replace(raan_deg=1.0).model_dump()},
                "tank": {
                    "dry_mass_kg": float(rng.uniform(150.0, 300.0)),
                    "propellant_kg": float(rng.uniform(5.0, 25.0)),
                    "isp_s": 1500.0,
                },
                "thrust_n": float(rng.uniform(0.03, 0.15)),
                "duty_cycle": float(rng.choice([0.6, 0.9])),
                "kit_mass_kg": 20.0 if kits else 0.0,
                "kits": int(rng.integers(1, 4)) if kits else None,
            }
        )
    bodies: list[dict[str, Any]] = []
    for target in field.targets:
        body = target.model_dump(mode="json")
        body["orbit"]["raan_deg"] = float(rng.normal(0.0, 4.0)) % 360.0
        body["prize"] = float(rng.integers(1, 4))
        if kits:
            body["removal"] = str(rng.choice(["kit", "visit"]))
        if tows:
            body["removal"] = str(rng.choice(["tow", "tow", "visit"]))
            body["mass_kg"] = float(rng.uniform(50.0, 400.0))
        bodies.append(body)
    content = field.model_dump(mode="json") | {"targets": bodies, "chasers": fleet, "stations": []}
    content["mission"] = {"duration_s": duration, "service_s": DAY_S}
    if tows:
        content["mission"] |= {"disposal": {"circle_m": 4.5e5}}
    content["transfer"] |= {
        "max_drift_s": duration,
        "drift_step_s": duration / STEPS,
        "departure_spacing_s": DAY_S,
        "delta_v_resolution_m_s": resolution_m_s,
    }
    made = adr_opt.problem.instance.instance_of(content)
    return freely(made, seed) if free else made


@kernel
def _cost(pair, drive, classes, mass, departure, arrival):
    """Least ΔV of a chaser of a mass, which may fly a leg as one of several larger masses [m/s]."""
    thrust, exhaust, _, heaviest = drive
    least = math.inf
    for share in range(MASSES + classes.size):
        if share < MASSES:
            flown_as = mass + (heaviest - mass) * share / (MASSES - 1)
        else:
            flown_as = classes[share - MASSES]
        if flown_as < mass:
            continue
        found = low_thrust.delta_v(pair, Thrust(thrust / flown_as, exhaust), departure, arrival)
        least = min(least, found)
    return least


@kernel
def after(pair, drive, classes, empty, mass, departure, arrival):
    """Largest mass after a leg, propellant vented before it; less than empty if there is none.

    Down to one of several masses, those of the classes among them.
    """
    best = 0.0
    for share in range(MASSES + classes.size):
        if share < MASSES:
            vented = mass - (mass - empty) * share / MASSES
        else:
            vented = classes[share - MASSES]
        if not empty <= vented <= mass:
            continue
        cost = _cost(pair, drive, classes, vented, departure, arrival)
        best = max(best, vented * math.exp(-cost / drive[1]))
    return best


class Enumerated:
    """What each chaser can do alone: all sets of targets, over times and masses."""

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        self._since = since_j2000_s(instance.epoch)

    def _pairs(self, drive: Drive) -> dict[tuple[int, int], Any]:
        ends = AllEnds(self._instance, drive)
        bodies = range(len(self._instance.names))
        return {
            (i, j): low_thrust_windows.prepare(
                ends.leaving[i], ends.arriving[j], ends.rule, self._since, 0.0
            )
            for i, j in product(bodies, bodies)
            if i != j
        }

    def sets_of(self, number: int) -> set[frozenset[int]]:
        """Sets of targets that a chaser can service."""
        instance = self._instance
        chaser, first = instance.chasers[number], instance.first_target
        drive = drive_of(chaser, instance.targets)
        assert drive is not None
        pairs = self._pairs(drive)
        takers = {
            first + at for at, target in enumerate(instance.targets) if target.service.takes_kit
        }
        done: set[frozenset[int]] = {frozenset()}
        most = len(takers) if chaser.kits is None else min(chaser.kits, len(takers))
        for kits in range(most + 1):
            done |= self._with_kits(drive, number, pairs, takers, kits)
        return done

    def _with_kits(
        self, drive: Drive, number: int, pairs: Any, takers: set[int], kits: int
    ) -> set[frozenset[int]]:
        """The same for a number of kits at the start."""
        instance = self._instance
        chaser, first = instance.chasers[number], instance.first_target
        tank: Any = chaser.tank
        step, service = instance.transfer.drift_step_s, instance.mission.service_s
        assert service is not None
        tows = removals_of(instance, drive)
        classes = np.array(drive.classes_kg(instance.transfer.mass_class))
        start = tank.dry_mass_kg + tank.propellant_kg + kits * chaser.kit_mass_kg
        states: dict[tuple[frozenset[int], int, int], float] = {
            (frozenset(), instance.starts[number], 0): start
        }
        found: set[frozenset[int]] = {frozenset()}
        for _ in instance.targets:
            following: dict[tuple[frozenset[int], int, int], float] = {}
            for (visited, body, leaves), mass in states.items():
                aboard = kits - len(visited & takers)
                empty = tank.dry_mass_kg + aboard * chaser.kit_mass_kg
                for j in range(first, len(instance.names)):
                    if j in visited or (j in takers and aboard == 0):
                        continue
                    for lands in range(leaves + 1, STEPS + 1):
                        end = lands * step + service
                        if end > instance.mission.duration_s + 1e-6:
                            break
                        left = after(
                            pairs[body, j], drive, classes, empty, mass, leaves * step, lands * step
                        )
                        if left < empty:
                            continue
                        left -= chaser.kit_mass_kg if j in takers else 0.0
                        if j in tows:
                            tow = tows[j]
                            end += tow.time_s
                            kept = math.exp(-tow.delta_v_m_s / drive.exhaust_m_s)
                            left = (left + tow.object_kg) * kept - tow.object_kg
                            if end > instance.mission.duration_s + 1e-6 or left < empty:
                                continue
                        key = visited | {j}, j, math.ceil(end / step - 1e-9)
                        following[key] = max(following.get(key, 0.0), left)
            found |= {visited for visited, _, _ in following}
            states = following
        return found

    def best(self) -> float:
        """Largest sum of prizes that all chasers together collect."""
        instance = self._instance
        prizes = [target.prize for target in instance.targets]
        sets = [self.sets_of(number) for number in range(len(instance.chasers))]
        most = 0.0
        for choice in product(*sets):
            union = frozenset().union(*choice)
            if len(union) == sum(map(len, choice)):
                most = max(most, sum(prizes[j - instance.first_target] for j in union))
        return most
