"""Chasers, their equipment and single objects of an import, from options or a form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..common.constants import DAY_S
from ..common.errors import InputError

if TYPE_CHECKING:
    from ..problem.chasers import AnyTank, Expense, LaunchedInto
    from ..problem.disposal import Disposal
    from .catalogue import Crew, Demands


class Fitting(NamedTuple):
    """Values of the options of tanks, kits and tows; None if not given."""

    delta_v: float | None
    dry_mass: float | None
    propellant: float | None
    isp: float | None
    kits: int | None
    kit_mass: float | None
    kit_isp: float | None
    tow: float | None
    disposal_altitude: float | None
    disposal_perigee: float | None
    max_lifetime: float | None
    max_uncontrolled: float | None

    @property
    def disposal(self) -> Disposal | None:
        """The disposal orbit."""
        from ..problem.disposal import DisposalCircle, DisposalPerigee

        if self.disposal_perigee is not None:
            return DisposalPerigee(perigee_m=1e3 * self.disposal_perigee)
        altitude = self.disposal_altitude
        return None if altitude is None else DisposalCircle(circle_m=1e3 * altitude)

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
        check_positive(**self._replace(max_uncontrolled=None)._asdict())
        check_not_negative(max_uncontrolled=self.max_uncontrolled)
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
        of_tows = ("disposal_altitude", "disposal_perigee", "max_lifetime", "max_uncontrolled")
        given = [_option(name) for name in of_tows if getattr(self, name) is not None]
        if self.kit_isp is not None and self.kits is None:
            raise InputError("--kit-isp: there are no kits; give their number with --kits")
        releases = "--tow" if self.tow is not None else "--kit-isp"
        if self.tow is None and self.kit_isp is None:
            if given:
                raise InputError(
                    f"{given[0]}: nothing is towed; give the mass with --tow, or the specific "
                    "impulse of kits with --kit-isp"
                )
            return
        if self.disposal is None:
            raise InputError(
                f"{releases}: no disposal orbit; give --disposal-altitude or --disposal-perigee"
            )
        if given[:2] == ["--disposal-altitude", "--disposal-perigee"]:
            raise InputError(
                "--disposal-perigee: the disposal orbit is a circle; leave --disposal-altitude out"
            )
        if self.tow is not None and self.kits is not None:
            raise InputError("--tow: a target takes a kit or is towed; leave --kits or --tow out")
        if not knows_masses:
            raise InputError(
                f"{releases}: the tank is given in ΔV, without masses; give --dry-mass, "
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

        from ..common.sentences import sentence
        from ..problem.chasers import Tank, TankByMass

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


DELTA_V_M_S = 3000.0
"""Default ΔV of a full tank [m/s]."""


class CrewOptions(NamedTuple):
    """Values of the options of chasers and of single objects; None if not given."""

    fitting: Fitting
    launches: int | None
    launch_every: float | None
    launch_separation: float | None
    launch_into: str | None
    launcher: str | None
    end_of_life: float | None
    expense: str | None
    thrust: float | None
    duty_cycle: float | None
    service_days: float | None
    deadlines: tuple[str, ...]
    required: tuple[str, ...]
    musts: tuple[str, ...]
    excluded: tuple[str, ...]
    prizes_path: str | None

    @classmethod
    def of(cls, given: dict[str, Any]) -> CrewOptions:
        """The options by their names, those of tanks, kits and tows among them."""
        fitting = Fitting(**{name: given.pop(name) for name in Fitting._fields})
        return cls(fitting=fitting, **given)

    def crew(self) -> Crew:
        """The chasers.

        Raises
        ------
        InputError
            A number is out of range, or of no use without another option.
        """
        from ..problem.chasers import Tank
        from .catalogue import Crew
        from .catalogue.crew import APART_S

        check_positive(
            launches=self.launches,
            launch_separation=self.launch_separation,
            end_of_life=self.end_of_life,
        )
        check_not_negative(launch_every=self.launch_every, service_days=self.service_days)
        for option, value in (
            ("--launch-every", self.launch_every),
            ("--launch-separation", self.launch_separation),
            ("--launch-into", self.launch_into),
        ):
            if value is not None and self.launches is None:
                raise InputError(f"{option}: nothing is launched; give --launches as well")
        fitting = self.fitting
        fitting.check()
        self._check_thrust()
        usual_s = APART_S if self.launch_separation is None else 0.0
        separation = self.launch_separation
        tank = fitting.tank() or Tank(delta_v_m_s=DELTA_V_M_S)
        return Crew(
            tank=tank,
            launches=self.launches or 0,
            start=self._start(),
            apart_s=usual_s if self.launch_every is None else DAY_S * self.launch_every,
            kits=fitting.kits,
            kit_mass_kg=fitting.kit_mass or 0.0,
            kit_isp_s=fitting.kit_isp,
            expense=self._expense(tank),
            separation_s=None if separation is None else DAY_S * separation,
            towed_kg=fitting.tow,
            disposal=fitting.disposal,
            max_lifetime_years=fitting.max_lifetime,
            max_uncontrolled_kg=fitting.max_uncontrolled,
            end_of_life_m_s=self.end_of_life,
            service_s=None if self.service_days is None else DAY_S * self.service_days,
            thrust_n=self.thrust,
            duty_cycle=self.duty_cycle,
        )

    def _start(self) -> LaunchedInto | Literal["anywhere"]:
        """Start of the chasers by the options of launches."""
        from pydantic import ValidationError

        from ..common.sentences import sentence
        from ..problem.chasers import InsertionOrbit, LaunchedInto

        if self.launch_into is None:
            if self.launcher is not None:
                raise InputError("--launcher: no orbit to launch into; give --launch-into as well")
            return "anywhere"
        said = [] if self.launcher is None else self.launcher.split(",")
        try:
            altitude_km, inclination = map(float, self.launch_into.split(","))
        except ValueError:
            raise InputError(
                f"--launch-into {self.launch_into!r}: give ALTITUDE_KM,INCLINATION"
            ) from None
        try:
            rows = [map(float, row.split("=")) for row in said]
            lifts = [(1e3 * km, kg) for km, kg in rows]
        except ValueError:
            raise InputError(f"--launcher {self.launcher!r}: give KM=KG,KM=KG…") from None
        launch: dict[str, Any] = {"altitude_m": 1e3 * altitude_km, "inclination_deg": inclination}
        try:
            return LaunchedInto(
                launch=InsertionOrbit(**launch | ({"launcher": lifts} if lifts else {}))
            )
        except ValidationError as error:
            raise InputError(f"--launch-into {self.launch_into!r}: {sentence(error)}") from None

    def _check_thrust(self) -> None:
        from ..common.records import LARGEST_THRUST_N

        if self.thrust is None:
            if self.duty_cycle is not None:
                raise InputError("--duty-cycle: there is no thrust; give --thrust, or leave it out")
            return
        if not 0.0 < self.thrust <= LARGEST_THRUST_N:
            raise InputError(
                f"--thrust = {self.thrust:g}: must be more than 0 and at most {LARGEST_THRUST_N:g}"
            )
        if self.duty_cycle is not None and not 0.0 < self.duty_cycle <= 1.0:
            raise InputError(
                f"--duty-cycle = {self.duty_cycle:g}: must be more than 0 and at most 1"
            )
        if self.fitting.dry_mass is None:
            raise InputError(
                "--thrust: the tank is given in ΔV, without masses; give --dry-mass, "
                "--propellant and --isp"
            )

    def _expense(self, tank: AnyTank) -> Expense | None:
        from pydantic import ValidationError

        from ..common.sentences import sentence
        from ..problem.chasers import Expense, TankByMass

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
                "--expense: the tank is given in ΔV, without masses; give --dry-mass, "
                "--propellant and --isp, or one number"
            )
        return expense

    def demands(self) -> Demands:
        """Requirements on single objects.

        Raises
        ------
        InputError
            A deadline is no object with a number of days, or an object has two; or the table of
            prizes cannot be read.
        """
        from .catalogue import Demands, read_wishes

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
                raise InputError(f"--deadline {text!r}: {said} already has one")
            found[said] = deadline_s
        wishes = () if self.prizes_path is None else read_wishes(self.prizes_path)
        return Demands(found, self.required, self.musts, self.excluded, wishes)
