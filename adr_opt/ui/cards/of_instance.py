"""Cards of instances, missions, problems, timetables and connections."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ...common.card import Card, CardTable, days, days_words
from ...common.wording import counted
from ...problem.chasers import AtStation, Chaser, TankByMass

if TYPE_CHECKING:
    from ...legs.connections import AllConnections, Connections
    from ...legs.matrices import Matrices
    from ...legs.timetable import Timetable
    from ...mission.mission import Mission
    from ...mission.problem import Problem
    from ...problem.given import Given
    from ...problem.instance import Instance


def of_connections(found: Connections) -> Card:
    """The card of a pair's connections; on a page, with all of them."""
    count = int(found.departure.size)
    facts = [str(count) if count else "none"]
    if count:
        facts += [
            f"day {days(found.departure[0])} to {days(found.arrival.max())}",
            f"{found.delta_v.min():,.1f} to {found.delta_v.max():,.1f} m/s",
        ]
    columns: dict[str, Callable[[float, float, float, int], str]] = {
        "departure day": lambda leaves, lands, cost, turns: days(leaves),
        "arrival day": lambda leaves, lands, cost, turns: days(lands),
        "ΔV m/s": lambda leaves, lands, cost, turns: f"{cost:,.1f}",
        "revolutions": lambda leaves, lands, cost, turns: f"{turns}",
    }
    items = zip(found.departure, found.arrival, found.delta_v, found.revolutions, strict=True)
    table = CardTable.of(items, columns, texts=0)
    return Card("Connections", "", tuple(facts), (), (table,))


def of_all_connections(found: AllConnections) -> Card:
    """The card of all pairs' connections."""
    pairs = len(set(zip(found.origin.tolist(), found.destination.tolist(), strict=True)))
    facts = [f"{len(found)}" if len(found) else "none", f"of {pairs} pairs"]
    if len(found):
        facts.append(f"{found.delta_v.min():,.1f} to {found.delta_v.max():,.1f} m/s")
    return Card("AllConnections", "", tuple(facts), (), ())


def of_given(given: Given) -> Card:
    """The card of given connections."""
    facts = (
        counted(int(given.departure.size), "connection"),
        counted(len(given.names), "body", "bodies"),
        f"sha256 {given.sha256[:12]}…",
    )
    return Card("Given", "", facts)


def of_timetable(timetable: Timetable) -> Card:
    """The card of a timetable."""
    bodies = len(timetable.names)
    pairs = "all pairs" if timetable.is_whole else f"the nearest {timetable.built} pairs"
    holds = [pairs, f"{timetable.entries:,} entries"]
    if timetable.is_on_demand:
        holds = ["rows on demand"]
    facts = (f"{bodies} bodies", *holds, f"{timetable.time_value_m_s_per_h:g} m/s per hour")
    return Card("Timetable", f"of {timetable.instance.name!r}", facts)


def of_matrices(matrices: Matrices) -> Card:
    """The card of matrices; on a page, with ΔV at the first departure as far as it fits."""
    facts = [
        counted(len(matrices.departures), "departure"),
        counted(len(matrices.names), "body", "bodies"),
        matrices.choice,
    ]
    reached = np.isfinite(matrices.delta_v) & (matrices.duration > 0.0)
    details = []
    if reached.any():
        values = matrices.delta_v[reached]
        details.append(("ΔV", f"{values.min():,.1f} to {values.max():,.1f} m/s"))
        hours = matrices.duration[reached] / 3600.0
        details.append(("from ready to arrival", f"{hours.min():,.2f} to {hours.max():,.2f} h"))
    if not len(matrices.departures):
        return Card("Matrices", "", tuple(facts), tuple(details))
    first, most = matrices.departures[0], 12
    names, costs = matrices.names[:most], matrices.delta_v[0, :most, :most]
    rows = [
        (name, *(f"{value:,.0f}" for value in row)) for name, row in zip(names, costs, strict=True)
    ]
    details.append(("below", f"ΔV [m/s] when ready on day {days(float(first))}"))
    return Card("Matrices", "", tuple(facts), tuple(details), (CardTable(("from", *names), rows),))


