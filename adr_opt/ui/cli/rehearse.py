"""``rehearse``: fly a mission many times in random worlds, by a policy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from ...common.errors import InputError
from ...common.wording import counted
from . import complete, param
from .output import emit, emit_json, emit_rich, say_written
from .parameters import admitted_plan, check_outs

if TYPE_CHECKING:
    from rich.table import Table

    from ...analysis.rehearse.bounds import Bounds
    from ...analysis.rehearse.rehearsals import Rehearsals
    from ...analysis.rehearse.sampling import Setting
    from ...common.stop import Stop

_NOT_OF_REPLAYS = """
samples seed bounds bound_method bound_time_limit time_price jobs cluster resume_path
"""
NOT_OF_REPLAYS = tuple(_NOT_OF_REPLAYS.split())
"""Options of many rehearsals, by the names of their parameters."""


@click.command("rehearse", short_help="Fly a mission many times under uncertainty.")
@param.instance
@click.argument("plan_path", metavar="[PLAN]", required=False, shell_complete=complete.files)
@param.uncertainty(required=True)
@param.word(
    "--policy",
    "NAME",
    "follow, skip, replan, beam, learned, or an installed one.",
    default="follow",
    show_default=True,
)
@param.count("--samples", "N", "Number of rehearsals.", default=1000, show_default=True)
@param.seeded("Seed of the first world.")
@param.count(
    "--bounds", "N", "Number of worlds with a bound on every policy; default 0.", default=0
)
@param.word(
    "--bound-method",
    "NAME",
    "Bound to prove with; default exact.",
    default="exact",
    shell_complete=complete.bounds,
)
@param.number(
    "--bound-time-limit", "S", "Wall-clock limit of each proof; default 20 s.", default=20.0
)
@param.number(
    "--time-price",
    "P",
    "Price of the time of services in penalties, in prize per day; default 0.",
    default=0.0,
)
@param.processes
@param.cluster
@param.file("--resume", "File of rehearsals to write, or to resume from.", name="resume_path")
@param.count("--replay", "SEED", "Write the rehearsal of one world, and no others.")
@param.file("--out", "HTML file to write; with --replay a plan file.")
@param.file("--out-instance", "With --replay: instance file of the world to write.")
@param.spoken
def command(
    instance_path: str,
    plan_path: str | None,
    uncertainty_path: str,
    policy: str,
    samples: int,
    seed: int,
    bounds: int,
    bound_method: str,
    bound_time_limit: float,
    time_price: float,
    jobs: int,
    cluster: str | None,
    resume_path: str | None,
    replay: int | None,
    out: str | None,
    out_instance: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Fly INSTANCE many times in random worlds, starting with PLAN.

    Legs cost more or less, services take longer, captures fail, launches slip. The policy decides
    whenever a chaser is free. Without PLAN a policy that plans makes one. Exit status 1: no
    rehearsal services all required targets.
    """
    from ...analysis.rehearse import bounds as bounding
    from ...analysis.rehearse.sampling import rehearse, setting_of
    from ...analysis.rehearse.worlds import check_worlds
    from ...common.stop import MaxRuntime
    from ...problem.instance import load
    from ...problem.uncertainty import Uncertainty
    from ..report.plain import check_page, write_page
    from ..report.rehearsed import rehearsed_page
    from .bars import counting_bar, wanted
    from .work import work

    plan = None if plan_path is None else admitted_plan(instance_path, plan_path)
    instance = load(instance_path) if plan is None else plan.instance
    uncertainty = Uncertainty.load(uncertainty_path).of(instance)
    read = (instance_path, plan_path, uncertainty_path)
    bounds_path = f"{resume_path}.bounds" if bounds and resume_path is not None else None
    check_outs((out, resume_path, bounds_path, out_instance), *read)
    if bounds < 0:
        raise InputError(f"--bounds {bounds}: must be 0, for none, or more")
    MaxRuntime(bound_time_limit)
    if replay is not None:
        _refuse_with_replay()
        setting = setting_of(instance, plan, uncertainty, policy)
        return _replay(setting, replay, out, out_instance, as_json, quiet)
    if out_instance is not None:
        raise InputError("--out-instance: only --replay writes an instance; give both")
    check_page(out)
    if bounds:  # before rehearsals that may take hours
        check_worlds(bounds, seed, jobs, cluster)
        bounded_by = bounding.BoundSetting(
            instance, uncertainty, bound_method, bound_time_limit, time_price
        )
        bounding.check_bounds(bounded_by, bounds_path)

    def run(stop: Stop) -> tuple[Rehearsals, Bounds | None]:
        made = rehearse(
            instance,
            plan,
            uncertainty,
            policy=policy,
            samples=samples,
            seed=seed,
            jobs=jobs,
            cluster=cluster,
            path=resume_path,
            stop=stop,
            told=show,
        )
        if not bounds:
            return made, None
        return made, bounding.bounds(
            instance,
            uncertainty,
            samples=bounds,
            seed=seed,
            method=bound_method,
            time_limit=bound_time_limit,
            time_price=time_price,
            jobs=jobs,
            cluster=cluster,
            path=bounds_path,
            stop=stop,
            told=show,
        )

    with counting_bar(wanted(as_json, quiet), "rehearsals and bounds") as show:
        made, bounded = work(lambda stop, progress: run(stop), live=False, quiet=quiet)
    if not made.outcomes:
        raise InputError("interrupted before the first rehearsal")
    told: dict[str, Any] = made.to_dict()
    if bounded is not None:
        told |= {"bounds": bounded.to_dict(), "gaps": bounded.gaps(made)}
    if out is not None:
        write_page(out, rehearsed_page(made, told))
    say_written(out, quiet=quiet)
    if as_json:
        emit_json(told)
    else:
        _tell(told)
    return 0 if any(each.required_met for each in made.outcomes) else 1


