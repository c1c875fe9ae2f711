"""``replan``: plan the rest of a mission anew, from where its chasers are."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import click

from ..errors import InputError
from ..kernels.constants import DAY_S, HOUR_S
from ..wording import counted
from .output import emit, emit_json, emit_rich, say, terminal_width
from .parameters import (
    check_out,
    instance_argument,
    is_same_file,
    json_option,
    plan_argument,
    quiet_option,
)

if TYPE_CHECKING:
    from ..analysis.replanned import Replanned
    from ..analysis.state import State
    from ..instance import Instance
    from ..settings import KeepOutZone

UNITS = {"": DAY_S, "d": DAY_S, "h": HOUR_S, "s": 1.0}


@click.command("replan", short_help="Plan the rest of a mission anew.")
@instance_argument
@plan_argument
@click.option(
    "--at", "at_text", required=True, metavar="TIME", help="Days after the epoch; 36h, 900s; ISO."
)
@click.option("--zones", "zones_path", metavar="FILE", help="JSON: new keep-out zones, a list.")
@click.option(
    "--lost", multiple=True, metavar="NAME[,NAME...]", help="A target that is none any more."
)
@click.option("--failed", type=int, metavar="LEG", help="A leg that is not flown as planned.")
@click.option("--keep", type=int, default=0, metavar="N", help="Legs more that stay as planned; 0.")
@click.option("--method", metavar="NAME", help="Planner of the rest; else a beam, of several auto.")
@click.option("--time-limit", type=float, metavar="S", help="Wall time of a run; 2 s.")
@click.option("--seed", type=int, default=0, show_default=True, help="Same seed, same result.")
@click.option("--out", metavar="FILE", help="Plan file of the rest to write.")
@click.option("--out-instance", metavar="FILE", help="Instance file of the rest to write.")
@json_option
@quiet_option
def command(
    instance_path: str,
    plan_path: str,
    at_text: str,
    zones_path: str | None,
    lost: tuple[str, ...],
    failed: int | None,
    keep: int,
    method: str | None,
    time_limit: float | None,
    seed: int,
    out: str | None,
    out_instance: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Take the state of PLAN on INSTANCE at a time, and plan what is left of it anew.

    Legs that have begun are finished. What is written is the rest: an instance that begins where
    the chasers are then, and its plan. Exit status 1: there is no plan of the rest.
    """
    from ..analysis.orders import BodyNames
    from ..analysis.replan import DEFAULT_TIME_LIMIT_S, replan
    from ..instance import load
    from ..plan import load_plan
    from .work import work

    instance, plan = load(instance_path), load_plan(plan_path)
    at_s = parse_time(at_text, instance)
    zones = () if zones_path is None else read_zones(zones_path)
    check_out(out, instance_path, plan_path, zones_path)
    check_out(out_instance, instance_path, plan_path, zones_path)
    if out is not None and out_instance is not None and is_same_file(out, out_instance):
        raise InputError(f"{out}: named for the plan and for the instance; give each its own")
    known, names = BodyNames(instance), set(instance.names)
    gone = [
        known.one(part.strip(), "--lost ")
        for text in lost
        for part in ([text] if text in names else text.split(","))
    ]
    limit = DEFAULT_TIME_LIMIT_S if time_limit is None else time_limit
    made = work(
        lambda stop, progress: replan(
            instance, plan, at_s, zones=zones, lost=gone, failed=failed, keep=keep, method=method,
            time_limit=limit, seed=seed, stop=stop,
        ),
        live=False, quiet=quiet,
    )  # fmt: skip
    if out_instance is not None:
        made.instance.save(out_instance)
    if out is not None and made.plan is not None:
        made.plan.save(out)
    if not quiet:
        for path, there in ((out_instance, True), (out, made.plan is not None)):
            if path is not None and there:
                say(f"wrote {path}")
    if as_json:
        emit_json(made.to_dict())
    else:
        _tell(made)
    return 1 if made.plan is None else 0


def parse_time(text: str, instance: Instance) -> float:
    """A time as seconds after the epoch: days, or with a unit, or a date.

    Raises
    ------
    InputError
        It is none.
    """
    from .import_ import parse_epoch

    found = re.fullmatch(r"([+-]?\d+\.?\d*(?:e[+-]?\d+)?) *([dhs]?)", text.strip(), re.IGNORECASE)
    if found is not None:
        return float(found[1]) * UNITS[found[2].lower()]
    try:
        return (parse_epoch(text) - instance.epoch).total_seconds()
    except InputError:
        raise InputError(
            f"--at {text!r}: give days after the epoch, as 2.5, 36h or 900s, or a time like "
            "2026-01-01T00:00:00Z"
        ) from None


def read_zones(path: str) -> tuple[KeepOutZone, ...]:
    """The keep-out zones of a file: a list of them, or an instance.

    Raises
    ------
    InputError
        It cannot be read, or holds something else.
    """
    import json

    from pydantic import ValidationError

    from ..files import read_text, sentence
    from ..settings import KeepOutZone

    try:
        content = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not JSON: {error.msg}; give a JSON file") from None
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


def _where(state: State) -> str:
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
    for table in timelines(made.instance, made.plan, terminal_width()):
        emit_rich(table)
    emit(summary(made.instance, made.plan))
    for words, names in (
        ("lost", made.lost), ("left out now", made.dropped), ("visited instead", made.gained)
    ):  # fmt: skip
        if names:
            emit(f"{words}: {counted(len(names), 'target')}: {', '.join(names)}")
    emit(
        f"prize of the rest {made.prize_after:g}, {made.prize_before:g} before; "
        f"{counted(made.kept, 'leg')} at its beginning as before; {made.runtime_s:.2f} s"
    )
