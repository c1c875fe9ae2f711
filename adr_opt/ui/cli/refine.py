"""``refine``: turn a plan into a trajectory that holds in true dynamics."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from ...common.errors import InputError
from ...common.stop import Stop
from ...common.wording import counted
from . import param
from .output import emit, emit_json, say
from .parameters import about, admitted_plan, check_out
from .signals import signals_to

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...plan.refined_plan import Freedom, Gravity, RefinedLeg, RefinedPlan
    from ...problem.instance import Instance
    from ...run.run_options import RunOptions
    from .work import Watch


GRAVITIES = ("two-body", "j2", "j3", "j4")
FREEDOMS = ("free", "planned")

gravity_option = click.option(
    "--gravity",
    type=click.Choice(GRAVITIES),
    help="Gravity field, by its highest zonal harmonic; by default that of INSTANCE.",
)
freedom_option = click.option(
    "--burns",
    "freedom",
    type=click.Choice(FREEDOMS),
    help="free: least ΔV at any times; planned: the plan's own burns, changed little; by default "
    "free, or planned where there are keep-out zones.",
)
ephemerides_option = param.flag(
    "--ephemerides", "Refine legs onto the states of the ephemerides beside INSTANCE."
)


@click.command("refine", short_help="Turn PLAN into a trajectory in true dynamics.")
@param.instance
@param.plan
@param.file("--out", "Refined plan file to write.", required=True)
@gravity_option
@freedom_option
@ephemerides_option
@param.cores()
@param.cluster
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    out: str,
    gravity: Gravity | None,
    freedom: Freedom | None,
    ephemerides: bool,
    jobs: int | None,
    cluster: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Guide each leg of PLAN to its stand-off and its target in numerically integrated motion.

    Ctrl-C stops and writes the finished legs. Exit status 1: a leg is missing, for lack of time or
    of a trajectory.
    """
    from ...fly.refine import refine
    from .bars import counting_bar, wanted

    check_out(out, instance_path, plan_path)
    admitted, stopped = admitted_plan(instance_path, plan_path), threading.Event()
    bar = counting_bar(wanted(as_json, quiet), "refining legs")
    with about(plan_path), signals_to(stopped.set), bar as show:
        refined = refine(
            admitted.instance,
            admitted,
            gravity=gravity,
            freedom=freedom,
            jobs=jobs,
            cluster=cluster,
            enough=stopped.is_set,
            report=show,
            ephemerides=ephemerides,
        )
    refined.save(out)
    say(f"wrote {out}: {counted(len(refined.legs), 'leg')}, {refined.status}", unless=quiet)
    if as_json:
        emit_json(_told(refined, out))
    else:
        if refined.legs:
            _tell_legs(refined)
        for sentence in _by_chaser(refined):
            emit(sentence)
        emit(_summary(refined))
        for missing in refined.missing:
            emit(f"leg {missing.leg} is missing: {missing.reason}")
    return 1 if refined.missing else 0


def _summary(refined: RefinedPlan) -> str:
    planned, flown = refined.planned_delta_v_m_s, refined.flown_delta_v_m_s
    own = refined.retargeted_delta_v_m_s
    kept = f", and {own:.1f} m/s with the plan's own burns" if _is_free(refined) else ""
    return (
        f"{counted(len(refined.legs), 'leg')} in the field {refined.gravity}: planned with "
        f"{planned:.1f} m/s, flown with {flown:.1f} m/s{kept}{_holding(refined)}"
    )


def _holding(refined: RefinedPlan) -> str:
    if refined.ephemerides is None:
        return ""
    return (
        f"; onto ephemerides, beside which holding takes an estimated {refined.holding_m_s:.1f} "
        "m/s more"
    )


def _is_free(refined: RefinedPlan) -> bool:
    return refined.freedom == "free"


