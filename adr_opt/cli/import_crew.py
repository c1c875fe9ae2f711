"""What ``import`` has for chasers and for single objects: launches, tanks, kits and deadlines."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from ..errors import InputError
from ..kernels.constants import DAY_S
from ..wording import counted

if TYPE_CHECKING:
    from ..catalogue import Crew, Demands
    from ..chasers import AnyTank
    from ..instance import Instance

Function = TypeVar("Function", bound=Callable[..., Any])

DELTA_V_M_S = 3000.0
"""A full tank, where nobody says what is in it."""


def crew_options(function: Function) -> Function:
    """The options of chasers and of single objects, for ``import``."""
    for option in reversed(
        (
            click.option("--delta-v", type=float, metavar="M_S", help="ΔV of a full tank; 3000."),
            click.option("--dry-mass", type=float, metavar="KG", help="Instead: mass without it,"),
            click.option("--propellant", type=float, metavar="KG", help="what a full tank holds,"),
            click.option("--isp", type=float, metavar="S", help="and its specific impulse."),
            click.option(
                "--kits", type=int, metavar="K", help="A kit for each target, at most K aboard."
            ),
            click.option("--kit-mass", type=float, metavar="KG", help="Of each kit; 0."),
            click.option(
                "--launches", type=int, metavar="N", help="N chasers, each onto its first target."
            ),
            click.option(
                "--launch-every", type=float, metavar="DAYS", help="Between two launches; 365."
            ),
            click.option(
                "--deadline", "deadlines", multiple=True, metavar="OBJECT=DAYS",
                help="When its service has to be over; may be repeated.",
            ),
            click.option(
                "--require", "required", multiple=True, metavar="OBJECT",
                help="One that has to be serviced; may be repeated.",
            ),
        )
    ):  # fmt: skip
        function = option(function)
    return function


class CrewOptions(NamedTuple):
    """These options as they were given; None is for what was not."""

    delta_v: float | None
    dry_mass: float | None
    propellant: float | None
    isp: float | None
    kits: int | None
    kit_mass: float | None
    launches: int | None
    launch_every: float | None
    deadlines: tuple[str, ...]
    required: tuple[str, ...]

    def crew(self) -> Crew:
        """The chasers.

        Raises
        ------
        InputError
            A number is out of range, or of no use without another option.
        """
        from ..catalogue import Crew
        from ..catalogue.crew import APART_S

        for option, value in (
            ("--delta-v", self.delta_v), ("--dry-mass", self.dry_mass),
            ("--propellant", self.propellant), ("--isp", self.isp), ("--kits", self.kits),
            ("--kit-mass", self.kit_mass), ("--launches", self.launches),
            ("--launch-every", self.launch_every),
        ):  # fmt: skip
            if value is not None and not 0.0 < value < math.inf:
                raise InputError(f"{option} = {value:g}: must be a positive number")
        if self.launch_every is not None and self.launches is None:
            raise InputError("--launch-every: nothing is launched; say how often with --launches")
        if self.kit_mass is not None and self.kits is None:
            raise InputError("--kit-mass: there are no kits; say how many with --kits")
        return Crew(
            tank=self._tank(),
            launches=self.launches or 0,
            apart_s=APART_S if self.launch_every is None else DAY_S * self.launch_every,
            kits=self.kits,
            kit_mass_kg=self.kit_mass or 0.0,
        )

    def _tank(self) -> AnyTank:
        from ..chasers import Tank, TankByMass

        masses = (self.dry_mass, self.propellant, self.isp)
        if masses == (None, None, None):
            if self.kit_mass is not None:
                raise InputError(
                    "--kit-mass: a tank that is counted in ΔV knows no masses; give --dry-mass, "
                    "--propellant and --isp"
                )
            return Tank(delta_v_m_s=DELTA_V_M_S if self.delta_v is None else self.delta_v)
        if self.delta_v is not None:
            raise InputError("--delta-v: the tank is given by its mass; give one of the two")
        dry_mass, propellant, isp = masses
        if dry_mass is None or propellant is None or isp is None:
            raise InputError(
                "a tank by mass needs --dry-mass, --propellant and --isp; give all three"
            )
        from pydantic import ValidationError

        from ..files import sentence

        try:
            return TankByMass(dry_mass_kg=dry_mass, propellant_kg=propellant, isp_s=isp)
        except ValidationError as error:
            raise InputError(f"--dry-mass, --propellant and --isp: {sentence(error)}") from None

    def demands(self) -> Demands:
        """What is asked of single objects.

        Raises
        ------
        InputError
            A deadline is no object with a number of days, or an object has two.
        """
        from ..catalogue import Demands

        found: dict[str, float] = {}
        for text in self.deadlines:
            said, sign, days = (part.strip() for part in text.rpartition("="))
            try:
                deadline_s = DAY_S * float(days)
            except ValueError:
                sign = ""
            if not (sign and said):
                raise InputError(f"--deadline {text!r}: give an object and days, OBJECT=DAYS")
            if said in found:
                raise InputError(f"--deadline {text!r}: {said} has one already")
            found[said] = deadline_s
        return Demands(found, self.required)


def told(instance: Instance) -> str | None:
    """The launches of an instance in a sentence; None if there are none."""
    if not instance.launches:
        return None
    days = ", ".join(f"{since_s / DAY_S:g}" for since_s in instance.launches.values())
    return f"{counted(len(instance.launches), 'launch', 'launches')}, on day {days}"
