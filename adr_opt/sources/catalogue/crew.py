"""Chasers for the objects of a catalogue.

An import makes one chaser, at the station or where that would be. A :class:`Crew` says otherwise:
launches at intervals, a tank by mass, kits, tows.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Literal

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.bodies import Removal
from ...problem.chasers import (
    AnyTank,
    AtStation,
    Chaser,
    Expense,
    InOrbit,
    LaunchedInto,
    Tank,
    TankByMass,
    free_name,
)
from ...problem.disposal import Disposal
from ...problem.settings import Objective

APART_S = 365.0 * DAY_S
"""Default interval between launches [s]."""


@dataclass(frozen=True)
class Crew:
    """The chasers of an instance made from a catalogue.

    Attributes
    ----------
    tank : Tank or TankByMass
        Of each of them.
    launches : int
        Number of chasers launched; 0 is one chaser that is there already.
    start : LaunchedInto or "anywhere"
        The orbit they are launched into, or their first targets.
    apart_s : float
        From one launch to the next; the first is at the epoch [s].
    kits : int, optional
        The most that each carries, one for each target; None if targets are only visited.
    kit_mass_kg : float
        Of each kit; with ``kit_isp_s`` without the propellant that disposals take.
    kit_isp_s : float, optional
        Specific impulse of kits that lead to the orbit of disposal, by which they are sized.
    expense : Expense, optional
        Of each chaser; then plans are to take as little as they can.
    separation_s : float, optional
        Launches lie so far apart at least; then each may be at the epoch but for ``apart_s`` [s].
    towed_kg : float, optional
        Mass of each target, all of which are towed; None if they are not.
    disposal : DisposalCircle or DisposalPerigee, optional
        The orbit that they are towed to, or that kits lead them to.
    max_lifetime_years : float, optional
        How long they may stay in orbit once they are released.
    max_uncontrolled_kg : float, optional
        Mass above which they have to re-enter under control.
    end_of_life_m_s : float, optional
        What each chaser keeps for its own disposal.
    service_s : float, optional
        How long each service takes; None for one revolution of the target [s].
    thrust_n, duty_cycle : float, optional
        Low thrust of each chaser, and the share of the time in which it is on at most.
    """

    tank: AnyTank = field(default_factory=lambda: Tank(delta_v_m_s=3000.0))
    launches: int = 0
    start: LaunchedInto | Literal["anywhere"] = "anywhere"
    apart_s: float = APART_S
    kits: int | None = None
    kit_mass_kg: float = 0.0
    kit_isp_s: float | None = None
    expense: Expense | None = None
    separation_s: float | None = None
    towed_kg: float | None = None
    disposal: Disposal | None = None
    max_lifetime_years: float | None = None
    max_uncontrolled_kg: float | None = None
    end_of_life_m_s: float | None = None
    service_s: float | None = None
    thrust_n: float | None = None
    duty_cycle: float | None = None

    def __post_init__(self) -> None:
        if self.launches < 0:
            raise InputError(f"launches = {self.launches}: must not be negative")
        if not 0.0 <= self.apart_s < math.inf:
            raise InputError(f"time between launches = {self.apart_s:g} s: must not be negative")
        if self.service_s is not None and not 0.0 <= self.service_s < math.inf:
            raise InputError(f"service = {self.service_s:g} s: must not be negative")
        if self.kit_mass_kg > 0.0 and self.kits is None:
            raise InputError(f"kit mass = {self.kit_mass_kg:g} kg: there are no kits; give some")
        if self.towed_kg is not None and self.kits is not None:
            raise InputError("a target takes a kit or is towed; give kits or a mass to tow")
        if self.kit_isp_s is not None and self.kits is None:
            raise InputError(f"kit_isp_s = {self.kit_isp_s:g}: there are no kits; give some")
        if (self.towed_kg is None and self.kit_isp_s is None) != (self.disposal is None):
            raise InputError("a tow needs a mass and a disposal orbit; give both or none")
        if self.towed_kg is not None and not isinstance(self.tank, TankByMass):
            raise InputError("a tow needs masses, but the tank is given in ΔV")
        if self.thrust_n is not None and not isinstance(self.tank, TankByMass):
            raise InputError("low thrust needs masses, but the tank is given in ΔV")

    @property
    def objective(self) -> Objective:
        """The tie-breaker between plans that collect equal prizes."""
        return Objective() if self.expense is None else Objective(cost="expense")

    @property
    def removal(self) -> Removal:
        """The service of each target."""
        if self.towed_kg is not None:
            return "tow"
        return "visit" if self.kits is None else "kit"

    def chasers(
        self, home: AtStation | InOrbit, bodies: Collection[str], duration_s: float
    ) -> tuple[Chaser, ...]:
        """The chasers as parts of an instance.

        Parameters
        ----------
        home : AtStation or InOrbit
            Where the one starts that is there already.
        bodies : collection of str
            Names that are taken.
        duration_s : float
            Of the mission [s].

        Raises
        ------
        InputError
            The last launch comes after the mission.
        """
        one = Chaser(
            name=free_name(bodies),
            start=home,
            tank=self.tank,
            kits=self.kits,
            kit_mass_kg=self.kit_mass_kg,
            expense=self.expense,
            end_of_life_m_s=self.end_of_life_m_s,
            thrust_n=self.thrust_n,
            duty_cycle=self.duty_cycle,
        )
        if self.launches == 0:
            return (one,)
        last_s = (self.launches - 1) * max(self.apart_s, self.separation_s or 0.0)
        if last_s >= duration_s:
            raise InputError(
                f"launch {self.launches} is on day {last_s / DAY_S:g}, and the mission ends on day "
                f"{duration_s / DAY_S:g}; launch fewer, more often, or in a longer mission"
            )
        return tuple(
            one.replace(
                name=f"chaser-{number + 1}",
                start=self.start,
                available_s=(number * self.apart_s, None),
            )
            for number in range(self.launches)
        )
