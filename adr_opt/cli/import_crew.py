"""What ``import`` has for chasers and single objects: launches, tanks, kits, tows, deadlines."""

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
    from ..chasers import AnyTank, Expense
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
                "--tow", type=float, metavar="KG", help="Mass of each target, which is towed,"
            ),
            click.option(
                "--disposal-altitude", type=float, metavar="KM", help="down to a circle there."
            ),
            click.option(
                "--launches", type=int, metavar="N", help="N chasers, each onto its first target."
            ),
            click.option(
                "--launch-every", type=float, metavar="DAYS", help="Between two launches; 365."
            ),
            click.option(
                "--launch-separation", type=float, metavar="DAYS",
                help="Between two launches at least, each as soon as it is worth it.",
            ),
            click.option(
                "--expense", metavar="FIXED[,PER_KG[,PER_KG2]]",
                help="Of each chaser that is used; of equal plans the least expense is best.",
            ),
            click.option(
                "--deadline", "deadlines", multiple=True, metavar="OBJECT=DAYS",
                help="When its service has to be over; may be repeated.",
            ),
            click.option(
                "--require", "required", multiple=True, metavar="OBJECT",
                help="Has to be serviced; refused if filters leave it out. Repeatable.",
            ),
            click.option(
                "--must", "musts", multiple=True, metavar="OBJECT[,OBJECT...]",
                help="The same, but kept whatever the filters say.",
            ),
            click.option(
                "--exclude", "excluded", multiple=True, metavar="OBJECT[,OBJECT...]",
                help="One that is to be no target; may be repeated.",
            ),
            click.option(
                "--prizes", "prizes_path", metavar="FILE",
                help="CSV: object, prize, required, window, mass, removal.",
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
    tow: float | None
    disposal_altitude: float | None
    launches: int | None
    launch_every: float | None
    launch_separation: float | None
    expense: str | None
    deadlines: tuple[str, ...]
    required: tuple[str, ...]
    musts: tuple[str, ...]
    excluded: tuple[str, ...]
    prizes_path: str | None

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
            ("--kit-mass", self.kit_mass), ("--tow", self.tow),
            ("--disposal-altitude", self.disposal_altitude), ("--launches", self.launches),
            ("--launch-every", self.launch_every), ("--launch-separation", self.launch_separation),
        ):  # fmt: skip
            if value is not None and not 0.0 < value < math.inf:
                raise InputError(f"{option} = {value:g}: must be a positive number")
        if self.launch_every is not None and self.launches is None:
            raise InputError("--launch-every: nothing is launched; say how often with --launches")
        if self.launch_separation is not None and self.launches is None:
            raise InputError(
                "--launch-separation: nothing is launched; say how often with --launches"
            )
        if self.kit_mass is not None and self.kits is None:
            raise InputError("--kit-mass: there are no kits; say how many with --kits")
        self._check_tow()
        usual_s = APART_S if self.launch_separation is None else 0.0
        separation = self.launch_separation
        tank = self._tank()
        return Crew(
            tank=tank,
            launches=self.launches or 0,
            apart_s=usual_s if self.launch_every is None else DAY_S * self.launch_every,
            kits=self.kits,
            kit_mass_kg=self.kit_mass or 0.0,
            expense=self._expense(tank),
            separation_s=None if separation is None else DAY_S * separation,
            towed_kg=self.tow,
            disposal_altitude_m=(
                None if self.disposal_altitude is None else 1e3 * self.disposal_altitude
            ),
        )

    def _expense(self, tank: AnyTank) -> Expense | None:
        from pydantic import ValidationError

        from ..chasers import Expense, TankByMass
        from ..files import sentence

        if self.expense is None:
            return None
        try:
            numbers = [float(part) for part in self.expense.split(",")]
        except ValueError:
            numbers = []
        if not 1 <= len(numbers) <= 3:
            raise InputError(
                f"--expense {self.expense!r}: give one to three numbers, FIXED,PER_KG,PER_KG2"
            )
        named = dict(zip(("fixed", "per_kg", "per_kg_squared"), numbers, strict=False))
        try:
            expense = Expense(**named)
        except ValidationError as error:
            raise InputError(f"--expense {self.expense!r}: {sentence(error)}") from None
        if expense.counts_mass and not isinstance(tank, TankByMass):
            raise InputError(
                "--expense: a tank that is counted in ΔV knows no masses; give --dry-mass, "
                "--propellant and --isp, or one number"
            )
        return expense

    def _check_tow(self) -> None:
        if self.tow is None and self.disposal_altitude is not None:
            raise InputError("--disposal-altitude: nothing is towed; say what mass with --tow")
        if self.tow is None:
            return
        if self.disposal_altitude is None:
            raise InputError("--tow: where to is not said; give --disposal-altitude")
        if self.kits is not None:
            raise InputError("--tow: a target takes a kit or is towed; leave --kits or --tow out")
        if (self.dry_mass, self.propellant, self.isp) == (None, None, None):
            raise InputError(
                "--tow: a tank that is counted in ΔV knows no masses; give --dry-mass, "
                "--propellant and --isp"
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
            A deadline is no object with a number of days, or an object has two; or the table of
            prizes cannot be read.
        """
        from ..catalogue import Demands, read_wishes

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
        wishes = () if self.prizes_path is None else read_wishes(self.prizes_path)
        return Demands(found, self.required, self.musts, self.excluded, wishes)


def told(instance: Instance) -> str | None:
    """The launches of an instance in a sentence; None if there are none."""
    if not instance.launches:
        return None
    days = ", ".join(f"{since_s / DAY_S:g}" for since_s in instance.launches.values())
    return f"{counted(len(instance.launches), 'launch', 'launches')}, on day {days}"
