"""Settings of a scenario: horizon, cadence of campaigns, events, shells."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...problem.air import ACTIVITIES, FLOAT
from ...sources.worth.worth import MOST_YEARS, check_years

KINDS = ("payload", "rocket body", "debris")
"""Species of objects, in the order of all tables; fragments of drawn events come after them."""

FRAGMENTS = "fragment"

MOST_SHELLS = 200

LARGEST_SEED = 2**31


@dataclass(frozen=True)
class AltitudeShells:
    """Altitude shells of equal width, numbered from 1.

    Attributes
    ----------
    low_km, high_km : float
        Lower end of the first and upper end of the last.
    count : int
    """

    low_km: float = 200.0
    high_km: float = 2000.0
    count: int = 36

    def __post_init__(self) -> None:
        if not 0.0 <= self.low_km < self.high_km < math.inf:
            raise InputError(
                f"--shells: from {self.low_km:g} to {self.high_km:g} km; give ascending altitudes"
            )
        if not 1 <= self.count <= MOST_SHELLS:
            raise InputError(f"--shells: {self.count} shells; give 1 to {MOST_SHELLS}")

    @property
    def edges_km(self) -> FLOAT:
        """Lower and upper ends of the shells, shape (count + 1,)."""
        return np.linspace(self.low_km, self.high_km, self.count + 1)

    def numbers(self, altitudes_m: FLOAT) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Number of the shell of each altitude: 0 below the first, count + 1 above the last."""
        found: np.ndarray[Any, np.dtype[np.int64]] = np.searchsorted(
            self.edges_km, 1e-3 * altitudes_m, side="right"
        )
        return found


@dataclass(frozen=True)
class ScenarioSettings:
    """Settings of a scenario, without catalogue, campaign and launches.

    Attributes
    ----------
    years : int
        Number of years, at most 200.
    every : int
        Years from one campaign to the next; the first is in year 0.
    seeds : int
        Number of futures that are drawn, with the seeds 0, 1, …
    targets : int
        Number of objects offered to each campaign, those most worth removing.
    worth_years : float
        Horizon over which their worth is counted.
    activity : str
        Solar activity.
    drag : bool
        Whether objects and fragments come down.
    collisions : bool
        Whether collisions are drawn; their rates are told anyway.
    explosions : float
        Chance of each payload and rocket body to explode, in a year.
    capture_failure, campaign_failure : float
        Chance that a capture fails, and that a whole campaign does at its launch.
    method : str
        Planner.
    time_limit_s : float
        Wall time of each run of it [s].
    altitude_km, inclination_deg : (float, float), optional
        Range of mean altitudes and inclinations of targets.
    shells : AltitudeShells
    """

    years: int = 30
    every: int = 1
    seeds: int = 1
    targets: int = 20
    worth_years: float = 50.0
    activity: str = "mean"
    drag: bool = True
    collisions: bool = True
    explosions: float = 0.0
    capture_failure: float = 0.0
    campaign_failure: float = 0.0
    method: str = "auto"
    time_limit_s: float = 5.0
    altitude_km: tuple[float, float] | None = None
    inclination_deg: tuple[float, float] | None = None
    shells: AltitudeShells = field(default_factory=AltitudeShells)

    def __post_init__(self) -> None:
        if not 1 <= self.years <= MOST_YEARS:
            raise InputError(f"--years {self.years}: must be at least 1 and at most {MOST_YEARS:g}")
        for option, value, least in (
            ("--every", self.every, 1),
            ("--seeds", self.seeds, 1),
            ("--targets", self.targets, 1),
        ):
            if value < least:
                raise InputError(f"{option} {value}: must be at least {least}")
        if self.seeds > LARGEST_SEED:
            raise InputError(f"--seeds {self.seeds}: must be at most {LARGEST_SEED}")
        try:
            check_years(self.worth_years)
        except InputError as error:
            raise InputError(str(error).replace("--years", "--worth-years")) from None
        if self.activity not in ACTIVITIES:
            raise InputError(f"activity {self.activity!r} is unknown; use {', '.join(ACTIVITIES)}")
        for option, chance in (
            ("--explosions", self.explosions),
            ("--capture-failure", self.capture_failure),
            ("--campaign-failure", self.campaign_failure),
        ):
            if not 0.0 <= chance <= 1.0:
                raise InputError(f"{option} {chance:g}: must be a chance between 0 and 1")
        if not self.time_limit_s > 0.0:
            raise InputError(f"--time-limit {self.time_limit_s:g}: must be positive")

    def to_dict(self) -> dict[str, Any]:
        """The settings as JSON data."""
        return asdict(self)
