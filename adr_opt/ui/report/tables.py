"""Tables of the page: legs, and targets left out."""

from __future__ import annotations

from collections.abc import Iterable

from ...common.constants import DAY_S, EARTH_RADIUS_M, SLACK_S
from ...plan.cargo import carries
from ...plan.expense import carried_kg, expense_of
from ...plan.palette import REASONS, chaser_colours
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import by_tank, owners, routes_of
from ...problem.bodies import Target
from ...problem.chasers import AtStation, Chaser
from ...problem.instance import Instance
from ..plot.traffic import also_there, stays
from .text import LONG_S, NOTHING, clock, escape, fixed, number, span

LONG_ROUTE = 30

Cell = tuple[str, str]
"""A class, "n" for numbers, and HTML."""

REASON_TITLES = {
    "no-transfer": "no transfer",
    "duration": "duration",
    "delta-v": "ΔV",
    "capacity": "capacity",
    "not-worth-it": "not worth it",
    "not-considered": "not considered",
}


def table(caption: str, headings: Iterable[tuple[str, str]], rows: Iterable[str]) -> str:
    """A table that scrolls inside its own box.

    Parameters
    ----------
    caption : str
        For readers who do not see the headline above it.
    headings : iterable of (title, class)
        Class "n" is a column of numbers.
    rows : iterable of str
        HTML of the rows.
    """
    head = "".join(
        f'<th scope="col"{" class=n" if kind == "n" else ""}>{escape(title)}</th>'
        for title, kind in headings
    )
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}"><table>'
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def row(cells: Iterable[Cell], about: str = "") -> str:
    """A row of cells; ``about`` holds attributes of the row."""
    inside = "".join(f"<td{f' class={kind}' if kind else ''}>{text}</td>" for kind, text in cells)
    return f"<tr{about and f' {about}'}>{inside}</tr>"


def route_cell(origin: str, destination: str) -> Cell:
    """Origin and destination of a leg as a cell, which may wrap if the names are long."""
    kind = "name" if len(origin) + len(destination) > LONG_ROUTE else ""
    return kind, f"{escape(origin)} → <b>{escape(destination)}</b>"


def legs(instance: Instance, plan: Plan, refined: RefinedPlan | None = None) -> str:
    """One row per leg, with refuellings marked; a click on a row shows that leg in the charts.

    With the plan refined, what legs take then stands beside what they were planned with.
    """
    flown = {} if refined is None else {leg.leg: leg.flown_delta_v_m_s for leg in refined.legs}
    whose = owners(instance, plan)
    targets = {target.name: target for target in instance.targets}
    drifts = instance.nodes_drift
    lengths = [
        (leg.departure_s - leg.ready_s, leg.arrival_s - leg.departure_s) for leg in plan.legs
    ]
    weighed = any(leg.mass_kg is not None for leg in plan.legs)
    towed = any(leg.tow is not None for leg in plan.legs)
    in_days = any(max(pair) >= LONG_S for pair in lengths)

    def told(duration_s: float) -> str:
        return fixed(duration_s / DAY_S, 2) if in_days else span(duration_s)

    rows = []
    for at, leg in enumerate(plan.legs, start=1):
        refuels = leg.destination in instance.station_names
        cells = (
            ("n", f'<button type="button" class="leg">{at}</button>'),
            *([("", escape(whose[at]))] if whose else []),
            route_cell(leg.origin, leg.destination),
            ("n", clock(leg.ready_s)),
            *([("", leg.kind)] if drifts else []),
            ("n", told(leg.departure_s - leg.ready_s)),
            ("n", clock(leg.departure_s)),
            ("n", str(leg.phasing_revolutions) if leg.traits.counts_laps else NOTHING),
            ("n", fixed(leg.delta_v_m_s, 1)),
            *([("n", _burned(leg))] if drifts else []),
            *([("n", fixed(flown[at], 1) if at in flown else NOTHING)] if refined else []),
            ("n", told(leg.arrival_s - leg.departure_s)),
            ("n", clock(leg.arrival_s)),
            ("n", clock(leg.end_s)),
            *([("n", _towing(leg))] if towed else []),
            ("n", fixed(leg.delta_v_left_m_s, 1)),
            *([("n", _kg(leg.mass_kg))] if weighed else []),
            ("n", "refuels" if refuels else _prize(targets.get(leg.destination), leg)),
        )
        rows.append(row(cells, f'data-leg="{at}"{" class=refuels" if refuels else ""}'))
    unit = "d" if in_days else "h"
    headings = (
        ("leg", "n"),
        *([("chaser", "")] if whose else []),
        ("from → to", ""),
        ("ready", "n"),
        *([("kind", "")] if drifts else []),
        (f"wait {unit}", "n"),
        ("departure", "n"),
        ("laps", "n"),
        ("ΔV m/s", "n"),
        *([("burns m/s", "n")] if drifts else []),
        *([("refined m/s", "n")] if refined else []),
        (f"flight {unit}", "n"),
        ("arrival", "n"),
        ("end", "n"),
        *([("tow until, m/s", "n")] if towed else []),
        ("ΔV left m/s", "n"),
        *([("mass kg", "n")] if weighed else []),
        ("prize", "n"),
    )
    return table("Legs", headings, rows)


