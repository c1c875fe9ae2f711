"""Tank of a chaser during the check: by ΔV, or by masses."""

from __future__ import annotations

import math

import numpy as np

from ...problem.chasers import Chaser, TankByMass


class TankLevel:
    """Content of a chaser's tank.

    Parameters
    ----------
    chaser : Chaser
    kits : int
        That it takes along.

    Attributes
    ----------
    mass_kg : float or None
        Of the whole chaser; None where the tank is not one by mass.
    """

    def __init__(self, chaser: Chaser, kits: int) -> None:
        self._tank, self._kit_kg, self._kits = chaser.tank, chaser.kit_mass_kg, kits
        self._kept_m_s = chaser.end_of_life_m_s or 0.0
        self.mass_kg: float | None = None
        self._left_m_s = 0.0
        self.fill()
        if isinstance(self._tank, TankByMass):
            if self._tank.initial_propellant_kg is not None:
                self.mass_kg = self._dry_kg + self._tank.initial_propellant_kg
            launch = chaser.launch
            if launch is not None and launch.launcher is not None:
                lifted_kg = np.interp(launch.altitude_m, *np.transpose(launch.launcher))
                self.mass_kg = min(self.mass_kg or 0.0, float(lifted_kg))
        elif self._tank.initial_delta_v_m_s is not None:
            self._left_m_s = self._tank.initial_delta_v_m_s - self._kept_m_s

    @property
    def _dry_kg(self) -> float:
        """Mass of the chaser without propellant."""
        assert isinstance(self._tank, TankByMass)
        return self._tank.dry_mass_kg + self._kits * self._kit_kg

    @property
    def _empty_kg(self) -> float:
        """Mass of the chaser with no propellant but the reserve for its own disposal."""
        assert isinstance(self._tank, TankByMass)
        burnt = 1.0 - math.exp(-self._kept_m_s / self._tank.exhaust_m_s)
        return self._dry_kg + self._tank.dry_mass_kg * burnt / (1.0 - burnt)

    @property
    def propellant_kg(self) -> float:
        """Propellant that may be burnt; 0 of a tank that is not one by mass."""
        return 0.0 if self.mass_kg is None else self.mass_kg - self._empty_kg

    @property
    def left_m_s(self) -> float:
        """Remaining ΔV that may be spent, by the rocket equation if the tank is one by mass.

        −inf where nothing is left to fly with: the legs have taken more than there ever was.
        """
        if self.mass_kg is None:
            return self._left_m_s
        if self.mass_kg <= 0.0:
            return -math.inf
        return self._tank.exhaust_m_s * math.log(self.mass_kg / self._empty_kg)

    def fill(self) -> None:
        """Fill the tank."""
        if isinstance(self._tank, TankByMass):
            self.mass_kg = self._dry_kg + self._tank.propellant_kg
        else:
            self._left_m_s = self._tank.delta_v_m_s - self._kept_m_s

    def burn(self, delta_v_m_s: float) -> None:
        """Spend ΔV from the tank."""
        if self.mass_kg is None:
            self._left_m_s -= delta_v_m_s
        else:
            self.mass_kg *= math.exp(-delta_v_m_s / self._tank.exhaust_m_s)

    def vent(self, propellant_kg: float) -> None:
        """Lose propellant without thrust; nothing from a tank that is not one by mass."""
        if self.mass_kg is not None:
            self.mass_kg -= propellant_kg

    def tow(self, delta_v_m_s: float, object_kg: float, back_m_s: float = 0.0) -> None:
        """Spend ΔV from the tank, towing an object; the part ``back_m_s`` after its release."""
        assert self.mass_kg is not None
        docked = (delta_v_m_s - back_m_s) / self._tank.exhaust_m_s
        self.mass_kg = (self.mass_kg + object_kg) * math.exp(-docked) - object_kg
        self.mass_kg *= math.exp(-back_m_s / self._tank.exhaust_m_s)

    def leave_kit(self) -> None:
        """Leave one of the kits behind."""
        self._kits -= 1
        if self.mass_kg is not None:
            self.mass_kg -= self._kit_kg
