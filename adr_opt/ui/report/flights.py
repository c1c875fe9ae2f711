"""Outcome of flights: of the plan in its instance's dynamics, and refined in true dynamics."""

from __future__ import annotations

from collections.abc import Sequence

from ...common.wording import counted
from ...fly.flight.refined_result import RefinedFlight
from ...fly.flight.result import EccentricFlight, Flight, LegFlight, TankFlight, legs_named
from ...fly.flight.tanks import tanks_of
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from .tables import Cell, route_cell, row, table
from .text import NOTHING, escape, fixed

MOTIONS = {"two-body": "two-body motion", "j2": "the mean motion of orbits that drift under J2"}


def section(
    instance: Instance,
    flight: Flight | str | None,
    refined: RefinedPlan | None,
    refined_flight: RefinedFlight | None,
) -> str:
    """The section on flights; empty if none was flown.

    Parameters
    ----------
    instance : Instance
    flight : Flight or str or None
        Of the plan, or why there is none; None if there need not be one.
    refined : RefinedPlan, optional
    refined_flight : RefinedFlight, optional
        Its flight by another integrator.
    """
    parts = ""
    if isinstance(flight, Flight):
        parts += _of_plan(flight, is_refined=refined is not None)
    if refined is not None:
        parts += _of_refined(instance, refined, refined_flight)
    return parts and f"<section>\n<h2>Refined and flown</h2>\n{parts}\n</section>"


def complaints(
    instance: Instance, refined: RefinedPlan | None, refined_flight: RefinedFlight | None
) -> tuple[str, ...]:
    """Errors of a refined plan: missing legs, misses, and broken tanks."""
    if refined is None:
        return ()
    found = [f"leg {missing.leg} is missing: {missing.reason}" for missing in refined.missing]
    if refined_flight is not None:
        found += [
            f"leg {leg.leg} misses by more than {refined_flight.limits}, as another "
            "integrator flies it"
            for leg in refined_flight.strayed
        ]
        found += [
            f"leg {leg.leg} states too little ΔV of holding beside its bodies"
            for leg in refined_flight.understated
        ]
        found += [
            f"leg {leg.leg} releases its object on another orbit than that of disposal"
            for leg in refined_flight.off_disposal
        ]
    return (*found, *(str(tank) for tank in tanks_of(instance, refined) if not tank.holds))


def _of_plan(flight: Flight, *, is_refined: bool) -> str:
    said = (
        f"The burns of the plan, flown in {MOTIONS[flight.dynamics]} by a program that shares no "
        "state with the planner. The miss is that at the stand-off, and with it the speed relative "
        "to it; at the arrival what the linear equations of the approach leave."
    )
    is_true = any(leg.eccentric for leg in flight.legs)
    if is_true:
        said += (
            " Between eccentric orbits also where the burns lead on the true ones, and what a "
            "corrected last arc costs; aside is what the plan sets aside for it."
        )
    rows = [_leg(leg, is_true) for leg in flight.legs]
    headings = [
        ("leg", "n"),
        ("from → to", ""),
        ("kind", ""),
        ("planned m/s", "n"),
        ("burns m/s", "n"),
        ("miss m", "n"),
        ("relative m/s", "n"),
        ("at arrival m", "n"),
    ]
    if is_true:
        headings += [("true miss m", "n"), ("aside m/s", "n"), ("corrected m/s", "n")]
    if is_refined:
        said += " The refined burns below are flown instead, and tanks are judged by them."
    tanks = "" if is_refined else _tanks(flight.tanks)
    return f"<h3>The plan, flown</h3><p>{said}</p>{table('Flown legs', headings, rows)}{tanks}"


def _leg(leg: LegFlight, is_true: bool) -> str:
    cells: list[Cell] = [
        ("n", str(leg.leg)),
        route_cell(leg.origin, leg.destination),
        ("", leg.kind),
        ("n", fixed(leg.planned_delta_v_m_s, 1)),
        ("n", fixed(leg.burns_delta_v_m_s, 1)),
        ("n", _small(leg.miss_m)),
        ("n", _small(leg.relative_speed_m_s)),
        ("n", _small(leg.arrival_miss_m)),
    ]
    if is_true:
        cells += _true(leg.eccentric)
    return row(cells)


def _true(flown: EccentricFlight | None) -> list[Cell]:
    if flown is None:
        return [("n", NOTHING)] * 3
    return [
        ("n", _small(flown.true_miss_m)),
        ("n", fixed(flown.eccentricity_delta_v_m_s, 1)),
        (
            "n",
            "unknown"
            if flown.correction_delta_v_m_s is None
            else fixed(flown.correction_delta_v_m_s, 1),
        ),
    ]