def _towing(leg: Leg) -> str:
    """Time and ΔV of a leg's tow."""
    if leg.tow is None:
        return NOTHING
    return f"{clock(leg.tow.end_s)}, {fixed(leg.tow.delta_v_m_s, 1)}"


def chasers(instance: Instance, plan: Plan, refined: RefinedPlan | None = None) -> str:
    """One row per chaser: its visits, tanks and times."""
    burned: dict[str | None, float] = {}
    for leg in () if refined is None else refined.legs:
        burned[leg.chaser] = burned.get(leg.chaser, 0.0) + leg.flown_delta_v_m_s + leg.removal_m_s
    colours, rows = chaser_colours(instance), []
    times = zip(instance.chasers, instance.available_s, strict=True)
    since = {chaser.name: begin for chaser, (begin, _) in times}
    for flown in routes_of(instance, plan):
        name, tank = flown.chaser.name, flown.aboard(instance)[0].left_m_s
        refuellings = flown.refuellings(instance)
        used = [
            fixed(sum(leg.spent_m_s for leg in of_tank), 1)
            for of_tank in by_tank([leg for _, leg in flown.legs], instance.station_names)
        ]
        cells = (
            ("", f'<i class="dot" style="background:{colours[name]}"></i><b>{escape(name)}</b>'),
            ("", escape(_where(flown.chaser, since[flown.chaser.name]))),
            ("n", str(len(flown.legs) - refuellings)),
            *([("n", str(refuellings))] if instance.stations else []),
            ("n", fixed(flown.delta_v_m_s, 1)),
            *([("n", fixed(burned.get(name, 0.0), 1))] if refined else []),
            ("n", number(tank, 1)),
            ("n", " + ".join(used) or NOTHING),
            ("n", clock(flown.legs[0][1].departure_s) if flown.legs else NOTHING),
            ("n", clock(flown.end_s) if flown.legs else NOTHING),
        )
        rows.append(row(cells))
    headings = (
        ("chaser", ""),
        ("starts", ""),
        ("targets", "n"),
        *([("refuellings", "n")] if instance.stations else []),
        ("ΔV m/s", "n"),
        *([("refined m/s", "n")] if refined else []),
        ("tank m/s", "n"),
        ("tank by tank m/s", "n"),
        ("leaves", "n"),
        ("done", "n"),
    )
    return table("Chasers", headings, rows)


