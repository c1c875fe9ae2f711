"""The remainder of an instance from its chasers' current states, and crossings of new zones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import PurePath
from typing import Any

from ...common.errors import InputError
from ...judge.check.zone_crossings import crossed
from ...plan.after_tows import released_orbit
from ...plan.station_limits import StationLimits
from ...problem.bodies import Station
from ...problem.capture_windows import file_of, intervals_of
from ...problem.chasers import AtStation, Chaser, Expense, InOrbit
from ...problem.drives import drive_of
from ...problem.given import among
from ...problem.instance import Instance
from ...problem.numbering import LEO, Numbering
from .chaser_states import ChaserState, heavier, put_s, tank_holding
from .deviations import without_service


def crossings(
    instance: Instance, states: Sequence[ChaserState], at_s: float, before: int
) -> Iterator[str]:
    """Notes on legs that cross new zones and can no longer be avoided.

    Parameters
    ----------
    instance : Instance
        With the new zones, behind its own.
    states : sequence of ChaserState
    at_s : float
        Since the epoch [s].
    before : int
        How many zones are its own.

    Raises
    ------
    InputError
        One has not begun.
    """
    for state in states:
        for leg in state.legs:
            new = [which for which in crossed(instance, leg) if which >= before]
            if not new or leg.end_s <= at_s:
                continue
            said = f"to {leg.destination!r} crosses new zone {new[0] - before + 1}"
            if leg.leaves_s >= at_s:
                raise InputError(
                    f"the leg {said}, and is to be kept; keep fewer legs, or let an earlier one "
                    "fail"
                )
            yield f"the leg under way {said}, but will be finished"


def remaining_instance(
    instance: Instance,
    states: Sequence[ChaserState],
    lost: Sequence[str],
    at_s: float,
    given_up: Sequence[str] = (),
) -> Instance | None:
    """The remaining instance, with chasers where they are; None if a station is exhausted.

    Parameters
    ----------
    instance : Instance
        With the new zones.
    states : sequence of ChaserState
        What is flown, and where it leads.
    lost : sequence of str
        Targets that are not to be visited any more.
    at_s : float
        Since the epoch [s].
    given_up : sequence of str
        Targets that were missed, and are not tried again.

    Raises
    ------
    InputError
        What is lost is no target, or done.
    """
    missed = {name for state in states for name in state.missed}
    done = {leg.destination for state in states for leg in state.legs} - missed
    gone = {*lost, *given_up}
    names = {target.name for target in instance.targets}
    for name in lost:
        if name not in names:
            raise InputError(f"lost {name!r}: not a target of {instance.name!r}")
        if name in done:
            raise InputError(
                f"lost {name!r}: it is serviced by then, or the leg to it has begun; report it as "
                "missed if it is not serviced"
            )
    put = {state.body or "": put_s(instance, state) for state in states if state.is_put}
    targets = tuple(
        # A target still to be towed has no prize any more, and is there for its own chaser only.
        target.replace(
            prize=0.0,
            prize_until=None,
            required=True,
            capture_s=None,
            windows_s=None,
            window_s=(0.0, None) if instance.windows else put[target.name],
        )
        if target.name in put
        else target
        for target in instance.targets
        if target.name in put or (target.name not in done and target.name not in gone)
    )
    chasers = tuple(_going_on(instance, state) for state in states)
    # Launches are kept apart by their times, and a chaser put at a target is not launched.
    mission = instance.mission.replace(launch_separation_s=None) if put else instance.mission
    name = f"{instance.name}-from-{at_s:.0f}s"
    stations = _stations_left(instance, states)
    if stations is None:
        return None
    made = _changed(
        instance,
        states,
        name=name,
        targets=targets,
        chasers=chasers,
        stations=stations,
        mission=mission,
    )
    if instance.windows is None:
        return made
    windows = {each.name: instance.intervals_of(each) for each in targets}
    windows |= {  # which are written to a millisecond
        name: intervals_of([(max(begins_s - 1e-3, 0.0), ends_s + 1e-3)])
        for name, (begins_s, ends_s) in put.items()
    }
    file = PurePath(instance.windows.file)
    digest = file_of(windows).sha256[:8]
    return made.with_windows(windows, f"{file.stem}-{digest}.csv")


def _changed(instance: Instance, states: Sequence[ChaserState], **changes: Any) -> Instance:
    """The changed instance, with given connections continued from the chasers' positions.

    They lead from a start by its name, so that it takes over those of the target that it is at.
    """
    of_all = instance.transfer.given
    if instance.given is None or of_all is None:
        return instance.replace(**changes)
    parts = [changes.get(part, getattr(instance, part)) for part in Numbering.__annotations__]
    starts = {
        state.body: state.chaser.name for state in states if state.body and state.is_at_target
    }
    given = among(instance.given, Numbering(*parts).names, starts)
    # Beside the file of all of them, and of no other rest.
    file, functions_file = of_all.file, of_all.functions
    if file is not None:
        file = f"{PurePath(file).stem}-{given.sha256[:8]}.parquet"
    if functions_file is not None and given.functions is not None:
        digest = given.functions.sha256
        functions_file = f"{PurePath(functions_file).stem}-{digest[:8]}.json"
    emptied = instance.with_given(among(instance.given, ()))
    return emptied.replace(**changes).with_given(given, file, functions_file)


def _stations_left(instance: Instance, states: Sequence[ChaserState]) -> tuple[Station, ...] | None:
    """Stations with their remaining supplies; None if any is overdrawn."""
    missed = [name for state in states for name in state.missed]
    limits = StationLimits(without_service(instance, missed))
    uses = [
        limits.use(_as_flown(state), [(leg.destination, leg.delta_v_m_s) for leg in state.legs])
        for state in states
    ]
    if not limits.allow(uses):
        return None
    left = iter(limits.left(uses).tolist())
    return tuple(
        station.replace(
            max_refuellings=None if station.max_refuellings is None else round(next(left)),
            max_propellant_kg=None if station.max_propellant_kg is None else next(left),
        )
        for station in instance.stations
    )


def _going_on(instance: Instance, state: ChaserState) -> Chaser:
    """The chaser of a state, as part of an instance that starts from it.

    What it was launched for is paid, so that it has no expense any more.
    """
    chaser, stations = state.chaser, instance.station_names
    done = sum(leg.destination not in (*stations, *state.missed) for leg in state.legs)
    changes: dict[str, Any] = {"kits": state.kits}
    if chaser.max_targets is not None:
        changes["max_targets"] = max(chaser.max_targets - done, 0) + state.is_put
    since_s = put_s(instance, state)[0] if state.is_put else state.free_s
    changes["available_s"] = (since_s, _end_s(chaser, state.free_s))
    body = state.body
    if state.is_new or body is None:
        return chaser.replace(**changes)
    if chaser.expense is not None:
        changes["expense"] = Expense()
    chaser = heavier(chaser, state.idle_kits)
    if body in stations:
        return chaser.replace(
            **changes, start=AtStation(station=body), tank=tank_holding(chaser, None, None)
        )
    changes["tank"] = tank_holding(chaser, state.left_m_s, state.propellant_kg)
    if state.is_put:
        return chaser.replace(**changes, start="anywhere")
    if state.is_released:
        drive = drive_of(chaser, instance.targets)
        orbit = released_orbit(instance, drive, body, state.legs[-1].done_s)
    else:
        # Where connections are given there may be none, and nothing comes of the one that is said.
        orbit = instance.known_orbits[instance.names.index(body)] or LEO
    decay = instance.decay_of(body) or None
    return chaser.replace(**changes, start=InOrbit(orbit=orbit, decay_m_per_day=decay))


def _end_s(chaser: Chaser, free_s: float) -> float | None:
    """When a chaser that is free at a time is gone; None for never [s]."""
    end = chaser.available_s[1]
    return None if end is None else max(end, free_s)


def _as_flown(state: ChaserState) -> Chaser:
    """The chaser as `check` follows it: full, and always with the kits still aboard."""
    return heavier(state.chaser, state.weighed_kits + state.idle_kits)