def _refuse_with_replay() -> None:
    """Refuse options of many rehearsals that are given with --replay."""
    context = click.get_current_context()
    for name in NOT_OF_REPLAYS:
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT:
            option = f"--{name.removesuffix('_path').replace('_', '-')}"
            raise InputError(f"{option}: --replay flies one world and no others; leave it out")


def _replay(
    setting: Setting,
    seed: int,
    out: str | None,
    out_instance: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    from ...analysis.rehearse.replay import replay
    from ...common.files import write_whole

    if out is None or out_instance is None:
        raise InputError("--replay: give --out for the plan and --out-instance for its world")
    connections = f"{Path(out_instance).stem}.connections.parquet"
    made = replay(setting, seed, connections)

    def write(temporary: Path) -> None:
        temporary.write_text(made.plan.to_json(), encoding="utf-8")
        made.instance.save(out_instance)

    write_whole(out, write)  # the plan refers to the instance, which is complete by then
    say_written(out_instance, out, quiet=quiet)
    told = made.outcome.to_dict()
    if as_json:
        emit_json(told)
    else:
        lost = [f"{name} ({reason})" for name, reason in told["losses"].items()]
        emit(f"world {seed}: prize {told['prize']:g}; lost: {', '.join(lost) or 'nothing'}")
    return 0 if made.outcome.required_met else 1


def _tell(told: dict[str, Any]) -> None:
    from ..report.rehearsed import REASONS

    emit(
        f"{counted(told['samples'], 'rehearsal')} by {told['policy']}: prize "
        f"{told['prize']['mean']:.4g} on average, {told['planned_prize']:g} planned"
    )
    if told["required_met"] is not None:
        emit(f"all required targets serviced in {told['required_met']['share']:.1%}")
    emit(f"as planned, but for captures, in {told['as_planned']['share']:.1%}")
    for name, of in told.get("bounds", {}).items():
        if name in ("perfect", "penalised") and of["mean"] is not None:
            gap = told["gaps"][name]
            within = "" if gap["low"] is None else f" ({gap['low']:.1%} to {gap['high']:.1%})"
            share = "" if gap["gap"] is None else f", gap {gap['gap']:.1%}{within}"
            emit(f"{name} bound {of['mean']:.4g}{share}")
    emit_rich(_table(told))
    for reason, mean in told["losses"].items():
        emit(f"{mean:.3g} lost: {REASONS.get(reason, reason)}")


def _table(told: dict[str, Any]) -> Table:
    from .tables import number_table

    rows = [("prize", told["prize"]), ("last day", told["last_day"])]
    rows += [
        (f"left in tank {each['tank']} of {each['chaser']}, m/s", each["left_m_s"])
        for each in told["tanks"]
    ]
    headings = ("", "mean", "5 %", "25 %", "median", "75 %", "95 %")
    cells = (
        (name, *(f"{value:.4g}" for value in (of["mean"], *of["quantiles"].values())))
        for name, of in rows
    )
    return number_table("Distributions", headings, cells)