def _by_chaser(refined: RefinedPlan) -> Iterator[str]:
    """ΔV of the legs of each of several chasers."""
    for chaser in dict.fromkeys(leg.chaser for leg in refined.legs if leg.chaser is not None):
        legs = [leg for leg in refined.legs if leg.chaser == chaser]
        planned = sum(leg.planned_delta_v_m_s + leg.planned_removal_m_s for leg in legs)
        flown = sum(leg.flown_delta_v_m_s + leg.removal_m_s for leg in legs)
        yield (
            f"{chaser}: {counted(len(legs), 'leg')}, planned with {planned:.1f} m/s, flown with "
            f"{flown:.1f} m/s"
        )


def _tell_legs(refined: RefinedPlan) -> None:
    from .tables import emit_legs

    columns: list[tuple[str, Callable[[RefinedLeg], str]]] = [
        ("kind", lambda leg: leg.kind),
        ("planned\nm/s", lambda leg: f"{leg.planned_delta_v_m_s:.1f}"),
        ("own burns\nm/s", lambda leg: f"{leg.retargeted_delta_v_m_s:.1f}"),
        ("flown\nm/s", lambda leg: f"{leg.flown_delta_v_m_s:.1f}"),
        ("burns", lambda leg: str(len(leg.impulses))),
        ("lowest\nkm", lambda leg: f"{leg.lowest_altitude_m / 1e3:.0f}"),
    ]
    if any(leg.removal_m_s for leg in refined.legs):
        columns.insert(4, ("tow\nm/s", lambda leg: f"{leg.removal_m_s:.1f}"))
    if refined.ephemerides is not None:
        columns.append(("holding\nm/s", lambda leg: f"{leg.holding_m_s:.1f}"))
    whose = {leg.leg: leg.chaser for leg in refined.legs if leg.chaser is not None}
    emit_legs(refined.legs, columns, whose)


def _told(refined: RefinedPlan, out: str) -> dict[str, object]:
    arcs = {"thrust": {"arcs"}}
    many: Any = {"burns": True, "states": True, "tow": arcs, "tow_before": arcs, **arcs}
    legs = [leg.model_dump(mode="json", exclude=many) for leg in refined.legs]
    facts = ("status", "runtime_s", "planned_delta_v_m_s", "flown_delta_v_m_s")
    return {
        "path": out,
        "gravity": refined.gravity,
        "burns": refined.freedom,
        **{name: getattr(refined, name) for name in facts},
        **_told_onto(refined),
        "missing": [missing.model_dump() for missing in refined.missing],
        "legs": legs,
    }


def _told_onto(refined: RefinedPlan) -> dict[str, object]:
    """Figures of a refinement onto ephemerides, as plain data."""
    if refined.ephemerides is None:
        return {}
    return {
        "ephemerides": refined.ephemerides.model_dump(),
        "holding_delta_v_m_s": refined.holding_m_s,
    }


class Refining(NamedTuple):
    """Options of ``solve`` on refinement; None if not given."""

    refine: bool
    refined_out: str | None
    gravity: Gravity | None
    freedom: Freedom | None
    ephemerides: bool
    rounds: int | None
    spend_savings: bool
    screen: tuple[str, ...]
    avoid_m: float | None
    avoid_probability: float | None
    errors_path: str | None

    def check(self, instance_path: str, out: str | None) -> None:
        """Raise :class:`InputError` for options that exclude each other."""
        from .parameters import check_out

        for name, value in (
            ("--refined-out", self.refined_out),
            ("--gravity", self.gravity),
            ("--burns", self.freedom),
            ("--ephemerides", "" if self.ephemerides else None),
            ("--rounds", self.rounds),
            ("--spend-savings", "" if self.spend_savings else None),
            ("--screen", self.screen[0] if self.screen else None),
        ):
            if value is not None and not self.refine:
                raise InputError(f"{f'{name} {value}'.strip()}: nothing is refined; add --refine")
        for name, number in (
            ("avoid", self.avoid_m),
            ("avoid-probability", self.avoid_probability),
        ):
            if number is not None and not self.screen:
                raise InputError(f"--{name} {number:g}: nothing is screened; add --screen FILE")
        check_out(self.refined_out, instance_path, *self.screen, results=(out,))

    def unsafe(self, instance: Instance) -> dict[str, Any]:
        """Conjunctions to avoid, as an argument of :func:`.solve_refined`; none by default."""
        if not self.screen:
            return {}
        from ...analysis.screening import avoiding, read_errors
        from ...sources import catalogue

        stated = {"avoid_m": self.avoid_m, "most_probability": self.avoid_probability}
        errors = None if self.errors_path is None else read_errors(self.errors_path)
        known = {name: value for name, value in stated.items() if value is not None}
        records = catalogue.read(self.screen).records
        return {"unsafe": avoiding(instance, records, errors=errors, **known)}


