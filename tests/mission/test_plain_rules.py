"""Enumeration itself, rule by rule, on fields small enough to be planned by hand.

Unless a case says otherwise, a depot and the targets A, B and C lie 10 m/s and 100 s apart, each
from each, and a connection departs every 100 s. Targets are worth 1, a stay takes no time, a tank
holds 30 m/s, and the chaser may end anywhere within 1,000 s: A, B, C, for 30 m/s. Tanks by mass
have an exhaust speed at which 10 m/s halve the mass.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import permutations
from typing import Any, NamedTuple

import pytest
from brute_force import best_of, brute_force_campaign, ways_of
from plain_rules import Tow
from plain_world import legs_of, world_of

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Expense, Tank, TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

NAMES = ("depot", "A", "B", "C")
HALVING = 10.0 / math.log(2.0) / 9.80665
"""Specific impulse of tanks by mass [s]."""

ROWS = [
    (origin, destination, 100.0 * number, 100.0 * number + 100.0, 10.0)
    for origin, destination in permutations(NAMES, 2)
    for number in range(10)
]


def field(rows: list[tuple[Any, ...]] = ROWS, **changes: Any) -> Instance:
    """The depot and its targets, with other values of targets (A, B, C), chasers, and the rest."""
    stated = {
        "end": "anywhere",
        "start": AtStation(station="depot"),
        "tank": Tank(delta_v_m_s=30.0),
    }
    chasers = [
        Chaser(**({"name": f"chaser {at}"} | stated | chaser))
        for at, chaser in enumerate(changes.get("chasers", [{}]))
    ]
    settings = {"duration_s": 1000.0, "service_s": 0.0, "refuel_revolutions": 0.0}
    instance = Instance(
        name="by hand",
        epoch="2026-05-04T06:00:00Z",
        stations=[Station(name="depot", **changes.get("depot", {}))],
        targets=[Target(name=name, **changes.get(name, {})) for name in NAMES[1:]],
        chasers=chasers,
        mission=MissionSettings(**(settings | changes.get("mission", {}))),
        objective=Objective(**changes.get("objective", {})),
        transfer=TransferSettings(given=GivenFile(file="rows.parquet")),
    )
    columns = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    table = dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True))
    return adr_opt.Timetable.from_connections(instance, table).instance


def chaser(**changes: Any) -> dict[str, Any]:
    return {"chasers": [changes]}


def holding(delta_v_m_s: float, **more: Any) -> dict[str, Any]:
    return chaser(tank=Tank(delta_v_m_s=delta_v_m_s), **more)


def by_mass(propellant_kg: float, initial_kg: float | None = None, **more: Any) -> dict[str, Any]:
    tank = TankByMass(
        dry_mass_kg=100.0,
        propellant_kg=propellant_kg,
        isp_s=HALVING,
        initial_propellant_kg=initial_kg,
    )
    return chaser(tank=tank, **more)


def of_targets(**changes: Any) -> dict[str, Any]:
    return dict.fromkeys(NAMES[1:], changes)


class Case(NamedTuple):
    """A field, its most prizes and their least cost, and why."""

    changes: dict[str, Any]
    prizes: float
    cost: float
    why: str


FIRST_ONLY = {"prize": 1.0, "prize_until": [(150.0, 5.0)]}
BY_TIME = {"objective": {"cost": "duration"}}
KITS = of_targets(removal="kit")
HEAVY = {"kit_mass_kg": 50.0}
EXPENSE = {"objective": {"cost": "expense"}}
PRICED = {"expense": Expense(fixed=5.0, per_kg=1.0)}
ANYWHERE = {"start": "anywhere"}
SLOWLY = [("depot", "A", 0.0, 100.0, 30.0), ("depot", "A", 100.0, 200.0, 10.0)]

CASES = {
    "tank": Case({}, 3, 30, "A, B, C: three legs of 10 are all that 30 m/s allow"),
    "tank short": Case(
        holding(29.0), 3, 40, "two legs, and back for it on one tank: A, depot, B, C; a third not"
    ),
    "tank alone": Case(holding(19.0), 1, 10, "after A, 9 m/s do not lead anywhere"),
    "tank empty": Case(holding(9.0), 0, 0, "nothing is in reach, and a chaser may stay"),
    "tank begun": Case(
        chaser(tank=Tank(delta_v_m_s=20.0, initial_delta_v_m_s=10.0), **ANYWHERE),
        3,
        30,
        "launched to A, with enough for the depot only; then B, C",
    ),
    "connections wait": Case(
        {"rows": SLOWLY, **holding(20.0)}, 1, 10, "now 30 m/s are too much, in 100 s 10 are not"
    ),
    "connections hurry": Case(
        {"rows": SLOWLY, "mission": {"duration_s": 150.0}}, 1, 30, "the cheaper one is too late"
    ),
    "duration": Case({"mission": {"duration_s": 299.0}}, 2, 20, "C would be reached at 300 s"),
    "service": Case(
        {"mission": {"service_s": 60.0, "duration_s": 560.0}},
        3,
        30,
        "arrivals at 100, 300 and 500 s, as each stay ends just too late for a departure",
    ),
    "service too long": Case(
        {"mission": {"service_s": 60.0, "duration_s": 559.0}}, 2, 20, "the third ends at 560 s"
    ),
    "deadlines": Case(
        {"A": {"window_s": (0.0, 100.0)}, "B": {"window_s": (0.0, 100.0)}},
        2,
        20,
        "only one of A and B is the first",
    ),
    "deadline of a stay": Case(
        {"A": {"window_s": (0.0, 130.0)}, "mission": {"service_s": 60.0}},
        2,
        20,
        "a service of A from 100 to 160 s does not end in the window",
    ),
    "opening": Case(
        {"A": {"window_s": (450.0, None)}, **BY_TIME}, 3, 450, "A is last, and waits to be opened"
    ),
    "required": Case(
        {"A": {"prize": 5}, "B": {"prize": 5}, "C": {"required": True}}
        | {"mission": {"duration_s": 200.0}},
        6,
        20,
        "of the two that there is time for one is C",
    ),
    "required in vain": Case(
        {"C": {"required": True, "window_s": (0.0, 50.0)}}, -math.inf, math.inf, "C is out of reach"
    ),
    "end": Case(
        chaser(end=AtStation(station="depot")),
        3,
        50,
        "30 m/s last for two and the way back: A, depot, B, C, depot",
    ),
    "end in time": Case(
        {**chaser(end=AtStation(station="depot")), "mission": {"duration_s": 499.0}},
        2,
        30,
        "five legs take 500 s; A, B, depot take 300",
    ),
    "most targets": Case(chaser(max_targets=2), 2, 20, "A, B"),
    "visits between refuellings": Case(
        chaser(max_visits_between_refuels=2), 3, 40, "A, B, depot, C, or A, depot, B, C"
    ),
    "one visit between refuellings": Case(
        {**holding(99.0, max_visits_between_refuels=1), "mission": {"duration_s": 450.0}},
        2,
        30,
        "A, depot, B; C comes at 500 s, behind another refuelling",
    ),
    "available": Case(
        {**chaser(available_s=(150.0, 450.0)), **BY_TIME}, 2, 400, "departures at 200 and 300 s"
    ),
    "launch": Case(
        {**chaser(tank=Tank(delta_v_m_s=20.0), **ANYWHERE), "mission": {"duration_s": 200.0}},
        3,
        20,
        "A for nothing at 0 s, then B, C",
    ),
    "launches in order": Case(
        {
            "chasers": [ANYWHERE, ANYWHERE],
            "mission": {"duration_s": 50.0, "launch_separation_s": 60.0},
        },
        1,
        0,
        "the second one would be launched at 60 s",
    ),
    "launches at once": Case(
        {"chasers": [ANYWHERE, ANYWHERE], "mission": {"duration_s": 50.0}}, 2, 0, "A; B"
    ),
    "price of time": Case(
        {"objective": {"time_m_s_per_day": 86400.0}}, 3, 330, "30 m/s, and 300 s at 1 m/s each"
    ),
    "time at a launch": Case(
        {
            "objective": {"time_m_s_per_day": 86400.0},
            **chaser(available_s=(100.0, None), **ANYWHERE),
        },
        3,
        220,
        "20 m/s, and 200 s since the launch at 100 s",
    ),
    "prizes that fall": Case(
        of_targets(**FIRST_ONLY), 7, 30, "5 for the one that ends by 150 s, and 1 for the others"
    ),
    "prizes that fall in steps": Case(
        {"A": {"prize": 1.0, "prize_until": [(100.0, 9.0), (200.0, 6.0)]}, "B": FIRST_ONLY},
        12,
        30,
        "B first and A second are worth 5 + 6, A first and B second 9 + 1; and C 1",
    ),
    "mass": Case(by_mass(700.0), 3, 30, "800 kg are halved three times"),
    "mass short": Case(by_mass(690.0), 3, 40, "not three times to 100 kg; A, depot, B, C"),
    "mass begun": Case(
        by_mass(300.0, 100.0, **ANYWHERE), 3, 30, "launched to A, 200 kg reach the depot; B, C"
    ),
    "kits": Case(
        {**KITS, **by_mass(1250.0, **HEAVY)},
        3,
        30,
        "back from the end: 100 + 50, 300 + 50, 700 + 50, and 1,500 kg at the start",
    ),
    "kits heavy": Case(
        {**KITS, **by_mass(1240.0, **HEAVY), "mission": {"duration_s": 300.0}},
        2,
        20,
        "1,250 kg beside 250 are needed for three; 500 beside 200 for two",
    ),
    "kits few": Case({**KITS, **by_mass(1250.0, kits=2, **HEAVY)}, 2, 20, "A, B"),
    "expense": Case(
        {**EXPENSE, **by_mass(1250.0, **PRICED)},
        3,
        305,
        "5, and 400 kg less 100 for A and depot, where the next tank costs nothing; B, C",
    ),
    "expense of kits": Case(
        {**EXPENSE, **KITS, **by_mass(1250.0, **HEAVY, **PRICED)},
        3,
        805,
        "A, depot, B, C: 200 kg at the depot, 400 + 50 at A, 900 at launch; by A, B, depot 1,500",
    ),
    "several chasers": Case(
        {"chasers": [{}, {}], "mission": {"duration_s": 200.0}}, 3, 30, "A, B; C"
    ),
    "several chasers in time": Case(
        {"chasers": [{}, {}], **BY_TIME}, 3, 200, "A, B; C: the last stay of all ends at 200 s"
    ),
    "refuellings": Case(
        {**holding(20.0, end=AtStation(station="depot")), "depot": {"max_refuellings": 2}},
        2,
        40,
        "A, depot, B, depot; a third would be needed for C",
    ),
    "refuellings of several": Case(
        {
            "chasers": [{"tank": Tank(delta_v_m_s=20.0)}] * 2,
            "depot": {"max_refuellings": 0},
            "mission": {"duration_s": 200.0},
        },
        3,
        30,
        "A, B; C: none needs to refuel",
    ),
    "refuellings shared": Case(
        {
            "chasers": [{"tank": Tank(delta_v_m_s=20.0), "end": AtStation(station="depot")}] * 2,
            "depot": {"max_refuellings": 1},
        },
        1,
        20,
        "each target costs the refuelling at its end, and there is one for both",
    ),
    "propellant": Case(
        {**by_mass(300.0), "depot": {"max_propellant_kg": 300.0}},
        3,
        40,
        "A, depot: 400 kg have become 100, and 300 fill the tank; B, C",
    ),
    "propellant short": Case(
        {**by_mass(300.0), "depot": {"max_propellant_kg": 299.0}}, 2, 20, "A, B without refuelling"
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_planned_by_hand_is_found(name: str) -> None:
    """Enumeration finds the prizes and the cost that the words beside each case derive."""
    case = CASES[name]
    found = brute_force_campaign(Problem(field(**case.changes)))
    assert found == pytest.approx((case.prizes, case.cost)), case.why


@pytest.mark.parametrize(
    ("number", "changes", "held", "expected"),
    [
        # There is no need of a stay of 100 s at the depot; with it B is reached at 400 s.
        (0, {"stay_s": 100.0}, by_mass(700.0), 300.0),
        (0, {"stay_s": 100.0}, by_mass(690.0), 500.0),
        # A last, at 300 s with 400 kg of 3,200: with 200 in tow they are 600, halved 300, less 200
        # just the dry mass. With less A comes earlier, and the departure after it 50 s later.
        (1, {"tow": Tow(50.0, 10.0, 200.0)}, by_mass(3100.0), 350.0),
        (1, {"tow": Tow(50.0, 10.0, 200.0)}, by_mass(3000.0), 400.0),
    ],
)
def test_stays_and_tows_take_what_their_places_say(
    number: int, changes: dict[str, Any], held: dict[str, Any], expected: float
) -> None:
    """A tank is filled for as long as a station takes, and a tow has its time and propellant."""
    assert with_place(field(**held, **BY_TIME), number, **changes) == pytest.approx((3.0, expected))


def test_a_refuelling_is_earned() -> None:
    """With B as a station and no connection to A but from it, a tank for one leg leads to C."""
    rows = [row for row in ROWS if row[1] != "A" or row[0] == "B"]
    assert with_place(field(rows, **holding(10.0)), 2, kind="station") == (1.0, 10.0)


def with_place(instance: Instance, number: int, **changes: Any) -> tuple[float, float]:
    """Prizes and cost of the best plan once a place is another one."""
    (mission,) = Problem(instance).missions
    world = world_of(mission)
    places = list(world.places)
    places[number] = replace(places[number], **changes)
    ways = ways_of(replace(world, places=tuple(places)), legs_of(mission))
    return best_of(instance, ways)[:2]
