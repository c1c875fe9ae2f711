"""Prizes of a design's targets: additive floors for planning, and worths alone for bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, TOURS, Follower
from ...problem.support import refuse
from ...sources.worth import SetWorths


@dataclass(frozen=True)
class Rating:
    """Worths of sets of an instance's targets.

    Without worths of sets, the prizes of the instance, which add up as they are.

    Attributes
    ----------
    worths : SetWorths or None
        Of the targets, in their order.
    unit : str
        Of what is avoided; empty for prizes.
    left_out : tuple of str
        Targets without a worth, which are not visited.
    """

    worths: SetWorths | None
    unit: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def step(self) -> float:
        """Common step of the prizes of planned instances, in the unit of worths."""
        return 1.0 if self.worths is None else self.worths.prize_unit

    @property
    def most(self) -> float:
        """Worth of all targets as a set; +inf where they add up."""
        return math.inf if self.worths is None else self.worths.of_set(self.worths.names)

    def planned(self, instance: Instance) -> Instance:
        """The instance with floors as prizes, in whole steps rounded down."""
        if self.worths is None:
            return instance
        return _with_prizes(instance, np.floor(self.worths.floors / self.step))

    def bounded(self, instance: Instance) -> Instance:
        """The instance with worths alone as prizes, in whole steps rounded up."""
        if self.worths is None:
            return instance
        return _with_prizes(instance, np.ceil(self.worths.alone / self.step))

    def alone_of(self, instance: Instance) -> list[float]:
        """Worths alone of all targets, or their prizes."""
        if self.worths is None:
            return [target.prize for target in instance.targets]
        return [float(worth) for worth in self.worths.alone]

    def floor_of(self, instance: Instance, chosen: Iterable[str]) -> float:
        """Sum of the floors of some targets."""
        if self.worths is None:
            prizes = {target.name: target.prize for target in instance.targets}
            return math.fsum(prizes[name] for name in chosen)
        floors = dict(zip(self.worths.names, self.worths.floors.tolist(), strict=True))
        return math.fsum(floors[name] for name in chosen)

    def worth_of(self, instance: Instance, chosen: Iterable[str]) -> float:
        """Worth of removing some targets as a set."""
        if self.worths is None:
            return self.floor_of(instance, chosen)
        return self.worths.of_set(chosen)


FOLLOWS = Follower(
    "a comparison of designs",
    (FIRST | CAMPAIGNS | MODELLED | TOURS | {"functions of time", "capture windows"})
    - {"prizes that fall"},
)
"""Rules followed by designs, which compare worths at one time."""


def rating_of(instance: Instance, worths: SetWorths | None) -> tuple[Instance, Rating]:
    """The instance without targets of unknown worth, and the rating of the others.

    Raises
    ------
    InputError
        No target has a worth, one without is required, or prizes fall with time.
    """
    refuse(instance, FOLLOWS)
    if worths is None:
        return instance, Rating(None)
    known = set(worths.names)
    names = [target.name for target in instance.targets if target.name in known]
    missing = tuple(target.name for target in instance.targets if target.name not in known)
    if not names:
        raise InputError(
            f"no target of {instance.name!r} is among the {len(worths.names)} objects with worths; "
            "import the catalogue that 'worth' read, with --only-prized"
        )
    for target in instance.targets:
        if target.required and target.name not in known:
            raise InputError(
                f"{target.name!r} is required, but has no worth; write it with 'worth --pairs' and "
                "more --candidates"
            )
    part = instance.part(names) if missing else instance
    return part, Rating(worths.among(names), "fragment-years", missing)


def _with_prizes(instance: Instance, prizes: npt.NDArray[np.float64]) -> Instance:
    targets = tuple(
        target.replace(prize=float(prize))
        for target, prize in zip(instance.targets, prizes, strict=True)
    )
    return instance.replace(targets=targets)
