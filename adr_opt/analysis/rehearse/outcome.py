"""The outcome of one rehearsal, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from pydantic import ConfigDict

from ...common.constants import SLACK_M_S
from .flight import FlownMission
from .flying_chasers import DRY, FAILED, FINISHED, GONE, REFUELLED, SERVICED
from .intended import Intended
from .mission_facts import MissionFacts
from .worlds import EXACT

LEFT_OUT = "left-out"
"""Reason of loss for a planned target that the policy left out."""


@dataclass(frozen=True)
class Rehearsal:
    """The outcome of a mission in one world.

    Attributes
    ----------
    seed : int
        Number of the world.
    prize, expected : float
        Collected; and without the luck of captures (:attr:`.flight.FlownMission.expected`).
    required_met, returned : bool
        Whether all required targets were serviced, and all chasers ended where they have to.
    last_s : float
        End of the last service or tow; 0 without any [s].
    delta_v_m_s : float
        Of all legs [m/s].
    tanks : tuple of (str, int, float, bool)
        Chaser and number of each tank, ΔV left at its end [m/s], and whether it ran dry.
    losses : mapping of str to str
        Targets that were planned or visited and not serviced, each with the reason.
    course : tuple of (float, float)
        Ends of services [s], and the prize collected by then.
    spent : tuple of (float, float)
        Arrivals [s], and the ΔV of all legs by then [m/s].
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT

    seed: int
    prize: float
    expected: float
    required_met: bool
    returned: bool
    last_s: float
    delta_v_m_s: float
    tanks: tuple[tuple[str, int, float, bool], ...]
    losses: dict[str, str]
    course: tuple[tuple[float, float], ...]
    spent: tuple[tuple[float, float], ...]

    @property
    def as_planned(self) -> bool:
        """Whether nothing was lost except by failed captures and missing targets."""
        return all(reason in (FAILED, GONE) for reason in self.losses.values()) and not any(
            ran_dry for *_, ran_dry in self.tanks
        )

    def to_dict(self) -> dict[str, Any]:
        """The outcome as JSON data."""
        return asdict(self)


def outcome_of(
    facts: MissionFacts, intended: Intended, flown: FlownMission, seed: int, *, keeps: bool
) -> Rehearsal:
    """The outcome of a flown mission, whether or not the policy follows the plan."""
    names, prizes = facts.names, facts.prizes
    serviced = set(flown.serviced)
    losses = dict[str, str]()
    for craft in flown.chasers:
        for made in craft.made:
            j = made.hop.destination
            if j >= facts.stations and j not in serviced:
                losses[names[j]] = made.outcome
        for planned in intended.routes[craft.chaser]:
            j = planned.hop.destination
            if j >= facts.stations and j not in serviced:
                ended = craft.ended if keeps and craft.ended != FINISHED else LEFT_OUT
                losses.setdefault(names[j], ended)
    legs = [made for craft in flown.chasers for made in craft.made]
    course, spent, prize, delta_v = [], [], 0.0, 0.0
    for made in sorted(legs, key=lambda made: made.end_s):
        if made.outcome == SERVICED:
            prize += prizes[made.hop.destination]
            course.append((made.end_s, prize))
    for made in sorted(legs, key=lambda made: made.hop.arrival):
        delta_v += made.delta_v
        spent.append((made.hop.arrival, delta_v))
    ends = [facts.instance.chasers[craft.chaser].end for craft in flown.chasers]
    returned = all(
        end == "anywhere" or names[craft.body] == end.station
        for craft, end in zip(flown.chasers, ends, strict=True)
    )
    return Rehearsal(
        seed,
        flown.prize,
        flown.expected,
        facts.required <= serviced,
        returned,
        max((made.free_s for made in legs if made.outcome == SERVICED), default=0.0),
        delta_v,
        tuple(_tanks(facts, flown)),
        losses,
        tuple(course),
        tuple(spent),
    )


def _tanks(facts: MissionFacts, flown: FlownMission) -> list[tuple[str, int, float, bool]]:
    """Each tank of each chaser, with the ΔV left at its end."""
    found = []
    for craft in flown.chasers:
        name, number = facts.chasers[craft.chaser].name, 1
        for each in craft.made:
            if each.outcome == REFUELLED:
                found.append((name, number, max(each.untowed - SLACK_M_S, 0.0), False))
                number += 1
        dry = craft.ended == DRY
        found.append((name, number, max(craft.left - SLACK_M_S, 0.0), dry))
    return found