def loads(instance: Instance, plan: Plan) -> str:
    """One row per chaser: masses, kits, propellant and expense; empty if none matter."""
    by_expense = instance.objective.cost == "expense" or any(
        chaser.expense is not None for chaser in instance.chasers
    )
    if not (carries(instance) or by_expense):
        return ""
    rows = []
    for flown in routes_of(instance, plan):
        load, flies = flown.carried(instance), bool(flown.legs)
        numbers: tuple[str, ...] = (
            _kg(load.mass_kg),
            str(load.kits),
            _kg(load.propellant_kg),
            _kg(load.used_kg),
            _kg(load.left_kg),
            _kg(load.end_mass_kg),
        )
        if by_expense:
            least = _kg(carried_kg(instance, flown.chaser, flown.spent))
            expense = number(expense_of(instance, flown.chaser, flown.spent), 3)
            numbers = (*numbers, least, expense)
        name = f"<b>{escape(flown.chaser.name)}</b>"
        rows.append(row([("", name), *(("n", text if flies else NOTHING) for text in numbers)]))
    headings = (
        ("chaser", ""),
        ("mass at the start kg", "n"),
        ("kits", "n"),
        ("propellant kg", "n"),
        ("used kg", "n"),
        ("left kg", "n"),
        ("mass at the end kg", "n"),
        *([("least aboard kg", "n"), ("expense", "n")] if by_expense else []),
    )
    return table("What chasers carry", headings, rows)


def _burned(leg: Leg) -> str:
    return fixed(leg.burns_delta_v_m_s, 1) if leg.manoeuvres is None else NOTHING


def _kg(mass_kg: float | None) -> str:
    return NOTHING if mass_kg is None else fixed(mass_kg, 1)


def traffic(instance: Instance, plan: Plan) -> str:
    """One row per stay of a chaser at a station, by station and time."""
    every = stays(instance, plan)
    rows = [
        row(
            (
                ("", f"<b>{escape(stay.station)}</b>"),
                ("", escape(stay.chaser)),
                ("n", "starts here" if stay.refuelled_s is None else clock(stay.since_s)),
                ("n", NOTHING if stay.refuelled_s is None else clock(stay.refuelled_s)),
                ("n", clock(stay.until_s)),
                ("", escape(", ".join(also_there(stay, every))) or NOTHING),
            )
        )
        for stay in every
        if stay.leg
    ]
    headings = (
        ("station", ""),
        ("chaser", ""),
        ("docks", "n"),
        ("refuelled", "n"),
        ("leaves", "n"),
        ("also there", ""),
    )
    return table("Station traffic", headings, rows) if rows else "<p>No chaser is at a station.</p>"


def _where(chaser: Chaser, since: float) -> str:
    """Start of a chaser, with its time."""
    place = "its first target" if chaser.is_launched else "an orbit of its own"
    if isinstance(chaser.start, AtStation):
        place = chaser.start_name
    return f"{place}, {clock(since)}" if since > 0.0 else place


def _prize(target: Target | None, leg: Leg) -> str:
    """Prize of the service at the end of a leg; nothing for an unknown destination."""
    return number(0.0 if target is None else target.prize_at(leg.free_s - SLACK_S), 3)


def unvisited(instance: Instance, plan: Plan) -> str:
    """One row per target left out, by reason."""
    bodies = {target.name: target for target in instance.targets}
    order = list(REASONS)
    rows = []
    for entry in sorted(plan.unvisited, key=lambda entry: order.index(entry.reason)):
        target = bodies.get(entry.target)
        orbit, prize = ("", "", ""), "" if target is None else number(target.greatest_prize, 3)
        if target is not None and target.orbit is not None:
            orbit = (
                fixed((target.orbit.semi_major_axis_m - EARTH_RADIUS_M) / 1000.0, 1),
                fixed(target.orbit.inclination_deg, 2),
                fixed(target.orbit.raan_deg, 2),
            )
        words = ("", f"<b>{escape(entry.target)}</b>"), ("", REASON_TITLES[entry.reason])
        rows.append(row((*words, *(("n", text) for text in (*orbit, prize)))))
    headings = (
        ("target", ""),
        ("reason", ""),
        ("altitude km", "n"),
        ("inclination °", "n"),
        ("RAAN °", "n"),
        ("prize", "n"),
    )
    return table("Targets not visited", headings, rows)


def reasons(plan: Plan) -> str:
    """Number of targets left out for each reason, with its meaning."""
    found = [entry.reason for entry in plan.unvisited]
    items = [
        f"<div><dt><b>{found.count(reason)}</b> {REASON_TITLES[reason]}</dt>"
        f"<dd>{escape(meaning)}</dd></div>"
        for reason, meaning in REASONS.items()
        if reason in found
    ]
    return f'<dl class="reasons">{"".join(items)}</dl>'
