"""``fly --forces full``: options and output of flights with all forces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .flown import save_noted, tanks_told
from .output import emit, emit_json
from .parameters import about

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...fly.forces import ForcedFlight, Forces, Off
    from ...judge.admit import Admitted
    from ...plan.refined_plan import RefinedPlan

FLOWN = "flown with all forces"
"""Beginning of the note written by ``--out``, which replaces an earlier one."""

OPTIONS = (
    ("--area-mass", "M2_KG", "Cross-section of a chaser over its mass; default 0.01."),
    ("--target-area-mass", "M2_KG", "Area over mass of targets; by default the chaser's."),
    ("--cd", "NUMBER", "Drag coefficient; default 2.2."),
    ("--cr", "NUMBER", "Coefficient of radiation pressure; default 1.3."),
)


class ForceOptions(NamedTuple):
    """Options of forces on the command line; None if not given."""

    forces: str
    area_mass: float | None
    target_area_mass: float | None
    cd: float | None
    cr: float | None
    activity: str | None

    @property
    def is_full(self) -> bool:
        """Whether all forces are requested."""
        return self.forces == "full"

    def refuse_stray(self, samples: int | None) -> None:
        """Raise :class:`InputError` for options that need or exclude all forces."""
        if self.is_full and samples is not None:
            raise InputError(
                "--samples flies with errors in the field of the plan; leave it or --forces full "
                "out"
            )
        names = (*(name for name, *_ in OPTIONS), "--activity")
        for name, value in zip(names, self[1:], strict=True):
            if value is not None and not self.is_full:
                raise InputError(f"{name} needs --forces full")

    def refuse_unrefined(self, plan_path: str) -> None:
        """Raise :class:`InputError` if all forces are requested for an unrefined plan."""
        if self.is_full:
            raise InputError(
                f"{plan_path}: a flight with all forces needs a refined plan; make one with "
                "'refine' and give that"
            )

    def settings(self) -> Forces:
        """The settings of the flight."""
        from ...fly.forces import Forces

        said: dict[str, Any] = {
            "area_mass_m2_kg": self.area_mass,
            "target_area_mass_m2_kg": self.target_area_mass,
            "drag": self.cd,
            "reflection": self.cr,
            "activity": self.activity,
        }
        return Forces(**{name: value for name, value in said.items() if value is not None})


force_options = param.together(
    click.option(
        "--forces",
        type=click.Choice(["j2", "full"]),
        default="j2",
        help="Fly a refined plan in its own field (j2, the default), or with all forces (full).",
    ),
    *(param.number(name, metavar, text) for name, metavar, text in OPTIONS),
    click.option(
        "--activity",
        type=click.Choice(["low", "mean", "high"]),
        help="Activity of the Sun, for drag; default mean.",
    ),
)
"""The options of flights with all forces."""


def fly_and_tell(
    admitted: Admitted[RefinedPlan],
    refined_path: str,
    out: str | None,
    as_json: bool,
    quiet: bool,
    forces: ForceOptions,
) -> int:
    """Fly a refined plan with all forces and report; the parameters are those of ``fly``."""
    from ...fly.forces import fly_forced
    from .bars import counting_bar, wanted

    settings = forces.settings()
    refined = admitted.plan
    with about(refined_path), counting_bar(wanted(as_json, quiet), "flying legs") as show:
        flight = fly_forced(admitted.instance, admitted, settings, show)
    if out is not None:
        save_noted(refined, FLOWN, said(flight), out, quiet)
    if as_json:
        emit_json(flight.to_dict())
    else:
        if flight.legs:
            _tell_legs(flight)
        for chaser in flight.chasers:
            emit(str(chaser))
        emit(said(flight))
    return 0 if flight.holds else 1


def said(flight: ForcedFlight) -> str:
    """The outcome in a sentence."""
    activity = f"{flight.forces.activity} solar activity"
    parts = [
        f"{counted(len(flight.legs), 'leg')} of {flight.flown_delta_v_m_s:.1f} m/s at {activity}: "
        f"uncorrected up to {_km(flight.worst_off_m)} km off the planned bodies, corrected in the "
        f"last revolution with {_m_s(flight.correction_m_s)} m/s; up to "
        f"{_km(flight.worst_body_off_m)} km off bodies under the same forces, corrected with "
        f"{_m_s(flight.body_correction_m_s)} m/s"
    ]
    far = [leg.leg for leg in flight.uncorrected if leg.lost is None]
    if far:
        parts.append(f"no correction found for {_legs(far)}")
    parts += [f"leg {leg.leg} is lost: {leg.lost}" for leg in flight.legs if leg.lost is not None]
    if flight.missing:
        parts.append(f"not refined: {_legs(flight.missing)}")
    return "; ".join((*parts, *tanks_told(flight)))


def _tell_legs(flight: ForcedFlight) -> None:
    from .tables import emit_legs, whose

    emit_legs(
        flight.legs,
        (
            ("burns\nm/s", lambda leg: f"{leg.flown_delta_v_m_s:.1f}"),
            ("off plan\nkm", lambda leg: _off_km(leg.planned_body)),
            ("\nm/s", lambda leg: _off_m_s(leg.planned_body)),
            ("correction\nm/s", lambda leg: _cost(leg.planned_body)),
            ("off body\nkm", lambda leg: _off_km(leg.flown_body)),
            ("\nm/s", lambda leg: _off_m_s(leg.flown_body)),
            ("correction\nm/s", lambda leg: _cost(leg.flown_body)),
        ),
        whose(flight.tanks),
        bold=lambda leg: not leg.is_corrected,
    )


def _legs(numbers: Sequence[int]) -> str:
    return f"leg{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"


def _off_km(arrival: Off | None) -> str:
    return "lost" if arrival is None else _km(arrival.distance_m)


def _off_m_s(arrival: Off | None) -> str:
    return "" if arrival is None else f"{arrival.speed_m_s:.2f}"


def _cost(arrival: Off | None) -> str:
    cost = None if arrival is None else arrival.correction_m_s
    return "none" if cost is None else f"{cost:.2f}"


def _m_s(delta_v: float | None) -> str:
    return "unknown" if delta_v is None else f"{delta_v:.2f}"


def _km(distance_m: float) -> str:
    return f"{1e-3 * distance_m:.2f}"