def _of_refined(instance: Instance, refined: RefinedPlan, flight: RefinedFlight | None) -> str:
    of_leg = {} if flight is None else {leg.leg: leg for leg in flight.legs}
    free = "with free burns" if refined.freedom == "free" else "with the burns of the plan, mended"
    said = (
        f"Each leg led to its stand-off and its target in numerically integrated motion, in the "
        f"field {refined.gravity}, {_onto(refined)}{free}. Own burns is what the plan’s own come "
        "to when they are corrected, and the residual what is left at the stand-off or the target, "
        "both as the file states them, like the lowest altitude; nobody has judged these"
        + (", and the miss what another integrator finds." if flight else ".")
    )
    rows = []
    for leg in refined.legs:
        off = leg.flown_delta_v_m_s - leg.planned_delta_v_m_s
        cells: list[Cell] = [
            ("n", str(leg.leg)),
            route_cell(leg.origin, leg.destination),
            ("", leg.kind),
            ("n", fixed(leg.planned_delta_v_m_s, 1)),
            ("n", fixed(leg.retargeted_delta_v_m_s, 1)),
            ("n", fixed(leg.flown_delta_v_m_s, 1)),
            ("n", ("+" if off > 0.0 else "") + fixed(off, 1)),
            ("n", str(len(leg.burns))),
            ("n", fixed(leg.lowest_altitude_m / 1e3, 0)),
            ("n", _small(leg.residual_m)),
            ("n", _small(leg.residual_m_s)),
        ]
        if flight is not None:
            flown = of_leg.get(leg.leg)
            cells += (
                [("n", NOTHING)] * 2
                if flown is None
                else [
                    ("n", _small(max(flown.standoff_miss_m, flown.arrival_miss_m))),
                    ("n", _small(max(flown.standoff_miss_m_s, flown.arrival_miss_m_s))),
                ]
            )
        rows.append(row(cells))
    headings = [
        ("leg", "n"),
        ("from → to", ""),
        ("kind", ""),
        ("planned m/s", "n"),
        ("own burns m/s, stated", "n"),
        ("flown m/s", "n"),
        ("more m/s", "n"),
        ("burns", "n"),
        ("lowest km, stated", "n"),
        ("residual m, stated", "n"),
        ("residual m/s, stated", "n"),
    ]
    if flight is not None:
        headings += [("miss m", "n"), ("miss m/s", "n")]
    missing = "".join(
        f"<p>Leg {each.leg} is not refined: {escape(each.reason)}.</p>" for each in refined.missing
    )
    notes = "".join(f"<p>{escape(note)}.</p>" for note in refined.notes)
    return (
        f"<h3>The plan, refined</h3><p>{said} {_total(refined)}</p>{missing}"
        f"{table('Refined legs', headings, rows)}{_tanks(tanks_of(instance, refined))}{notes}"
    )


def _total(refined: RefinedPlan) -> str:
    """Total ΔV of the refined legs."""
    own = refined.retargeted_delta_v_m_s
    return (
        f"In all, {counted(len(refined.legs), 'leg')}: planned with "
        f"{fixed(refined.planned_delta_v_m_s, 1)} m/s, {fixed(own, 1)} m/s with the plan’s own "
        f"burns, and flown with {fixed(refined.flown_delta_v_m_s, 1)} m/s." + _holding(refined)
    )


def _onto(refined: RefinedPlan) -> str:
    if refined.ephemerides is None:
        return ""
    return "between the states that the ephemerides of its bodies report, "


def _holding(refined: RefinedPlan) -> str:
    """The ΔV of holding, if there is any."""
    if refined.ephemerides is None:
        return ""
    return (
        " Holding beside the bodies, which move freely in no field, is not flown: it takes an "
        f"estimated {fixed(refined.holding_m_s, 1)} m/s, which tanks count."
    )


def _tanks(tanks: Sequence[TankFlight]) -> str:
    whose = any(tank.chaser for tank in tanks)
    rows = [
        row(
            [
                *([("", escape(tank.chaser or NOTHING))] if whose else []),
                ("n", str(tank.tank)),
                ("", legs_named(tank.first_leg, tank.last_leg)),
                ("n", fixed(tank.budget_m_s, 1)),
                ("n", fixed(tank.planned_delta_v_m_s, 1)),
                (
                    "n",
                    "unknown"
                    if tank.flown_delta_v_m_s is None
                    else fixed(tank.flown_delta_v_m_s, 1),
                ),
                ("n", "unknown" if tank.over_m_s is None else fixed(-tank.over_m_s, 1)),
                ("", "holds" if tank.holds else "<b>breaks</b>"),
            ]
        )
        for tank in tanks
    ]
    headings = (
        *([("chaser", "")] if whose else []),
        ("tank", "n"),
        ("legs", ""),
        ("of m/s", "n"),
        ("planned m/s", "n"),
        ("flown m/s", "n"),
        ("left m/s", "n"),
        ("verdict", ""),
    )
    return "<h3>Its tanks</h3>" + table("Tanks when flown", headings, rows) if rows else ""


def _small(value: float | None) -> str:
    """A miss, rounded to its significance."""
    return "unknown" if value is None else f"{value:.2g}"
