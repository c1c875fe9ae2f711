"""``fly`` of a refined plan: output and exit status."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.wording import counted
from .flown import save_noted, tanks_told
from .fly_errors import Sampling, tell
from .output import emit, emit_json
from .parameters import about

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...fly.flight import RefinedFlight
    from ...fly.flight.refined_result import RefinedLegFlight
    from ...judge.admit import Admitted
    from ...plan.refined_plan import RefinedPlan

FLOWN = "flown in true dynamics"
"""Beginning of the note written by ``--out``, which replaces an earlier one."""


def fly_and_tell(
    admitted: Admitted[RefinedPlan],
    refined_path: str,
    out: str | None,
    as_json: bool,
    quiet: bool,
    sampling: Sampling,
) -> int:
    """Fly a refined plan and report its misses; the parameters are those of ``fly``."""
    from ...fly.flight import fly_refined
    from .bars import counting_bar, wanted

    instance, refined = admitted.instance, admitted.plan
    targets, shown = sampling.errors_of_targets(instance)
    dispersion = None
    with about(refined_path):
        if sampling.samples is not None:
            # First, because it is quick: what is wrong with the errors is said at once.
            with counting_bar(wanted(as_json, quiet), "sampling legs") as show:
                dispersion = sampling.fly(admitted, targets, show)
        with counting_bar(wanted(as_json, quiet), "flying legs") as show:
            flight = fly_refined(instance, admitted, show)
    if out is not None:
        save_noted(refined, FLOWN, said(flight), out, quiet)
    if dispersion is not None:
        sampling.save_uncertainty(instance, refined, dispersion, quiet)
    if as_json:
        errors = {} if dispersion is None else {"errors": dispersion.to_dict()}
        if shown is not None:
            errors["errors"]["element_sets"] = shown.to_dict()
        emit_json(flight.to_dict() | errors)
    else:
        if flight.legs:
            _tell_legs(flight)
        for chaser in flight.chasers:
            emit(str(chaser))
        emit(said(flight))
        if dispersion is not None:
            tell(dispersion, shown)
    enough = dispersion is None or not dispersion.broken_tanks
    return 0 if flight.holds and enough else 1


def said(flight: RefinedFlight) -> str:
    """The outcome in a sentence."""
    parts = [
        f"worst miss {flight.worst_miss_m:.2g} m and {flight.worst_miss_m_s:.2g} m/s over "
        f"{counted(len(flight.legs), 'leg')} in the field {flight.gravity}, planned with "
        f"{flight.planned_delta_v_m_s:.1f} and flown with {flight.flown_delta_v_m_s:.1f} m/s"
    ]
    if flight.onto_ephemerides:
        parts.append(
            "onto ephemerides, beside which holding takes an estimated "
            f"{flight.holding_m_s:.1f} m/s more"
        )
    for legs, wrong in (
        (flight.strayed, f"missed by more than {flight.limits}"),
        (flight.in_shadow, "thrust in the Earth's shadow"),
        (
            flight.off_disposal,
            "release more than 1 km or 0.001 of eccentricity off the disposal orbit",
        ),
        (flight.understated, "state too little ΔV of holding beside their bodies"),
    ):
        if legs:
            numbers = ", ".join(str(leg.leg) for leg in legs)
            parts.append(f"{'leg' if len(legs) == 1 else 'legs'} {numbers} {wrong}")
    propellant = [leg for leg in flight.legs if leg.flown_propellant_kg is not None]
    if propellant:
        planned = sum(leg.planned_propellant_kg or 0.0 for leg in propellant)
        flown = sum(leg.flown_propellant_kg or 0.0 for leg in propellant)
        parts.append(f"low thrust planned with {planned:.2f} and flown with {flown:.2f} kg")
    spirals = [leg for leg in flight.legs if leg.release_off_m is not None]
    if spirals:
        farthest = max(abs(leg.release_off_m or 0.0) for leg in spirals)
        roundest = max(leg.release_eccentricity or 0.0 for leg in spirals)
        kilograms = sum(leg.tow_propellant_kg or 0.0 for leg in spirals)
        parts.append(
            f"{counted(len(spirals), 'spiral')} flown with {kilograms:.2f} kg to within "
            f"{farthest:.2g} m of the disposal altitude and eccentricities of {roundest:.1g}"
        )
    if flight.missing:
        numbers = ", ".join(map(str, flight.missing))
        parts.append(f"not refined: leg{'s' if len(flight.missing) > 1 else ''} {numbers}")
    return "; ".join((*parts, *tanks_told(flight)))


def _tell_legs(flight: RefinedFlight) -> None:
    from .tables import emit_legs, whose

    propellant: list[tuple[str, Callable[[RefinedLegFlight], str]]] = []
    if any(leg.flown_propellant_kg is not None for leg in flight.legs):
        propellant = [
            ("planned\nkg", lambda leg: _kg(leg.planned_propellant_kg)),
            ("flown\nkg", lambda leg: _kg(leg.flown_propellant_kg)),
        ]
    holding: list[tuple[str, Callable[[RefinedLegFlight], str]]] = []
    if flight.onto_ephemerides:
        holding.append(("holding\nm/s", lambda leg: f"{leg.holding_delta_v_m_s or 0.0:.1f}"))
    emit_legs(
        flight.legs,
        (
            ("stand-off\nm", lambda leg: f"{leg.standoff_miss_m:.2g}"),
            ("\nm/s", lambda leg: f"{leg.standoff_miss_m_s:.2g}"),
            ("arrival\nm", lambda leg: f"{leg.arrival_miss_m:.2g}"),
            ("\nm/s", lambda leg: f"{leg.arrival_miss_m_s:.2g}"),
            ("planned\nm/s", lambda leg: f"{leg.planned_delta_v_m_s:.1f}"),
            ("flown\nm/s", lambda leg: f"{leg.flown_delta_v_m_s:.1f}"),
            *propellant,
            *holding,
        ),
        whose(flight.tanks),
        bold=_is_wrong,
    )


def _is_wrong(leg: RefinedLegFlight) -> bool:
    return not leg.arrives or leg.is_in_shadow or leg.is_off_disposal or leg.understates_holding


def _kg(mass: float | None) -> str:
    return "" if mass is None else f"{mass:.3f}"
