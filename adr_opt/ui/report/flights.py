"""Outcome of flights: of the plan in its instance's dynamics, and refined in true dynamics."""

from __future__ import annotations

from collections.abc import Sequence

from ...common.wording import counted
from ...fly.flight.flights import Flight, LegFlight, TankFlight, legs_named
from ...fly.flight.refined_result import RefinedFlight
from ...fly.flight.tanks import tanks_of
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...problem.instance import Instance
from .tables import Column, route_cell, table_of
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
        "state with the planner. Miss and relative speed are those at the stand-off; at the "
        "arrival, the residual of the approach's linear equations is left."
    )
    columns: list[Column | bool] = [
        ("leg", "n", lambda leg: str(leg.leg)),
        ("from → to", "", lambda leg: route_cell(leg.origin, leg.destination)),
        ("kind", "", lambda leg: leg.kind),
        ("planned m/s", "n", lambda leg: fixed(leg.planned_delta_v_m_s, 1)),
        ("burns m/s", "n", lambda leg: fixed(leg.burns_delta_v_m_s, 1)),
        ("miss m", "n", lambda leg: _small(leg.miss_m)),
        ("relative m/s", "n", lambda leg: _small(leg.relative_speed_m_s)),
        ("at arrival m", "n", lambda leg: _small(leg.arrival_miss_m)),
        bool(flight.true_legs) and ("true orbits m/s", "n", _true),
    ]
    legs = table_of("Flown legs", columns, ((leg,) for leg in flight.legs))
    if is_refined:
        said += " The refined burns below are flown instead, and tanks are judged by them."
    tanks = "" if is_refined else _tanks(flight.tanks)
    return f"<h3>The plan, flown</h3><p>{said}</p>{legs}{tanks}"


def _true(leg: LegFlight) -> str:
    """ΔV of a leg on the true orbits, if it was flown there."""
    return _known(leg.true_delta_v_m_s) if leg.on_true_orbits else NOTHING


def _known(delta_v_m_s: float | None) -> str:
    return "unknown" if delta_v_m_s is None else fixed(delta_v_m_s, 1)


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

    def _more(leg: RefinedLeg) -> str:
        off = leg.flown_delta_v_m_s - leg.planned_delta_v_m_s
        return ("+" if off > 0.0 else "") + fixed(off, 1)

    def _miss(leg: RefinedLeg, name: str) -> str:
        flown = of_leg.get(leg.leg)
        if flown is None:
            return NOTHING
        return _small(max(getattr(flown, f"{when}_{name}") for when in ("standoff", "arrival")))

    judged = flight is not None
    columns: list[Column | bool] = [
        ("leg", "n", lambda leg: str(leg.leg)),
        ("from → to", "", lambda leg: route_cell(leg.origin, leg.destination)),
        ("kind", "", lambda leg: leg.kind),
        ("planned m/s", "n", lambda leg: fixed(leg.planned_delta_v_m_s, 1)),
        ("own burns m/s, stated", "n", lambda leg: fixed(leg.retargeted_delta_v_m_s, 1)),
        ("flown m/s", "n", lambda leg: fixed(leg.flown_delta_v_m_s, 1)),
        ("more m/s", "n", _more),
        ("burns", "n", lambda leg: str(len(leg.impulses))),
        ("lowest km, stated", "n", lambda leg: fixed(leg.lowest_altitude_m / 1e3, 0)),
        ("residual m, stated", "n", lambda leg: _small(leg.residual_m)),
        ("residual m/s, stated", "n", lambda leg: _small(leg.residual_m_s)),
        judged and ("miss m", "n", lambda leg: _miss(leg, "miss_m")),
        judged and ("miss m/s", "n", lambda leg: _miss(leg, "miss_m_s")),
    ]
    legs = table_of("Refined legs", columns, ((leg,) for leg in refined.legs))
    missing = "".join(
        f"<p>Leg {each.leg} is not refined: {escape(each.reason)}.</p>" for each in refined.missing
    )
    notes = "".join(f"<p>{escape(note)}.</p>" for note in refined.notes)
    return (
        f"<h3>The plan, refined</h3><p>{said} {_total(refined)}</p>{missing}"
        f"{legs}{_tanks(tanks_of(instance, refined))}{notes}"
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
    if not tanks:
        return ""
    columns: list[Column | bool] = [
        any(tank.chaser for tank in tanks)
        and ("chaser", "", lambda tank: escape(tank.chaser or NOTHING)),
        ("tank", "n", lambda tank: str(tank.tank)),
        ("legs", "", lambda tank: legs_named(tank.first_leg, tank.last_leg)),
        ("of m/s", "n", lambda tank: fixed(tank.budget_m_s, 1)),
        ("planned m/s", "n", lambda tank: fixed(tank.planned_delta_v_m_s, 1)),
        ("flown m/s", "n", lambda tank: _known(tank.flown_delta_v_m_s)),
        ("left m/s", "n", lambda tank: _known(None if tank.over_m_s is None else -tank.over_m_s)),
        ("verdict", "", lambda tank: "holds" if tank.holds else "<b>breaks</b>"),
    ]
    found = table_of("Tanks when flown", columns, ((tank,) for tank in tanks))
    return f"<h3>Its tanks</h3>{found}"


def _small(value: float | None) -> str:
    """A miss, rounded to its significance."""
    return "unknown" if value is None else f"{value:.2g}"