COSTS = {"delta-v": "ΔV", "duration": "duration", "expense": "expense"}


def facts_of(instance: Instance) -> tuple[str, ...]:
    """Content of an instance, briefly."""
    facts = [
        counted(len(instance.targets), "target"),
        counted(len(instance.stations), "station"),
        counted(len(instance.chasers), "chaser"),
        days_words(instance.mission.duration_s),
    ]
    tanks = sorted({round(chaser.tank.delta_v_m_s, 1) for chaser in instance.chasers})
    facts.append(f"{'–'.join(f'{tank:g}' for tank in {tanks[0]: 0, tanks[-1]: 0})} m/s")
    facts.append(instance.dynamics)
    if instance.transfer.given is not None:
        timed = instance.transfer.given.functions is not None
        facts.append("given functions of time" if timed else "given connections")
    if instance.keep_out_zones:
        facts.append(counted(len(instance.keep_out_zones), "keep-out zone"))
    return tuple(facts)


def of_instance(instance: Instance) -> Card:
    """The card of an instance."""
    targets = instance.targets
    prizes = sum(target.greatest_prize for target in targets)
    required = [target.name for target in targets if target.required]
    windows = sum(instance.is_limited(target) for target in targets)
    details = [
        ("epoch", f"{instance.epoch:%Y-%m-%d %H:%M:%S} UTC"),
        ("sum of prizes", f"{prizes:g}"),
        ("required", ", ".join(required[:8]) + (" …" if len(required) > 8 else "") or "none"),
        ("least, among equal plans", _cost_of(instance)),
        ("stations", ", ".join(instance.station_names) or "none: nobody refuels"),
    ]
    if instance.frame is not None:
        details.insert(1, ("frame", str(instance.frame)))
    if windows:
        details.append(("targets with a window", f"{windows}"))
    falling = sum(target.prize_until is not None for target in targets)
    if falling:
        details.append(("targets whose prize falls", f"{falling}"))
    columns: dict[str, Callable[[Chaser], str]] = {
        "chaser": lambda chaser: chaser.name,
        "start": _start,
        "end": lambda each: each.end.station if isinstance(each.end, AtStation) else "anywhere",
        "tank m/s": _tank,
        "there from day": lambda chaser: days(chaser.available_s[0]),
        "kits": lambda chaser: "–" if chaser.kits is None else f"{chaser.kits}",
    }
    table = CardTable.of(((chaser,) for chaser in instance.chasers), columns, texts=3)
    return Card("Instance", repr(instance.name), facts_of(instance), tuple(details), (table,))


def _cost_of(instance: Instance) -> str:
    """The deciding cost, with a stated price of time."""
    price = instance.objective.time_m_s_per_day
    stated = "" if price is None else f", and {price:g} m/s a day"
    return f"{COSTS[instance.objective.cost]}{stated}"


def _start(chaser: Chaser) -> str:
    if chaser.is_launched:
        return "anywhere"
    if chaser.launch is not None:
        return f"launched to {chaser.launch.altitude_m / 1e3:g} km"
    return chaser.start.station if isinstance(chaser.start, AtStation) else "in an orbit"


def _tank(chaser: Chaser) -> str:
    by_mass = " (by mass)" if isinstance(chaser.tank, TankByMass) else ""
    return f"{chaser.tank.delta_v_m_s:,.1f}{by_mass}"


def of_problem(problem: Mission | Problem) -> Card:
    """The card of a mission, or of all chasers' missions."""
    instance = problem.instance
    facts = [
        *facts_of(instance),
        "with its timetable" if problem.has_timetable else "timetable not built yet",
    ]
    if problem.margin:
        facts.append(f"{100.0 * problem.margin:g} % of each tank kept back")
    chaser = getattr(problem, "chaser", None)
    whose = f" for {chaser.name!r}" if chaser is not None and len(instance.chasers) > 1 else ""
    return Card(type(problem).__name__, f"over {instance.name!r}{whose}", tuple(facts))


of_mission = of_problem
"""The card of a mission, alike."""
