"""A plan as text: one line per leg, and a summary."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from ...common.constants import DAY_S
from ...common.wording import counted, proof_words
from ...plan.cargo import carries
from ...plan.expense import carried_kg, expense_of
from ...plan.routes import Flown, by_tank, routes_of, several
from .tables import Row, leg_table

if TYPE_CHECKING:
    from rich.table import Table

    from ...plan.plan import Leg, Plan
    from ...problem.instance import Instance

LONG_S = 2.0 * DAY_S
"""Length beyond which spans are given in days."""


def clock(time_s: float) -> str:
    """A time since the epoch as day, hours and minutes; the first day is day 0."""
    minutes = round(time_s / 60.0)
    return f"{minutes // 1440}d {minutes // 60 % 24:02d}:{minutes % 60:02d}"


def span(duration_s: float) -> str:
    """A duration as hours and minutes, or in days if it is long."""
    if duration_s >= LONG_S:
        return f"{duration_s / DAY_S:.1f} d"
    minutes = round(duration_s / 60.0)
    return f"{minutes // 60}:{minutes % 60:02d}"


def timelines(instance: Instance, plan: Plan, width: int | None = None) -> list[Table]:
    """A table of at most ``width`` columns for each flying chaser's legs, with names shortened."""
    title = f"{instance.name}: {plan.method}, {proof_words(plan.status, plan.cost_status)}"
    if not several(instance):
        return [timeline(instance, enumerate(plan.legs, start=1), width, title)]
    return [
        timeline(instance, flown.legs, width, f"{title}: {flown.chaser.name}")
        for flown in routes_of(instance, plan)
        if flown.legs
    ]


def timeline(
    instance: Instance, legs: Iterable[tuple[int, Leg]], width: int | None, title: str
) -> Table:
    """A table of at most ``width`` columns for a chaser's numbered legs."""
    rows = []
    for number, leg in legs:
        refuels = leg.destination in instance.station_names
        texts = (
            clock(leg.departure_s),
            span(leg.departure_s - leg.ready_s),
            f"{leg.delta_v_m_s:.1f}",
            f"{leg.delta_v_left_m_s:.1f}",
            str(leg.phasing_revolutions) if leg.traits.counts_laps else leg.kind,
            clock(leg.arrival_s),
        )
        destination = f"{leg.destination} (refuels)" if refuels else leg.destination
        if leg.removal_burns:
            destination = f"{leg.destination} (tows, {leg.removal_m_s:.1f} m/s)"
        rows.append(Row(number, leg.origin, destination, texts, bold=refuels))
    headings = ("departs", "wait", "ΔV\nm/s", "left\nm/s", "k", "arrives")
    return leg_table(headings, rows, width, title)


def by_chaser(instance: Instance, plan: Plan) -> Iterator[str]:
    """Totals and cargo of each chaser, and the reasons for targets left out.

    Nothing of one chaser alone that carries nothing and takes nothing.
    """
    by_expense = instance.objective.cost == "expense"
    if not (several(instance) or carries(instance) or by_expense):
        return
    for flown in routes_of(instance, plan):
        yield f"{flown.chaser.name}: {_comes_to(instance, flown)}"
        load = _carries(instance, flown) if flown.legs else None
        if load is not None:
            yield f"{flown.chaser.name}: {load}"
        if flown.legs and (by_expense or flown.chaser.expense is not None):
            yield f"{flown.chaser.name}: {_takes(instance, flown)}"
    yield from left_out(plan)


def _comes_to(instance: Instance, flown: Flown) -> str:
    """Targets of a chaser, its time, and each of its tanks."""
    if not flown.legs:
        return "does not fly"
    visits = len(flown.legs) - flown.refuellings(instance)
    worths = flown.tank_worths(instance)
    parts = [f"visits {visits}", f"ΔV {flown.delta_v_m_s:.1f} m/s", f"done {clock(flown.end_s)}"]
    legs = by_tank([leg for _, leg in flown.legs], instance.station_names)
    for number, (of_tank, tank) in enumerate(zip(legs, worths, strict=False), start=1):
        used = sum(leg.spent_m_s for leg in of_tank)
        days = (of_tank[-1].done_s - of_tank[0].ready_s) / DAY_S
        parts.append(f"tank {number} {used:.1f} of {tank:.6g} m/s in {days:.2f} d")
    return ", ".join(parts)


def _carries(instance: Instance, flown: Flown) -> str | None:
    """Cargo of a chaser at the start and at the end; None if nothing is tracked."""
    load, each = flown.carried(instance), flown.chaser.kit_mass_kg
    kits = counted(load.kits, "kit") + (f" of {each:g} kg" if each > 0.0 else "")
    if load.mass_kg is None or load.propellant_kg is None or load.end_mass_kg is None:
        return f"carries {kits}" if load.kits else None
    used = load.used_kg or 0.0
    starts = "at launch" if flown.chaser.awaits_launch else "at the start"
    held = f"{load.propellant_kg:g} kg of propellant" + (f" and {kits}" if load.kits else "")
    return (
        f"{starts} {load.mass_kg:.1f} kg with {held}, uses {used:.1f} kg, "
        f"ends with {load.end_mass_kg:.1f} kg and {load.left_kg:.1f} kg of propellant"
    )


def _takes(instance: Instance, flown: Flown) -> str:
    """Expense of a chaser, and its basis."""
    expense = f"expense {expense_of(instance, flown.chaser, flown.spent):,.6g}"
    carried = carried_kg(instance, flown.chaser, flown.spent)
    if carried is None:
        return expense
    return f"{expense} with {carried:.1f} kg aboard, the least with which its route can be flown"


def left_out(plan: Plan) -> Iterator[str]:
    """Targets left out of a plan, by reason."""
    from ...plan.palette import REASONS

    for reason, meaning in REASONS.items():
        names = [entry.target for entry in plan.unvisited if entry.reason == reason]
        if names:
            yield (
                f"left out, {reason} ({meaning}): {counted(len(names), 'target')}: "
                f"{', '.join(names)}"
            )


def summary(instance: Instance, plan: Plan) -> str:
    """Totals of a plan on one line, with the bounds and gaps of prize and cost if there are any."""
    refuellings = sum(name in instance.station_names for name in plan.destinations)
    used = max(flown.end_s for flown in routes_of(instance, plan))
    proven: tuple[str, ...] = ()
    if plan.upper_bound is not None and plan.gap is not None:
        proven = (f"bound {plan.upper_bound:.6g}", f"gap {plan.gap:.1%}")
    if plan.cost_bound is not None and plan.cost_gap is not None:
        proven += (f"cost bound {plan.cost_bound:,.6g}", f"cost gap {plan.cost_gap:.1%}")
    elif plan.status == "optimal":
        proven += ("cost unproven",)
    crew = (counted(len(instance.chasers), "chaser"),) if several(instance) else ()
    parts = (
        *crew,
        f"visits {len(plan.legs) - refuellings} of {len(instance.targets)}",
        f"prize {plan.objective:g}",
        f"ΔV {plan.delta_v_m_s:.1f} m/s",
        *((f"expense {plan.cost:,.6g}",) if instance.objective.cost == "expense" else ()),
        *((f"{plan.cost:.1f} m/s with time",) if instance.objective.time_m_s_per_day else ()),
        f"refuellings {refuellings}",
        f"duration {used / DAY_S:.2f} of {instance.mission.duration_s / DAY_S:.2f} d",
        *proven,
        f"runtime {plan.runtime_s:.2f} s",
    )
    return ", ".join(parts)
