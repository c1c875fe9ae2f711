"""Small missions for practice: of low thrust, and with arrivals that are functions of time."""

from __future__ import annotations

from datetime import UTC, datetime
from itertools import cycle, permutations

import numpy as np

from ..common.constants import DAY_S
from ..problem.bodies import Station, Target
from ..problem.chasers import AtStation, Chaser, Tank
from ..problem.given import only
from ..problem.given_functions import of_breakpoints
from ..problem.instance import Instance
from ..problem.settings import GivenFile, MissionSettings, Objective, TransferSettings
from ..sources.generator import generate

PRIZES = (1.0, 1.1, 1.2)
"""Unequal, so that no method ends at once."""

SPAN_S = 100.0
"""Duration of missions with functions of time [s]."""


def electric_instance(several: bool) -> Instance:
    """Two years of one chaser with low thrust or two, some of whose targets are towed."""
    field = generate("electric", 0, targets=12, chasers=2 if several else 1)
    # Of one kind, or hardly any pair would have a leg.
    lighter = [target for target in field.targets if (target.mass_kg or 0.0) < 2000.0]
    return field.replace(
        targets=tuple(
            target.replace(prize=prize, removal=removal)
            for target, prize, removal in zip(
                lighter, cycle(PRIZES), cycle(("tow", "visit")), strict=False
            )
        ),
        mission=field.mission.replace(duration_s=730.0 * DAY_S),
        transfer=field.transfer.replace(drift_step_s=40.0 * DAY_S, max_drift_s=200.0 * DAY_S),
    )


def timed_instance(required: bool) -> Instance:
    """A van whose roads take longer at noon; of all its targets, or of the best of them."""
    names = ["depot", *(f"target-{number}" for number in range(5))]
    pairs = []
    for at, (i, j) in enumerate(permutations(names, 2)):
        least = 3.0 + at % 7
        departures = np.array([0.0, 0.4 * SPAN_S, 0.9 * SPAN_S])
        arrivals = departures + least + np.array([0.0, 4.0, 1.0])
        pairs.append((i, j, np.column_stack([departures, arrivals]), 0.0 if required else 1.0))
    targets = tuple(
        Target(name=name, prize=prize, required=required)
        for name, prize in zip(names[1:], cycle(PRIZES), strict=False)
    )
    made = Instance(
        name="practice",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name=names[0]),),
        targets=targets,
        chasers=(
            Chaser(name="van", start=AtStation(station=names[0]), tank=Tank(delta_v_m_s=4.0)),
        ),
        mission=MissionSettings(duration_s=SPAN_S, service_s=2.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration" if required else "delta-v"),
        transfer=TransferSettings(given=GivenFile(functions="practice.json")),
    )
    return made.with_given(only(of_breakpoints(pairs, names)))
