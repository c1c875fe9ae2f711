"""``replan``: plan the rest of a mission from its chasers' current states."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeVar

import click

from ...common.constants import DAY_S, HOUR_S
from ...common.errors import InputError
from ...common.wording import counted
from . import complete, param
from .output import emit, emit_json, emit_rich, say_written, terminal_width
from .parameters import admitted_plan, check_outs

if TYPE_CHECKING:
    from ...analysis.replan.chaser_states import ChaserState
    from ...analysis.replan.replanned import Replanned
    from ...problem.instance import Instance
    from ...problem.settings import KeepOutZone

Key = TypeVar("Key", int, str)

UNITS = {"": DAY_S, "d": DAY_S, "h": HOUR_S, "s": 1.0}


@click.command("replan", short_help="Replan the rest of a mission.")
@param.instance
@param.plan
@param.word(
    "--at",
    "TIME",
    "Time of replanning: days after the epoch, 36h, 900s, or ISO.",
    name="at_text",
    required=True,
)
@param.file("--zones", "JSON list of new keep-out zones.", name="zones_path")
@param.many("--lost", "NAME[,NAME...]", "Target that no longer exists.")
@param.count("--failed", "LEG", "Number of a leg that fails to begin as planned.")
@param.many("--missed", "NAME[,NAME...]", "Target reached but not serviced.")
@param.flag("--retry", "Allow missed targets to be tried again.")
@param.many(
    "--service-took",
    "NAME=DAYS",
    "Actual duration of a service or an attempt; also 36h, 900s.",
    name="services",
)
@param.many("--cost", "LEG=M_S", "Actual ΔV of a leg.", name="costs")
@param.count("--keep", "N", "Number of further legs that stay as planned; default 0.", default=0)
@param.word(
    "--method",
    "NAME",
    "Planner of the rest; by default a beam, for several chasers auto.",
    shell_complete=complete.planners,
)
@param.time_limit("Wall-clock limit of a run; default 2 s.")
@param.seed
@param.file("--out", "Plan file of the rest to write.")
@param.file("--out-instance", "Instance file of the rest to write.")
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    at_text: str,
    zones_path: str | None,
    lost: tuple[str, ...],
    failed: int | None,
    missed: tuple[str, ...],
    retry: bool,
    services: tuple[str, ...],
    costs: tuple[str, ...],
    keep: int,
    method: str | None,
    time_limit: float | None,
    seed: int,
    out: str | None,
    out_instance: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Take the state of PLAN on INSTANCE at a time, and plan the rest of the mission.

    Legs that have begun are finished. The output is the rest: an instance that begins with the
    chasers' states at that time, and its plan. Exit status 1: the rest has no plan.
    """
    from ...analysis.orders import BodyNames
    from ...analysis.replan.replanning import DEFAULT_TIME_LIMIT_S, replan
    from .work import work

    admitted = admitted_plan(instance_path, plan_path)
    instance = admitted.instance
    at_s = parse_time(at_text, instance)
    zones = () if zones_path is None else read_zones(zones_path)
    check_outs((out, out_instance), instance_path, plan_path, zones_path)
    known, names = BodyNames(instance), set(instance.names)

    def named(texts: tuple[str, ...], option: str) -> list[str]:
        return [
            known.one(part.strip(), f"{option} ")
            for text in texts
            for part in ([text] if text in names else text.split(","))
        ]

    gone, tried = named(lost, "--lost"), named(missed, "--missed")
    took_s = _once(
        (known.one(name, "--service-took "), parse_span(days, "--service-took"))
        for name, days in map(_pair_of("--service-took", "NAME=DAYS"), services)
    )
    spent_m_s = _once(map(parse_cost, costs))
    limit = DEFAULT_TIME_LIMIT_S if time_limit is None else time_limit
    made = work(
        lambda stop, progress: replan(
            instance,
            admitted,
            at_s,
            zones=zones,
            lost=gone,
            failed=failed,
            keep=keep,
            missed=tried,
            retry=retry,
            services_s=took_s,
            costs_m_s=spent_m_s,
            method=method,
            time_limit=limit,
            seed=seed,
            stop=stop,
        ),
        live=False,
        quiet=quiet,
    )
    if out_instance is not None:
        made.instance.save(out_instance)
    if out is not None and made.plan is not None:
        made.plan.save(out)
    say_written(out_instance, None if made.plan is None else out, quiet=quiet)
    if as_json:
        emit_json(made.to_dict())
    else:
        _tell(made)
    return 1 if made.plan is None else 0


