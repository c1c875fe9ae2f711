"""The mission and the objects of an import, from options of a command line or a form."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..common.constants import DAY_S
from ..common.errors import InputError
from ..problem.chasers import TWO_KINDS
from .crew_options import check_positive

if TYPE_CHECKING:
    from ..problem.settings import ApproachName
    from .catalogue import MissionOutline


LEAST_STEP_DAYS = 0.01
"""Least step of the grid of long transfers; smaller ones must be typing errors [s]."""


class MissionOptions(NamedTuple):
    """Values of the options of the mission; None if not given."""

    epoch: str | None = None
    duration_days: float = 7.0
    dynamics: Literal["j2", "two-body"] = "j2"
    no_refuelling: bool = False
    drift_step_days: float | None = None
    max_drift_days: float | None = None
    departure_spacing_days: float | None = None
    resolution: float | None = None
    burns: Literal["sequence", "free"] | None = None
    approach: ApproachName | None = None
    keep_out: float | None = None

    def outline(self, *, thrust: bool = False, fitted_by: str | None = None) -> MissionOutline:
        """The mission.

        Parameters
        ----------
        thrust : bool
            Whether chasers have low thrust.
        fitted_by : str, optional
            The option by which orbits are fitted to ephemerides.

        Raises
        ------
        InputError
            A value is out of range, or of no use beside another one.
        """
        from ..common.records import LARGEST_DURATION_S
        from .catalogue import MissionOutline

        days = self.duration_days
        check_positive(duration_days=days)
        if days * DAY_S > LARGEST_DURATION_S:
            raise InputError(
                f"--duration-days = {days:g}: must be at most {LARGEST_DURATION_S / DAY_S:g}"
            )
        transfer: dict[str, Any] = transfer_of(
            self.dynamics,
            self.drift_step_days,
            self.max_drift_days,
            self.departure_spacing_days,
            self.resolution,
            "sequence" if thrust and self.burns is None else self.burns,
        )
        transfer |= {"approach": self.approach, "keep_out_m": self.keep_out}
        if thrust and (self.dynamics != "j2" or self.max_drift_days == 0.0):
            raise InputError(
                "--thrust: low-thrust transfers drift; keep --dynamics j2 and --max-drift-days"
            )
        if fitted_by is not None and self.dynamics != "j2":
            raise InputError(f"{fitted_by}: orbits are fitted under J2; keep --dynamics j2")
        return MissionOutline(
            epoch=None if self.epoch is None else parse_epoch(self.epoch),
            duration_s=DAY_S * days,
            dynamics=self.dynamics,
            transfer=transfer,
            refuelling=not self.no_refuelling,
        )


def transfer_of(
    dynamics: str,
    drift_step_days: float | None,
    max_drift_days: float | None,
    departure_spacing_days: float | None,
    resolution: float | None,
    burns: str | None,
) -> dict[str, float | str | None]:
    """Transfer settings given in the call; the others, None, are derived from the mission.

    Raises
    ------
    InputError
        A number is out of range, or of no use in two-body motion.
    """
    for option, value, least in (
        ("--drift-step-days", drift_step_days, LEAST_STEP_DAYS),
        ("--max-drift-days", max_drift_days, 0.0),
        ("--departure-spacing-days", departure_spacing_days, 0.0),
        ("--resolution", resolution, 0.0),
    ):
        if value is not None and not (least <= value < math.inf):
            raise InputError(f"{option} = {value:g}: must be a number of at least {least:g}")
    if dynamics != "j2":
        for option, value in (
            ("--drift-step-days", drift_step_days),
            ("--max-drift-days", max_drift_days),
        ):
            if value:
                raise InputError(
                    f"{option} = {value:g}: no plane drifts in two-body motion; leave it out, or "
                    "--dynamics two-body"
                )
    return {
        "drift_step_s": _seconds(drift_step_days),
        "max_drift_s": _seconds(max_drift_days),
        "departure_spacing_s": _seconds(departure_spacing_days),
        "delta_v_resolution_m_s": resolution,
        "burns": burns,
    }


def _seconds(days: float | None) -> float | None:
    return None if days is None else DAY_S * days


def parse_epoch(text: str) -> datetime:
    """A time in ISO 8601, UTC unless it states another zone.

    Raises
    ------
    InputError
        It is none.
    """
    from datetime import UTC

    try:
        epoch = datetime.fromisoformat(text)
        return epoch.replace(tzinfo=UTC) if epoch.tzinfo is None else epoch.astimezone(UTC)
    except (ValueError, OverflowError):
        raise InputError(f"--epoch {text!r}: give a time like 2026-01-01T00:00:00Z") from None


def check_objects(names: Iterable[str], max_targets: int | None) -> None:
    """Refuse empty names and a number of targets below 1.

    Parameters
    ----------
    names : iterable of str
        Parts of names, or patterns.
    max_targets : int or None

    Raises
    ------
    InputError
    """
    if any(not name.strip() for name in names):
        raise InputError("--name '': give a part of a name or a pattern")
    check_positive(max_targets=max_targets)


OPTIONS = {
    "burns": "--burns",
    "approach": "--approach",
    "circle_m": "--disposal-altitude",
    "delta_v_m_s": "--delta-v",
    "delta_v_resolution_m_s": "--resolution",
    "departure_spacing_s": "--departure-spacing-days",
    "drift_step_s": "--drift-step-days",
    "dry_mass_kg": "--dry-mass",
    "duration_s": "--duration-days",
    "duty_cycle": "--duty-cycle",
    "end_of_life_m_s": "--end-of-life",
    "isp_s": "--isp",
    "keep_out_m": "--keep-out",
    "kit_mass_kg": "--kit-mass",
    "kits": "--kits",
    "launch_separation_s": "--launch-separation",
    "max_drift_s": "--max-drift-days",
    "max_lifetime_years": "--max-lifetime",
    "max_uncontrolled_kg": "--max-uncontrolled",
    "perigee_m": "--disposal-perigee",
    "propellant_kg": "--propellant",
    "semi_major_axis_m": "--station",
    "service_s": "--service-days",
    "thrust_n": "--thrust",
    "window_s": "--deadline",
}
"""Options of ``import`` by the last key of the fields that they fill."""

_FIELD = re.compile(r"^(?:\w+: )?(?:field |the file )?(?:[\w\[\]]+\.)*(\w+)((?:\[\d+\])? = \S+):")


def by_option(said: str) -> str:
    """A message about a field of an instance, reworded to begin with the option that fills it."""
    found = _FIELD.match(said)
    if found is None or found[1] not in OPTIONS:
        return said
    rest = said[found.end() :].removesuffix(f"; {TWO_KINDS}")
    return f"{OPTIONS[found[1]]} ({found[1]}{found[2]}):{rest}"


@contextmanager
def naming_options() -> Iterator[None]:
    """Context in which errors are reworded by :func:`by_option`."""
    try:
        yield
    except InputError as error:
        said = by_option(str(error))
        if said == str(error):
            raise
        raise InputError(said) from None
