"""One rehearsal as files: its world as an instance of given connections, and a plan of it.

The instance has the legs that were flown and no others, each at what it took, from its departure to
the end of the stay after it; its services take no time of their own. Prizes of targets that were
visited without success are 0. So ``check`` judges tanks, times and prizes of what happened.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...common.errors import InputError
from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...plan.plan import Plan
from ...problem.chasers import Chaser, InOrbit
from ...problem.given import of_rows
from ...problem.instance import Instance
from ...problem.numbering import LEO
from ...problem.settings import MissionSettings, TransferSettings
from ...problem.world import DrawnWorld
from ..replan.chaser_states import heavier
from .flight import FlownMission
from .flying_chasers import DRY, LATE, REFUELLED, SERVICED, FlyingChaser, Made, full_of
from .intended import intended
from .mission_facts import MissionFacts
from .outcome import Rehearsal
from .sampling import Setting, flown_in

LEAST_S = 1e-3
"""Duration given to events without one, such as a launch to a missing target [s]."""


@dataclass(frozen=True)
class Replayed:
    """A rehearsal as files.

    Attributes
    ----------
    instance : Instance
        Its world: the legs that were flown, as given connections.
    plan : Plan
        Of that instance.
    outcome : Rehearsal
    """

    instance: Instance
    plan: Plan
    outcome: Rehearsal


def replay(setting: Setting, seed: int, connections: str | None = None) -> Replayed:
    """Fly one rehearsal again, as files.

    A leg on which the tank ran dry, and one after which the service did not end in time, are left
    out: nothing came of them.

    Parameters
    ----------
    setting : Setting
    seed : int
        Of the world.
    connections : str, optional
        What the file of its connections is called when it is saved.

    Raises
    ------
    InputError
        The instance has a rule that rehearsals do not follow, or the plan is not its own.
    """
    if seed < 0:
        raise InputError(f"replay = {seed}: must not be negative")
    facts = MissionFacts(setting.instance)
    flown, outcome = flown_in(facts, intended(facts, setting.plan), setting, seed)
    world = DrawnWorld(setting.instance, setting.uncertainty, seed)
    instance = _as_instance(facts, world, flown, connections)
    problem = Problem(instance)
    number = {name: body for body, name in enumerate(problem.names)}
    routes = [
        [number[facts.names[made.hop.destination]] for made in _done(craft)]
        for craft in flown.chasers
    ]
    made = certify_routes(problem, setting.policy, routes, seed=seed, runtime_s=0.0)
    assert made.plan is not None  # nothing is required of it, and it was flown
    return Replayed(instance, made.plan, outcome)


def _done(craft: FlyingChaser) -> list[Made]:
    """Legs that had an effect."""
    return [made for made in craft.made if made.outcome not in (DRY, LATE)]


def _as_instance(
    facts: MissionFacts, world: DrawnWorld, flown: FlownMission, connections: str | None
) -> Instance:
    instance, serviced = facts.instance, {facts.names[j] for j in flown.serviced}
    visited = {
        facts.names[made.hop.destination] for craft in flown.chasers for made in _done(craft)
    }
    targets = tuple(
        target.replace(
            required=False,
            window_s=(0.0, None),
            windows_s=None,
            capture_s=None,
            decay_m_per_day=None,
            fit=None,
            prize=0.0 if target.name in visited - serviced else target.prize,
            removal="kit"
            if target.removal == "kit" and target.name not in visited - serviced
            else "visit",
        )
        for target in instance.targets
    )
    chasers = tuple(_as_flown(instance.chasers[craft.chaser], craft) for craft in flown.chasers)
    rows = [row for craft in flown.chasers for row in _rows(facts, world, craft)]
    bare = instance.replace(
        name=f"{instance.name}-world-{world.seed}",
        targets=targets,
        chasers=chasers,
        keep_out_zones=(),
        ephemerides=None,
        windows=None,
        transfer=TransferSettings(),
        mission=MissionSettings(
            duration_s=instance.mission.duration_s, service_s=0.0, refuel_revolutions=0.0
        ),
    )
    columns = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    content = {name: [row[at] for row in rows] for at, name in enumerate(columns)}
    return bare.with_given(of_rows(content, bare.names), connections)


def _as_flown(chaser: Chaser, craft: FlyingChaser) -> Chaser:
    """The chaser with the kits that it brought back counted as dry mass."""
    start = chaser.start
    if chaser.is_launched:
        start = InOrbit(orbit=LEO)
    changed = chaser.replace(
        start=start,
        end="anywhere",
        max_targets=None,
        kits=None,
        available_s=(0.0, None),
        expense=None,
        thrust_n=None,
    )
    return heavier(changed, craft.kits)


def _rows(
    facts: MissionFacts, world: DrawnWorld, craft: FlyingChaser
) -> Iterator[tuple[str, str, float, float, float]]:
    """Legs as connections whose ΔV includes tows and the unusable part of tanks."""
    what = facts.chasers[craft.chaser]
    filling, lacking = 1, True
    kits = craft.kits + sum(
        made.outcome == SERVICED and facts.takes_kit(made.hop.destination) for made in craft.made
    )
    origin = facts.instance.chasers[craft.chaser].start_name
    for made in _done(craft):
        destination = facts.names[made.hop.destination]
        cost = made.delta_v
        if lacking:
            share = 1.0 - world.usable_share(what.name, filling)
            cost, lacking = cost + share * full_of(what, kits), False
        if made.outcome == SERVICED and made.hop.destination in facts.tow_s:
            cost += made.untowed - made.left
        if made.outcome == SERVICED:
            kits -= facts.takes_kit(made.hop.destination)
        departure = min(made.hop.departure, made.free_s - LEAST_S)
        yield origin, destination, departure, made.free_s, cost
        if made.outcome == REFUELLED:
            filling, lacking = filling + 1, True
        origin = destination
