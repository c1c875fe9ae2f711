"""Replanning of what remains of a mission, from the chasers' current states and with changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ...common.clock import now_s
from ...common.stop import Stop
from ...judge.admit import AnyPlan, admit
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, RELEASES, Follower
from ...problem.settings import KeepOutZone
from ...problem.support import refuse
from .chaser_states import ChaserState, states_at
from .deviations import Deviations
from .remaining_instance import crossings, remaining_instance
from .remaining_plan import PlannerChoice, plan_remaining
from .replanned import RemainingPlan, Replanned, compared
from .starts import former_orders, in_order

DEFAULT_TIME_LIMIT_S = 2.0


FOLLOWS = Follower(
    "replan",
    FIRST
    | CAMPAIGNS
    | MODELLED
    | RELEASES
    | {"functions of time", "capture windows", "end of life"},
)


def replan(  # noqa: PLR0913
    instance: Instance,
    plan: AnyPlan,
    at_s: float,
    *,
    zones: Iterable[KeepOutZone] = (),
    lost: Iterable[str] = (),
    failed: int | None = None,
    keep: int = 0,
    missed: Iterable[str] = (),
    retry: bool = False,
    services_s: Mapping[str, float] | None = None,
    costs_m_s: Mapping[int, float] | None = None,
    method: str | None = None,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
) -> Replanned:
    """Replan what remains of a mission.

    What has begun is finished (:func:`.chaser_states.states_at`). A chaser that has serviced a
    target since it refuelled last may refuel at once; to be full earlier is never worse, so that is
    one more start, by the connection that arrives first. Where the former plan is about to do so it
    is taken; where it had ended, less than half a tank is left, or the chaser has to end at a
    station, both are tried. What remains of the former plan, without what it cannot fly any more,
    is what the new one has to beat.

    A chaser with an object that it is still to tow is put onto that once more (:mod:`.starts`),
    and one that has begun its last tow goes on from the disposal orbit. The rules of the whole
    mission allow no wait there, so a note says so.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
        Of this instance, without violations.
    at_s : float
        Since the epoch [s].
    zones : iterable of KeepOutZone
        New ones, besides those of the instance.
    lost : iterable of str
        Targets that are not to be visited any more.
    failed : int, optional
        Number of a leg that does not begin as planned. Earlier legs of its chaser are flown as
        planned, and the rest begins where that leg was to begin, later.
    keep : int
        Number of further legs of each chaser, not yet begun, that are flown as planned.
    missed : iterable of str
        Targets that are reached but not serviced: the chaser is there, with its kit, and tows
        nothing.
    retry : bool
        Whether those may be tried again; else they are given up.
    services_s : mapping of str to float, optional
        How long the service of a target took, or the attempt at one that was missed [s].
    costs_m_s : mapping of int to float, optional
        Actual ΔV of a leg, by its number, without a following tow [m/s].
    method : str, optional
        Planner of the rest; "beam" for one chaser and "auto" for several by default.
    time_limit : float
        Wall time of a run [s].
    seed, stop
        As :func:`adr_opt.solve` takes them.

    Raises
    ------
    InputError
        The plan is of another instance or has violations, the time is outside the mission, a name
        is no target or one that is done, a leg that is to be kept crosses a new zone, or the events
        contradict each other or the plan.
    """
    began = now_s()
    refuse(instance, FOLLOWS)
    plan = admit(instance, plan).plan
    instance = instance.without_reserves()
    went = Deviations(_each_once(missed), retry, dict(services_s or {}), dict(costs_m_s or {}))
    states = states_at(instance, plan, at_s, keep=keep, failed=failed, went=went)
    zoned, notes = _zoned(instance, tuple(zones))
    notes += tuple(note for state in states for note in state.notes)
    notes += tuple(crossings(zoned, states, at_s, len(instance.keep_out_zones)))
    gone = _each_once(lost)
    former = former_orders(plan, states)
    states = in_order(zoned, states)

    def left(now: tuple[ChaserState, ...]) -> Instance | None:
        return remaining_instance(zoned, now, gone, at_s, went.given_up)

    choice = PlannerChoice(method, time_limit, seed, stop)
    best = plan_remaining(zoned, left, states, former, choice)
    notes = (*notes, *_waits(states, best))
    orders = tuple(former[state.chaser.name] for state in best.states)
    return compared(instance, best, orders, gone, went, notes, began)


def _zoned(instance: Instance, zones: tuple[KeepOutZone, ...]) -> tuple[Instance, tuple[str, ...]]:
    """The instance with further zones, and a note if legs have another price for them."""
    if not zones:
        return instance, ()
    transfer = instance.transfer.replace(burns="sequence")
    zoned = instance.replace(keep_out_zones=(*instance.keep_out_zones, *zones), transfer=transfer)
    if transfer == instance.transfer:
        return zoned, ()
    return zoned, (
        "short legs are priced by the burns of their sequence, which avoid the zones; paths of "
        "free burns are not checked",
    )


def _each_once(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _waits(states: Sequence[ChaserState], found: RemainingPlan) -> Iterator[str]:
    """Notes on chasers that continue from a disposal orbit after waiting there."""
    released = {state.chaser.name for state in states if state.is_released}
    instance, begun, made = found
    flown = set() if made.plan is None else {each.chaser for each in made.plan.routes if each.legs}
    flown |= {state.chaser.name for state in begun if not state.is_released}
    for name in sorted(released & flown):
        yield (
            f"{name} continues from a disposal orbit after waiting there, which {instance.name!r} "
            "allows but the whole mission does not"
        )
