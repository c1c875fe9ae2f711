"""Additional options and output of ``solve --refine``."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ...common.errors import InputError
from ...common.stop import Stop
from ...common.wording import counted
from . import take
from .output import emit, emit_json, say
from .refine import ephemerides_option, freedom_option, gravity_option

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...plan.refined_plan import Freedom, Gravity, RefinedPlan
    from ...problem.instance import Instance
    from ...run.run_options import RunOptions
    from .work import Watch


class Refining(NamedTuple):
    """Options of ``solve`` on refinement; None if not given."""

    refine: bool
    refined_out: str | None
    gravity: Gravity | None
    freedom: Freedom | None
    ephemerides: bool
    rounds: int | None
    spend_savings: bool

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
        ):
            if value is not None and not self.refine:
                raise InputError(f"{f'{name} {value}'.strip()}: nothing is refined; add --refine")
        check_out(self.refined_out, instance_path, results=(out,))


refine_options = take.together(
    take.flag("--refine", "Refine the plan, and replan until it holds in true dynamics."),
    take.file("--refined-out", "Refined plan file to write."),
    gravity_option,
    freedom_option,
    ephemerides_option,
    take.count("--rounds", "N", "Maximum number of plans with --refine; default 10."),
    take.flag(
        "--spend-savings", "With --refine, spend ΔV saved in flight; 'check' may refuse the plan."
    ),
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
            f"{flown:.1f} m/s{_holding(refined)}, after {counted(len(looped.rounds), 'round')}"
        )
    else:
        emit(f"the plan does not hold: {looped.reason}")


def _holding(refined: RefinedPlan | None) -> str:
    """Estimated ΔV of holding, where there are ephemerides."""
    if refined is None or refined.ephemerides is None:
        return ""
    return f" and {refined.holding_m_s:.1f} m/s of holding beside ephemerides"


def _told_holding(refined: RefinedPlan | None) -> dict[str, float]:
    """The same as plain data."""
    if refined is None or refined.ephemerides is None:
        return {}
    return {"holding_delta_v_m_s": refined.holding_m_s}
