"""Rehearsals: speeds of policies, proofs of perfect information, and gaps in three scenarios.

    python bench/rehearse.py speed
    python bench/rehearse.py scenarios --seed 0 --rehearsals 100 --worlds 30 --time-limit 20
    python bench/rehearse.py prices --worlds 4 --first-world 1000 --prices 1 1.5 2

``speed`` times rehearsals of the best-known plan of a field of the family nominal by ``follow`` and
``replan``, and bounds of perfect information, in the scenario ``dear``; wall and processor time,
after a warm-up. ``scenarios`` rehearses it by each policy in three scenarios, in the same worlds,
and bounds every policy in the first of them, or in none with ``--worlds 0``:

* ``dear``: legs cost a factor of lognormal spread 0.1;
* ``captures``: a try succeeds with a chance of 0.8, two tries, and 5 % of the targets are gone;
* ``slow``: services take a factor of spread 0.5, and one in ten 4 hours more on average.

``prices`` has the penalised bounds of the last two at several prices of time, each a multiple of
what the plan collects in a day. With ``--processor-time`` limits of planners and proofs count the
processor time of their threads, so that other work on the machine changes no result.

A mission without launches has no slips: with ``--launched`` the field is a campaign of three
launched chasers whose launches slip, in place of the nominal one.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from machine import heading

import adr_opt
from adr_opt.analysis.rehearse.bounds import Bounds, bounds
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.common.clock import count_processor_time
from adr_opt.common.constants import DAY_S
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import Chaser, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty

BEST_KNOWN = Path(__file__).parents[1] / "instances" / "best-known"

SCENARIOS = {
    "dear": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.1}}),
    "captures": Uncertainty(capture={"success": 0.8, "tries": 2}, gone=0.05),
    "slow": Uncertainty(
        service_s={"factor": {"lognormal_sigma": 0.5}, "added": {"chance": 0.1, "mean_s": 14400.0}},
        launches={"slip_s": {"mean_s": 43200.0}},
    ),
}

PRICED = ("captures", "slow")
"""Scenarios in which penalties price time."""

POLICIES = ("follow", "skip", "replan", "beam", "learned")

Made = TypeVar("Made")


def field(seed: int, *, launched: bool) -> tuple[Instance, Plan]:
    """A field with its best-known plan, or a campaign with one of "auto"."""
    instance = adr_opt.generate("nominal", seed)
    if not launched:
        return instance, adr_opt.load_plan(BEST_KNOWN / f"nominal-{seed:03d}.json")
    chasers = tuple(
        Chaser(name=f"chaser-{number}", start="anywhere", tank=Tank(delta_v_m_s=2500.0))
        for number in (1, 2, 3)
    )
    mission = instance.mission.replace(launch_separation_s=86400.0)
    instance = instance.replace(
        name=f"launched-{seed:03d}", stations=(), chasers=chasers, mission=mission
    )
    plan = adr_opt.solve(instance, "auto", time_limit=30.0).plan
    assert plan is not None
    return instance, plan


def timed(call: Callable[[], Made]) -> tuple[Made, float, float]:
    """What a call gives, its wall time and its processor time in this process [s]."""
    began, cpu_began = time.perf_counter(), time.process_time()
    made = call()
    return made, time.perf_counter() - began, time.process_time() - cpu_began


def speed(arguments: argparse.Namespace) -> None:
    """Times of rehearsals and proofs."""
    instance, plan = field(arguments.seed, launched=False)
    dear = SCENARIOS["dear"]
    print("| what | number | wall | processor | of them |")
    print("|---|---|---|---|---|")
    for policy, number in (("follow", arguments.follow), ("replan", arguments.replan)):
        rehearse(instance, plan, dear, policy=policy, samples=1)

        def run(policy: str = policy, number: int = number) -> object:
            return rehearse(instance, plan, dear, policy=policy, samples=number)

        _, wall, used = timed(run)
        print(f"| `{policy}` | {number} | {wall:.1f} s | {used:.1f} s | |", flush=True)
    found, wall, used = timed(
        lambda: bounds(
            instance,
            dear,
            samples=arguments.proofs,
            method=arguments.method,
            time_limit=arguments.time_limit,
        )
    )
    proven = sum(each.proven for each in found.worlds)
    said = f"{proven} proven, {arguments.time_limit:g} s each at most"
    print(f"| perfect information | {arguments.proofs} | {wall:.1f} s | {used:.1f} s | {said} |")


def scenarios(arguments: argparse.Namespace) -> None:
    """Gaps of each policy in each scenario."""
    instance, plan = field(arguments.seed, launched=arguments.launched)
    print(f"{instance.name}, planned prize {plan.objective:g}")
    print("| scenario | policy | rehearsals | prize | gap to perfect | gap to penalised | s each |")
    print("|---|---|---|---|---|---|---|")
    for name in arguments.scenarios:
        uncertainty = SCENARIOS[name]
        found, kinds = None, ["perfect"]
        price = arguments.prices[0] * per_day(instance, plan) if name in PRICED else 0.0
        if name in PRICED:
            kinds.append("penalised")
        if arguments.worlds:
            found = bounded(arguments, instance, uncertainty, price)
            told = found.to_dict()
            proven = f"{told['proven']} of {told['samples']} proven"
            for kind in kinds:
                said = f"{kind} bound" + (
                    f", {price:.1f} prizes a day" if kind != "perfect" else ""
                )
                print(f"| {name} | {said} | {proven} | {_mean(told[kind])} | | | |", flush=True)
        for policy in arguments.policies:
            quick = policy in ("follow", "skip")
            number = 10 * arguments.rehearsals if quick else arguments.rehearsals
            made = rehearse(
                instance,
                plan,
                uncertainty,
                policy=policy,
                samples=number,
                seed=arguments.first_world,
                jobs=1 if quick else arguments.jobs,
            )
            answer, gaps = made.to_dict(), None if found is None else found.gaps(made)
            cells = [
                name,
                f"`{policy}`",
                str(number),
                _mean(answer["prize"]),
                "" if gaps is None else _gap(gaps["perfect"]),
                "" if gaps is None or name not in PRICED else _gap(gaps["penalised"]),
                f"{made.runtime_s / number:.3f}",
            ]
            print(f"| {' | '.join(cells)} |", flush=True)


def prices(arguments: argparse.Namespace) -> None:
    """Penalised bounds at several prices of time."""
    instance, plan = field(arguments.seed, launched=arguments.launched)
    print("| scenario | price of a day | worlds | penalised bound | proven |")
    print("|---|---|---|---|---|")
    for name in PRICED:
        if name not in arguments.scenarios:
            continue
        for multiple in arguments.prices:
            price = multiple * per_day(instance, plan)
            told = bounded(arguments, instance, SCENARIOS[name], price).to_dict()
            cells = [
                name,
                f"{price:.2f}",
                str(told["samples"]),
                _mean(told["penalised"]),
                str(told["proven"]),
            ]
            print(f"| {' | '.join(cells)} |", flush=True)


def per_day(instance: Instance, plan: Plan) -> float:
    """What a plan collects in a day."""
    return plan.objective / (instance.mission.duration_s / DAY_S)


def bounded(
    arguments: argparse.Namespace, instance: Instance, uncertainty: Uncertainty, price: float
) -> Bounds:
    """Bounds with a price of time [prize per day]."""
    return bounds(
        instance,
        uncertainty,
        samples=arguments.worlds,
        seed=arguments.first_world,
        method=arguments.method,
        time_limit=arguments.time_limit,
        time_price=price,
        jobs=arguments.jobs,
    )


def _mean(found: dict[str, Any]) -> str:
    error = found["standard_error"]
    return f"{found['mean']:.2f}" + ("" if error is None else f" ± {error:.2f}")


def _gap(found: dict[str, Any]) -> str:
    if found["low"] is None:
        return "" if found["gap"] is None else f"{found['gap']:.1%}"
    return f"{found['gap']:.1%} ({found['low']:.1%} to {found['high']:.1%})"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=["speed", "scenarios", "prices"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--follow", type=int, default=10_000)
    parser.add_argument("--replan", type=int, default=200)
    parser.add_argument("--proofs", type=int, default=100)
    parser.add_argument("--rehearsals", type=int, default=100)
    parser.add_argument("--worlds", type=int, default=30)
    parser.add_argument("--first-world", type=int, default=0)
    parser.add_argument("--prices", nargs="+", type=float, default=[1.0])
    parser.add_argument("--processor-time", action="store_true")
    parser.add_argument("--method", default="exact")
    parser.add_argument("--time-limit", type=float, default=20.0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--launched", action="store_true")
    parser.add_argument("--scenarios", nargs="+", default=list(SCENARIOS), choices=SCENARIOS)
    parser.add_argument("--policies", nargs="+", default=list(POLICIES))
    arguments = parser.parse_args()
    print(heading())
    if arguments.processor_time:
        if arguments.jobs != 1:
            parser.error("--processor-time counts that of one process: --jobs 1")
        count_processor_time()
    {"speed": speed, "scenarios": scenarios, "prices": prices}[arguments.what](arguments)


if __name__ == "__main__":
    main()
