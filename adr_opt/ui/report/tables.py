"""Tables of the page: legs, and targets left out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from ...common.constants import DAY_S, EARTH_RADIUS_M, SLACK_S
from ...plan.cargo import carries
from ...plan.expense import carried_kg, expense_of
from ...plan.lifetimes import MOST_YEARS, lifetimes_years
from ...plan.palette import REASON_TITLES, REASONS, chaser_colours
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import Flown, by_tank, owners, routes_of
from ...problem.bodies import Target
from ...problem.chasers import AtStation, Chaser
from ...problem.drives import drive_of
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ..plot.traffic import also_there, stays
from .text import LONG_S, NOTHING, clock, escape, fixed, number, span

LONG_ROUTE = 30

Cell = tuple[str, str]
"""A class, "n" for numbers, and HTML."""

Column = tuple[str, str, Callable[..., str | Cell]]
"""Heading, class, and a function that makes the HTML of a cell from the data of a row."""


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


def table_of(
    caption: str,
    columns: Iterable[Column | bool],
    items: Iterable[tuple[Any, ...]],
    about: Callable[..., str] = lambda *item: "",
) -> str:
    """A table by its columns.

    Parameters
    ----------
    caption : str
        As of :func:`table`.
    columns : iterable of Column
        Or False for a column that is left out.
    items : iterable of tuple
        For each row the arguments of what its columns say.
    about : callable
        Attributes of a row.
    """
    shown = [column for column in columns if not isinstance(column, bool)]
    rows = []
    for item in items:
        said = [(kind, tell(*item)) for _, kind, tell in shown]
        cells = [cell if isinstance(cell, tuple) else (kind, cell) for kind, cell in said]
        rows.append(row(cells, about(*item)))
    return table(caption, [(title, kind) for title, kind, _ in shown], rows)


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
    drive = drive_of(instance.chasers[0], instance.targets)
    years = {instance.names[body]: e for body, e in lifetimes_years(instance, drive).items()}
    in_days = any(max(pair) >= LONG_S for pair in lengths)

    def _told(duration_s: float) -> str:
        return fixed(duration_s / DAY_S, 2) if in_days else span(duration_s)

    def _refuels(leg: Leg) -> bool:
        return leg.destination in instance.station_names

    def _collected(leg: Leg) -> str:
        return "refuels" if _refuels(leg) else _prize(targets.get(leg.destination), leg)

    unit = "d" if in_days else "h"
    columns: list[Column | bool] = [
        ("leg", "n", lambda at, leg: f'<button type="button" class="leg">{at}</button>'),
        bool(whose) and ("chaser", "", lambda at, leg: escape(whose[at])),
        ("from → to", "", lambda at, leg: route_cell(leg.origin, leg.destination)),
        ("ready", "n", lambda at, leg: clock(leg.ready_s)),
        drifts and ("kind", "", lambda at, leg: leg.kind),
        (f"wait {unit}", "n", lambda at, leg: _told(leg.departure_s - leg.ready_s)),
        ("departure", "n", lambda at, leg: clock(leg.departure_s)),
        ("laps", "n", lambda at, leg: _laps(leg)),
        ("ΔV m/s", "n", lambda at, leg: fixed(leg.delta_v_m_s, 1)),
        drifts and ("burns m/s", "n", lambda at, leg: _burned(leg)),
        refined is not None
        and ("refined m/s", "n", lambda at, leg: fixed(flown[at], 1) if at in flown else NOTHING),
        (f"flight {unit}", "n", lambda at, leg: _told(leg.arrival_s - leg.departure_s)),
        ("arrival", "n", lambda at, leg: clock(leg.arrival_s)),
        ("end", "n", lambda at, leg: clock(leg.end_s)),
        towed and ("tow until, m/s", "n", lambda at, leg: _towing(leg)),
        bool(years) and ("then in orbit, years", "n", lambda at, leg: _years(years, leg)),
        ("ΔV left m/s", "n", lambda at, leg: fixed(leg.delta_v_left_m_s, 1)),
        weighed and ("mass kg", "n", lambda at, leg: _kg(leg.mass_kg)),
        ("prize", "n", lambda at, leg: _collected(leg)),
    ]
    return table_of(
        "Legs",
        columns,
        enumerate(plan.legs, start=1),
        lambda at, leg: f'data-leg="{at}"{" class=refuels" if _refuels(leg) else ""}',
    )


def _laps(leg: Leg) -> str:
    return str(leg.phasing_revolutions) if leg.traits.counts_laps else NOTHING


def _towing(leg: Leg) -> str:
    """Time and ΔV of a leg's tow."""
    if leg.tow is None:
        return NOTHING
    return f"{clock(leg.tow.end_s)}, {fixed(leg.tow.delta_v_m_s, 1)}"


def _years(years: Mapping[str, float], leg: Leg) -> str:
    """Lifetime of an object after its release."""
    if leg.destination not in years:
        return NOTHING
    lasts = years[leg.destination]
    return f"over {MOST_YEARS:g}" if lasts >= MOST_YEARS else fixed(lasts, 1)


