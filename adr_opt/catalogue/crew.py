"""Who goes to the objects of a catalogue, and what is asked of some of these.

An import makes one chaser, at the station or where that would be. A :class:`Crew` says otherwise:
launches at intervals, a tank by mass, kits. :class:`Demands` are what single objects have to have.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ..bodies import Target
from ..chasers import AnyTank, AtStation, Chaser, InOrbit, Tank, free_name
from ..errors import InputError
from ..kernels.constants import DAY_S
from ..orbit import Orbit
from .records import Record
from .station import find

APART_S = 365.0 * DAY_S
"""Between two launches, where nobody says how far apart they are."""


@dataclass(frozen=True)
class Crew:
    """The chasers of an instance that is made of a catalogue.

    Attributes
    ----------
    tank : Tank or TankByMass
        Of each of them.
    launches : int
        So many are launched onto their first targets; 0 is one chaser that is there already.
    apart_s : float
        From one launch to the next; the first is at the epoch [s].
    kits : int, optional
        The most that each carries, one for each target; None if targets are only visited.
    kit_mass_kg : float
        Of each kit.
    """

    tank: AnyTank = field(default_factory=lambda: Tank(delta_v_m_s=3000.0))
    launches: int = 0
    apart_s: float = APART_S
    kits: int | None = None
    kit_mass_kg: float = 0.0

    def __post_init__(self) -> None:
        if self.launches < 0:
            raise InputError(f"launches = {self.launches}: must not be negative")
        if not 0.0 <= self.apart_s < math.inf:
            raise InputError(f"time between launches = {self.apart_s:g} s: must not be negative")
        if self.kit_mass_kg > 0.0 and self.kits is None:
            raise InputError(f"kit mass = {self.kit_mass_kg:g} kg: there are no kits; say how many")

    @property
    def removal(self) -> Literal["visit", "kit"]:
        """What is done with each target."""
        return "visit" if self.kits is None else "kit"

    def chasers(
        self, home: AtStation | InOrbit, bodies: Collection[str], duration_s: float
    ) -> tuple[Chaser, ...]:
        """The chasers.

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
            name=free_name(bodies), start=home, tank=self.tank, kits=self.kits,
            kit_mass_kg=self.kit_mass_kg,
        )  # fmt: skip
        if self.launches == 0:
            return (one,)
        last_s = (self.launches - 1) * self.apart_s
        if last_s >= duration_s:
            raise InputError(
                f"launch {self.launches} is on day {last_s / DAY_S:g}, and the mission ends on day "
                f"{duration_s / DAY_S:g}; launch fewer, more often, or let it last longer"
            )
        return tuple(
            one.replace(
                name=f"chaser-{number + 1}",
                start="anywhere",
                available_s=(number * self.apart_s, None),
            )
            for number in range(self.launches)
        )


@dataclass(frozen=True)
class Demands:
    """What is asked of single objects, each by its number, name or designator.

    Attributes
    ----------
    deadlines_s : mapping of str to float
        When the service of an object has to be over, if it is serviced [s after the epoch].
    required : collection of str
        Objects that a plan has to service.
    """

    deadlines_s: Mapping[str, float] = field(default_factory=dict)
    required: Collection[str] = ()

    def __post_init__(self) -> None:
        for said, deadline_s in self.deadlines_s.items():
            if not 0.0 < deadline_s < math.inf:
                raise InputError(f"--deadline {said}={deadline_s / DAY_S:g}: must be after day 0")

    def of(self, records: Sequence[Record]) -> tuple[dict[int, float], set[int]]:
        """The deadlines [s] by the numbers of the records, and the numbers of required ones.

        Raises
        ------
        InputError
            An object is not among the records or not the only one of its name, or has two
            deadlines.
        """
        deadlines: dict[int, float] = {}
        for said, deadline_s in self.deadlines_s.items():
            number = _number(records, said, "--deadline")
            if number in deadlines:
                raise InputError(f"--deadline {said}: {records[number].label} has one already")
            deadlines[number] = deadline_s
        return deadlines, {_number(records, said, "--require") for said in self.required}


def targets_of(
    names: Sequence[str],
    orbits: Iterable[Orbit],
    removal: Literal["visit", "kit"],
    asked: tuple[Mapping[int, float], Collection[int]],
) -> tuple[Target, ...]:
    """The targets, each with its name and orbit and what is asked of it by its number."""
    deadlines, required = asked
    return tuple(
        Target(
            name=name, orbit=orbit, removal=removal, required=number in required,
            window_s=(0.0, deadlines.get(number)),
        )
        for number, (name, orbit) in enumerate(zip(names, orbits, strict=True))
    )  # fmt: skip


def _number(records: Sequence[Record], said: str, option: str) -> int:
    """Which of the targets is meant."""
    chosen = find(records, said, option, "one that is a target")
    return next(number for number, record in enumerate(records) if record is chosen)