refine_options = param.together(
    param.flag("--refine", "Refine the plan, and replan until it holds in true dynamics."),
    param.file("--refined-out", "Refined plan file to write."),
    gravity_option,
    freedom_option,
    ephemerides_option,
    param.count("--rounds", "N", "Maximum number of plans with --refine; default 10."),
    param.flag(
        "--spend-savings", "With --refine, spend ΔV saved in flight; 'check' may refuse the plan."
    ),
    param.many(
        "--screen", "FILE", "Catalogue whose objects the refined plan avoids; repeatable.", "screen"
    ),
    param.number("--avoid", "M", "Avoid approaches within this; default 1000.", "avoid_m"),
    param.number("--avoid-probability", "P", "Avoid approaches at or above this probability."),
    param.errors,
)
"""The options of refining, for ``solve``."""


def run_refined(
    instance: Instance,
    method: str,
    refining: Refining,
    progress: Watch,
    quiet: bool,
    *,
    stop: Stop,
    wanted: RunOptions,
) -> RefinedResult:
    """Plan and refine in turns, reporting each round at its end."""
    from ...fly.refine.loop import MOST_ROUNDS, solve_refined

    return solve_refined(
        instance,
        method,
        gravity=refining.gravity,
        freedom=refining.freedom,
        ephemerides=refining.ephemerides,
        rounds=MOST_ROUNDS if refining.rounds is None else refining.rounds,
        spend_savings=refining.spend_savings,
        **refining.unsafe(instance),
        told=(lambda one: None) if quiet else (lambda one: say(str(one))),
        progress=progress,
        building=progress.building,
        sizing=progress.sizing,
        stop=stop,
        **vars(wanted),
    )


def save_refined(looped: RefinedResult, path: str | None, quiet: bool) -> None:
    """Write the refined plan, if there is one and a file is given."""
    if path is None or looped.refined is None:
        return
    looped.refined.save(path)
    legs = counted(len(looped.refined.legs), "leg")
    say(f"wrote {path}: {legs}, {looped.refined.status}", unless=quiet)


def tell_refined(looped: RefinedResult, as_json: bool) -> None:
    """Print whether the plan holds, and its cost."""
    refined, plan = looped.refined, looped.plan
    planned = None if refined is None else refined.planned_delta_v_m_s
    flown = None if refined is None else refined.flown_delta_v_m_s
    if as_json:
        emit_json(
            {
                "holds": looped.holds,
                "reason": looped.reason,
                "planned_delta_v_m_s": planned,
                "flown_delta_v_m_s": flown,
                **_told_holding(refined),
                "notes": looped.result.notes,
                "rounds": [one.to_dict() for one in looped.rounds],
                "plan": None if plan is None else plan.to_dict(),
            }
        )
    elif looped.holds:
        emit(
            f"the plan holds when refined: planned with {planned:.1f} m/s, flown with "
            f"{flown:.1f} m/s{_holding_told(refined)}, after {counted(len(looped.rounds), 'round')}"
        )
    else:
        emit(f"the plan does not hold: {looped.reason}")


def _holding_told(refined: RefinedPlan | None) -> str:
    """Estimated ΔV of holding, where there are ephemerides."""
    if refined is None or refined.ephemerides is None:
        return ""
    return f" and {refined.holding_m_s:.1f} m/s of holding beside ephemerides"


def _told_holding(refined: RefinedPlan | None) -> dict[str, float]:
    """Estimated ΔV of holding, as plain data."""
    if refined is None or refined.ephemerides is None:
        return {}
    return {"holding_delta_v_m_s": refined.holding_m_s}