def chasers(instance: Instance, plan: Plan, refined: RefinedPlan | None = None) -> str:
    """One row per chaser: its visits, tanks and times."""
    burned: dict[str | None, float] = {}
    for leg in () if refined is None else refined.legs:
        burned[leg.chaser] = burned.get(leg.chaser, 0.0) + leg.flown_delta_v_m_s + leg.removal_m_s
    colours = chaser_colours(instance)
    times = zip(instance.chasers, instance.available_s, strict=True)
    since = {chaser.name: begin for chaser, (begin, _) in times}

    def _dotted(name: str) -> str:
        return f'<i class="dot" style="background:{colours[name]}"></i><b>{escape(name)}</b>'

    def _tanks(flown: Flown) -> str:
        by_tanks = by_tank([leg for _, leg in flown.legs], instance.station_names)
        return " + ".join(fixed(sum(leg.spent_m_s for leg in legs), 1) for legs in by_tanks)

    columns: list[Column | bool] = [
        ("chaser", "", lambda name, flown: _dotted(name)),
        ("starts", "", lambda name, flown: escape(_where(flown.chaser, since[name]))),
        ("targets", "n", lambda name, flown: str(len(flown.legs) - flown.refuellings(instance))),
        bool(instance.stations)
        and ("refuellings", "n", lambda name, flown: str(flown.refuellings(instance))),
        ("ΔV m/s", "n", lambda name, flown: fixed(flown.delta_v_m_s, 1)),
        refined is not None
        and ("refined m/s", "n", lambda name, flown: fixed(burned.get(name, 0.0), 1)),
        ("tank m/s", "n", lambda name, flown: number(flown.aboard(instance)[0].left_m_s, 1)),
        ("tank by tank m/s", "n", lambda name, flown: _tanks(flown) or NOTHING),
        (
            "leaves",
            "n",
            lambda name, flown: clock(flown.legs[0][1].departure_s) if flown.legs else NOTHING,
        ),
        ("done", "n", lambda name, flown: clock(flown.end_s) if flown.legs else NOTHING),
    ]
    routes = routes_of(instance, plan)
    return table_of("Chasers", columns, ((flown.chaser.name, flown) for flown in routes))


def loads(instance: Instance, plan: Plan) -> str:
    """One row per chaser: masses, kits, propellant and expense; empty if none matter."""
    by_expense = instance.objective.cost == "expense" or any(
        chaser.expense is not None for chaser in instance.chasers
    )
    if not (carries(instance) or by_expense):
        return ""

    def _numbers(flown: Flown) -> Iterator[str]:
        load = flown.carried(instance)
        yield from (_kg(load.mass_kg), str(load.kits), _kg(load.propellant_kg))
        yield from map(_kg, (load.used_kg, load.left_kg, load.end_mass_kg))
        if by_expense:
            yield _kg(carried_kg(instance, flown.chaser, flown.spent))
            yield number(expense_of(instance, flown.chaser, flown.spent), 3)

    rows = []
    for flown in routes_of(instance, plan):
        cells = [("n", text if flown.legs else NOTHING) for text in _numbers(flown)]
        rows.append(row([("", f"<b>{escape(flown.chaser.name)}</b>"), *cells]))
    titles = ["mass at the start kg", "kits", "propellant kg", "used kg", "left kg"]
    titles += ["mass at the end kg", *(["least aboard kg", "expense"] if by_expense else [])]
    headings = [("chaser", ""), *((title, "n") for title in titles)]
    return table("What chasers carry", headings, rows)


def _burned(leg: Leg) -> str:
    return fixed(leg.burns_delta_v_m_s, 1) if leg.manoeuvres is None else NOTHING


def _kg(mass_kg: float | None) -> str:
    return NOTHING if mass_kg is None else fixed(mass_kg, 1)


def traffic(instance: Instance, plan: Plan) -> str:
    """One row per stay of a chaser at a station, by station and time."""
    every = stays(instance, plan)
    columns: list[Column] = [
        ("station", "", lambda stay: f"<b>{escape(stay.station)}</b>"),
        ("chaser", "", lambda stay: escape(stay.chaser)),
        (
            "docks",
            "n",
            lambda stay: "starts here" if stay.refuelled_s is None else clock(stay.since_s),
        ),
        (
            "refuelled",
            "n",
            lambda stay: NOTHING if stay.refuelled_s is None else clock(stay.refuelled_s),
        ),
        ("leaves", "n", lambda stay: clock(stay.until_s)),
        ("also there", "", lambda stay: escape(", ".join(also_there(stay, every))) or NOTHING),
    ]
    shown = [(stay,) for stay in every if stay.leg]
    if not shown:
        return "<p>No chaser is at a station.</p>"
    return table_of("Station traffic", columns, shown)


def _where(chaser: Chaser, since: float) -> str:
    """Start of a chaser, with its time."""
    place = "its first target" if chaser.is_launched else "an orbit of its own"
    if chaser.launch is not None:
        place = "a launch"
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

    def _orbit(target: Target | None, tell: Callable[[Orbit], str]) -> str:
        return "" if target is None or target.orbit is None else tell(target.orbit)

    def _altitude(of: Orbit) -> str:
        return fixed((of.semi_major_axis_m - EARTH_RADIUS_M) / 1000.0, 1)

    columns: list[Column] = [
        ("target", "", lambda entry, target: f"<b>{escape(entry.target)}</b>"),
        ("reason", "", lambda entry, target: REASON_TITLES[entry.reason]),
        ("altitude km", "n", lambda entry, target: _orbit(target, _altitude)),
        (
            "inclination °",
            "n",
            lambda entry, target: _orbit(target, lambda of: fixed(of.inclination_deg, 2)),
        ),
        ("RAAN °", "n", lambda entry, target: _orbit(target, lambda of: fixed(of.raan_deg, 2))),
        ("prize", "n", lambda entry, target: number(target.greatest_prize, 3) if target else ""),
    ]
    left_out = sorted(plan.unvisited, key=lambda entry: order.index(entry.reason))
    items = ((entry, bodies.get(entry.target)) for entry in left_out)
    return table_of("Targets not visited", columns, items)


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
