"""Tanks, kits and tows as options give them, checked against each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from ...common.errors import InputError

if TYPE_CHECKING:
    from ...problem.chasers import AnyTank


class Fitting(NamedTuple):
    """Values of the options of tanks, kits and tows; None if not given."""

    delta_v: float | None
    dry_mass: float | None
    propellant: float | None
    isp: float | None
    kits: int | None
    kit_mass: float | None
    tow: float | None
    disposal_altitude: float | None

    @property
    def disposal_altitude_m(self) -> float | None:
        """The disposal altitude [m]."""
        return None if self.disposal_altitude is None else 1e3 * self.disposal_altitude

    def check(self, *, kits: bool = False, by_mass: bool = False) -> None:
        """Refuse values out of range, or without effect unless another option is given.

        Parameters
        ----------
        kits, by_mass : bool
            Whether there are kits, and tanks by mass, by default.

        Raises
        ------
        InputError
        """
        check_positive(**self._asdict())
        if self.kit_mass is not None and self.kits is None and not kits:
            raise InputError("--kit-mass: there are no kits; give their number with --kits")
        masses = (self.dry_mass, self.propellant, self.isp)
        counted = self.delta_v is not None or not by_mass
        self._check_tow(knows_masses=masses != (None, None, None) or not counted)
        if self.kit_mass is not None and masses == (None, None, None) and counted:
            raise InputError(
                "--kit-mass: the tank is given in ΔV, without masses; give --dry-mass, "
                "--propellant and --isp"
            )

    def _check_tow(self, *, knows_masses: bool) -> None:
        if self.tow is None and self.disposal_altitude is not None:
            raise InputError("--disposal-altitude: nothing is towed; give the mass with --tow")
        if self.tow is None:
            return
        if self.disposal_altitude is None:
            raise InputError("--tow: no disposal orbit; give --disposal-altitude")
        if self.kits is not None:
            raise InputError("--tow: a target takes a kit or is towed; leave --kits or --tow out")
        if not knows_masses:
            raise InputError(
                "--tow: the tank is given in ΔV, without masses; give --dry-mass, "
                "--propellant and --isp"
            )

    def tank(self) -> AnyTank | None:
        """The requested tank; None if not given.

        Raises
        ------
        InputError
            It is incomplete, or given twice.
        """
        from pydantic import ValidationError

        from ...common.sentences import sentence
        from ...problem.chasers import Tank, TankByMass

        masses = (self.dry_mass, self.propellant, self.isp)
        if masses == (None, None, None):
            return None if self.delta_v is None else Tank(delta_v_m_s=self.delta_v)
        if self.delta_v is not None:
            raise InputError("--delta-v: the tank is given by its mass; give one of the two")
        dry_mass, propellant, isp = masses
        if dry_mass is None or propellant is None or isp is None:
            raise InputError(
                "a tank by mass needs --dry-mass, --propellant and --isp; give all three"
            )
        try:
            return TankByMass(dry_mass_kg=dry_mass, propellant_kg=propellant, isp_s=isp)
        except ValidationError as error:
            raise InputError(f"--dry-mass, --propellant and --isp: {sentence(error)}") from None


def check_positive(**given: float | None) -> None:
    """Raise :class:`InputError` for a given option that is not a positive number."""
    for name, value in given.items():
        if value is not None and not 0.0 < value < math.inf:
            raise InputError(f"{_option(name)} = {value:g}: must be a positive number")


def check_not_negative(**given: float | None) -> None:
    """Raise :class:`InputError` for a given option that is negative or not finite."""
    for name, value in given.items():
        if value is not None and not 0.0 <= value < math.inf:
            raise InputError(f"{_option(name)} = {value:g}: must be a finite number of at least 0")


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"