def parse_time(text: str, instance: Instance) -> float:
    """A time in seconds after the epoch, from days, a number with a unit, or a date.

    Raises
    ------
    InputError
        It is none.
    """
    from ...sources.mission_options import parse_epoch

    found = _span_s(text)
    if found is not None:
        return found
    try:
        return (parse_epoch(text) - instance.epoch).total_seconds()
    except InputError:
        raise InputError(
            f"--at {text!r}: give days after the epoch, as 2.5, 36h or 900s, or a time like "
            "2026-01-01T00:00:00Z"
        ) from None


def _span_s(text: str) -> float | None:
    """A duration in seconds, from days or a number with a unit; None for other texts."""
    found = re.fullmatch(r"([+-]?\d+\.?\d*(?:e[+-]?\d+)?) *([dhs]?)", text.strip(), re.IGNORECASE)
    return None if found is None else float(found[1]) * UNITS[found[2].lower()]


def parse_span(text: str, option: str) -> float:
    """A duration given for an option, in seconds, from days or a number with a unit.

    Raises
    ------
    InputError
        It is none.
    """
    found = _span_s(text)
    if found is None:
        raise InputError(f"{option} {text!r}: give days, as 2.5, 36h or 900s")
    return found


def parse_cost(text: str) -> tuple[int, float]:
    """Number of a leg and its actual ΔV [m/s].

    Raises
    ------
    InputError
        It is something else.
    """
    number, cost = _pair_of("--cost", "LEG=M_S")(text)
    try:
        return int(number), float(cost)
    except ValueError:
        raise InputError(f"--cost {text!r}: give LEG=M_S, as 12=140.5") from None


def _pair_of(option: str, form: str) -> Callable[[str], tuple[str, str]]:
    def pair(text: str) -> tuple[str, str]:
        name, equals, value = text.rpartition("=")
        if not equals or not name.strip():
            raise InputError(f"{option} {text!r}: give {form}")
        return name.strip(), value

    return pair


def _once(pairs: Iterable[tuple[Key, float]]) -> dict[Key, float]:
    """One value for each key.

    Raises
    ------
    InputError
        A key has two.
    """
    found = dict[Key, float]()
    for key, value in pairs:
        if key in found:
            raise InputError(f"{key}: both {found[key]:g} and {value:g} are given; give one")
        found[key] = value
    return found


def read_zones(path: str) -> tuple[KeepOutZone, ...]:
    """Keep-out zones from a file: a list of them, or an instance.

    Raises
    ------
    InputError
        It cannot be read, or holds something else.
    """
    from pydantic import ValidationError

    from ...common.files import read_text
    from ...common.json_text import parse_json
    from ...common.sentences import sentence
    from ...problem.settings import KeepOutZone

    content = parse_json(read_text(path), str(path))
    if isinstance(content, dict):
        content = content.get("keep_out_zones")
    if not isinstance(content, list):
        raise InputError(f"{path}: give a list of keep-out zones, as an instance has them")
    zones = []
    for number, zone in enumerate(content):
        try:
            zones.append(KeepOutZone.model_validate(zone))
        except ValidationError as error:
            raise InputError(f"{path}: zone {number + 1}: {sentence(error)}") from None
    return tuple(zones)


def _where(state: ChaserState) -> str:
    if state.body is None:
        return "is not launched yet"
    if state.is_put:
        return f"is at {state.body}, which is still to be towed"
    if state.is_released:
        return f"is on the disposal orbit of {state.body}"
    return f"is at {state.body}"


def _tell(made: Replanned) -> None:
    from .timeline import clock, summary, timelines

    for state in made.states:
        emit(
            f"{state.chaser.name}: {counted(len(state.legs), 'leg')} flown or fixed, "
            f"{_where(state)}, free "
            f"on {clock(state.free_s)} with {state.left_m_s:.1f} m/s"
        )
    for note in made.notes:
        emit(f"note: {note}")
    if made.plan is None:
        emit("no plan of the rest services all required targets")
        return
    emit_rich(*timelines(made.instance, made.plan, terminal_width()))
    emit(summary(made.instance, made.plan))
    tried = tuple(name for name in made.missed if name not in made.given_up)
    for words, names in (
        ("lost", made.lost),
        ("missed, and given up", made.given_up),
        ("missed, and may be tried again", tried),
        ("left out now", made.dropped),
        ("visited instead", made.gained),
    ):
        if names:
            emit(f"{words}: {counted(len(names), 'target')}: {', '.join(names)}")
    emit(
        f"prize of the rest {made.prize_after:g}, {made.prize_before:g} before; "
        f"{counted(made.kept, 'leg')} at its beginning as before; {made.runtime_s:.2f} s"
    )
