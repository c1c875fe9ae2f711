"""Messages of an import about fields of the instance, reworded for who gave options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from ...common.errors import InputError
from ...problem.chasers import TWO_KINDS

OPTIONS = {
    "delta_v_m_s": "--delta-v",
    "delta_v_resolution_m_s": "--resolution",
    "departure_spacing_s": "--departure-spacing-days",
    "disposal_altitude_m": "--disposal-altitude",
    "drift_step_s": "--drift-step-days",
    "dry_mass_kg": "--dry-mass",
    "duration_s": "--duration-days",
    "duty_cycle": "--duty-cycle",
    "isp_s": "--isp",
    "kit_mass_kg": "--kit-mass",
    "kits": "--kits",
    "launch_separation_s": "--launch-separation",
    "max_drift_s": "--max-drift-days",
    "propellant_kg": "--propellant",
    "semi_major_axis_m": "--station",
    "service_s": "--service-days",
    "thrust_n": "--thrust",
    "window_s": "--deadline",
}
"""Options of ``import`` by the last key of the fields that they fill."""

_FIELD = re.compile(r"^(?:\w+: )?(?:field )?(?:[\w\[\]]+\.)*(\w+)((?:\[\d+\])? = \S+):")


def by_option(said: str) -> str:
    """A message about a field of an instance, beginning with the option that fills it."""
    found = _FIELD.match(said)
    if found is None or found[1] not in OPTIONS:
        return said
    rest = said[found.end() :].removesuffix(f"; {TWO_KINDS}")
    return f"{OPTIONS[found[1]]} ({found[1]}{found[2]}):{rest}"


@contextmanager
def naming_options() -> Iterator[None]:
    """Reword errors raised within it by :func:`by_option`."""
    try:
        yield
    except InputError as error:
        said = by_option(str(error))
        if said == str(error):
            raise
        raise InputError(said) from None
