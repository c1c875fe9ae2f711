"""Rehearsals: policies in uncertain worlds, plans with a confidence, replanning.

python bench/rehearsals.py speed
python bench/rehearsals.py scenarios --rehearsals 100 --worlds 30 --limit 20
python bench/rehearsals.py robust --count 5 --limit 60
python bench/rehearsals.py campaign CATALOGUE --limit 60 --replanned 20 --worlds 5
python bench/rehearsals.py replan --seeds 0 1 2 --days 2 3 4
python bench/rehearsals.py paired --fields 3 --worlds 10
python bench/rehearsals.py expected --fields 1 --targets 12 --limit 3 --worlds 3 --bound-limit 3
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np
from fields import best_plan, imported
from tables import experiment, head, row, timed

import adr_opt
from adr_opt.analysis import replan as replanned_by
from adr_opt.analysis.rehearse.bounds import bounds
from adr_opt.analysis.rehearse.rehearsals import Rehearsals
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.rehearse.tries import TryWorths
from adr_opt.analysis.robust.expected import expected as expected_plan
from adr_opt.analysis.robust.robust import robust as robust_plan
from adr_opt.common.clock import count_processor_time
from adr_opt.common.constants import DAY_S
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import InOrbit, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import KeepOutZone
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.ui.report.plain import write_page
from adr_opt.ui.report.rehearsed import rehearsed_page

SCENARIOS = {
    "dear": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.1}}),
    "captures": Uncertainty(capture={"success": 0.8, "tries": 2}, gone=0.05),
    "slow": Uncertainty(
        service_s={"factor": {"lognormal_sigma": 0.5}, "added": {"chance": 0.1, "mean_s": 14400.0}},
        launches={"slip_s": {"mean_s": 43200.0}},
    ),
}

PRICED = ("captures", "slow")
"""Scenarios in which penalties price time, at what the plan collects in a day."""


def speed(
    seed: int = 0,
    follow: int = 10_000,
    replan: int = 200,
    proofs: int = 100,
    processor_time: bool = False,
    method: str = "exact",
    limit: float = 20.0,
) -> None:
    """Times of rehearsals of the best-known plan of a nominal field, and of proofs, in ``dear``.

    With ``--processor-time``, here and below, limits of planners and proofs count the processor
    time of their threads, so that other work on the machine changes no result.
    """
    if processor_time:
        count_processor_time()
    instance, plan = adr_opt.generate("nominal", seed), best_plan(f"nominal-{seed:03d}")
    dear = SCENARIOS["dear"]
    head("what", "number", "wall", "processor", "of them")
    for policy, number in (("follow", follow), ("replan", replan)):
        rehearse(instance, plan, dear, policy=policy, samples=1)
        _, wall, used = timed(
            lambda: rehearse(instance, plan, dear, policy=policy, samples=number)  # noqa: B023
        )
        row(f"`{policy}`", number, f"{wall:.1f} s", f"{used:.1f} s", "")
    found, wall, used = timed(
        lambda: bounds(instance, dear, samples=proofs, method=method, time_limit=limit)
    )
    said = f"{sum(each.proven for each in found.worlds)} proven, {limit:g} s each at most"
    row("perfect information", proofs, f"{wall:.1f} s", f"{used:.1f} s", said)


def scenarios(
    seed: int = 0,
    rehearsals: int = 100,
    worlds: int = 30,
    first_world: int = 0,
    processor_time: bool = False,
    method: str = "exact",
    limit: float = 20.0,
    scenarios: tuple[str, ...] = tuple(SCENARIOS),
    policies: tuple[str, ...] = ("follow", "skip", "replan", "beam", "learned"),
) -> None:
    """Gaps of each policy in each scenario, in the same worlds, to bounds on every policy.

    ``dear``: legs cost a factor of lognormal spread 0.1; ``captures``: a try succeeds with a chance
    of 0.8, two tries, and 5 % of the targets are gone; ``slow``: services take a factor of spread
    0.5, and one in ten 4 hours more on average. No bounds with ``--worlds 0``.
    """
    if processor_time:
        count_processor_time()
    instance, plan = adr_opt.generate("nominal", seed), best_plan(f"nominal-{seed:03d}")
    print(f"{instance.name}, planned prize {plan.objective:g}")
    head(
        *("scenario", "policy", "rehearsals", "prize", "gap to perfect", "gap to penalised"),
        "s each",
    )
    for name in scenarios:
        found, priced = None, name in PRICED
        price = plan.objective / (instance.mission.duration_s / DAY_S) if priced else 0.0
        if worlds:
            found = bounds(
                instance,
                SCENARIOS[name],
                samples=worlds,
                seed=first_world,
                method=method,
                time_limit=limit,
                time_price=price,
            )
            told = found.to_dict()
            proven = f"{told['proven']} of {told['samples']} proven"
            row(name, "perfect bound", proven, _mean(told["perfect"]), *[""] * 3)
            if priced:
                said = f"penalised bound, {price:.1f} prizes a day"
                row(name, said, proven, _mean(told["penalised"]), *[""] * 3)
        for policy in policies:
            number = 10 * rehearsals if policy in ("follow", "skip") else rehearsals
            made = rehearse(
                instance, plan, SCENARIOS[name], policy=policy, samples=number, seed=first_world
            )
            gaps = {} if found is None else found.gaps(made)
            row(
                name,
                f"`{policy}`",
                number,
                _mean(made.to_dict()["prize"]),
                _gap(gaps.get("perfect")),
                _gap(gaps.get("penalised") if priced else None),
                f"{made.runtime_s / number:.3f}",
            )


def _mean(found: dict[str, Any]) -> str:
    error = found["standard_error"]
    return f"{found['mean']:.2f}" + ("" if error is None else f" ± {error:.2f}")


def _gap(found: dict[str, Any] | None) -> str:
    if found is None or found["gap"] is None:
        return ""
    ends = "" if found["low"] is None else f" ({found['low']:.1%} to {found['high']:.1%})"
    return f"{found['gap']:.1%}{ends}"


_DEAR = {"delta_v_factor": {"lognormal_sigma": 0.05}}
_SLOW = {"factor": {"lognormal_sigma": 0.2}}

CONFIDENT = {
    "dear": Uncertainty(legs=_DEAR),
    "dearer": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.1}}),
    "mixed": Uncertainty(legs=_DEAR, service_s=_SLOW),
    "captures": Uncertainty(legs=_DEAR, capture={"success": 0.8, "tries": 2}),
}
"""Scenarios of plans with a confidence."""


def robust(
    family: str = "nominal",
    count: int = 5,
    confidence: float = 0.95,
    limit: float = 60.0,
    samples: int = 2000,
    scenarios: tuple[str, ...] = tuple(CONFIDENT),
) -> None:
    """What a confidence costs, and how often plans are kept when they are followed.

    Each field is planned as it is, by the best-known plan or by ``auto``, and with a confidence in
    each scenario; both plans are followed in the same worlds, which planning does not know:
    ``dear``: legs cost a factor of lognormal spread 0.05; ``dearer``: of 0.1; ``mixed``: of 0.05,
    and services take a factor of spread 0.2; ``captures``: of 0.05, and a try succeeds with a
    chance of 0.8, two tries. *Prize* is what going to the targets is worth on average, a target
    without captures its prize.
    """
    head("field", "scenario", "plain: prize", "kept", "robust: prize", "bound", "kept", "s")
    rows: dict[str, list[tuple[float, float]]] = {}
    for seed in range(count):
        instance = adr_opt.generate(family, seed)
        known = best_plan(f"{family}-{seed:03d}", limit)
        for name in scenarios:
            world = CONFIDENT[name]
            made, took_s, _ = timed(
                lambda: robust_plan(instance, world, confidence, "auto", time_limit=limit)  # noqa: B023
            )
            without = worth(instance, known, world)
            before = kept(instance, known, world, samples)
            cells = ["none", f"{made.upper_bound:.2f}", ""]
            if made.plan is not None:
                share, collects = (
                    kept(instance, made.plan, world, samples),
                    worth(instance, made.plan, world),
                )
                scale = collects / made.worth if made.worth > 0.0 else 1.0
                cells = [f"{collects:.2f}", f"{made.upper_bound * scale:.2f}", f"{share:.1%}"]
                rows.setdefault(name, []).append((without - collects, share))
            plain = f"{without:.2f}", f"{before:.1%}"
            row(instance.name, name, *plain, *cells, f"{took_s:.0f}")
    for name, found in rows.items():
        losses, shares = zip(*found, strict=True)
        print(
            f"\n{name}: {mean(losses):.2f} less in the mean, {max(losses):.2f} at most; kept in "
            f"{min(shares):.1%} at least, {mean(shares):.1%} in the mean"
        )


def kept(instance: Instance, plan: Plan, uncertainty: Uncertainty, samples: int) -> float:
    """Share of rehearsals in which nothing is lost but to captures."""
    made = rehearse(instance, plan, uncertainty, samples=samples)
    return float(made.to_dict()["as_planned"]["share"])


def worth(instance: Instance, plan: Plan, uncertainty: Uncertainty) -> float:
    """What going to the targets of a plan is worth on average."""
    worths, number = TryWorths(instance, uncertainty), {n: i for i, n in enumerate(instance.names)}
    targets = {target.name for target in instance.targets}
    return math.fsum(worths.most(number[name]) for name in plan.destinations if name in targets)


def campaign(
    catalogue: Path,
    limit: float = 60.0,
    followed: int = 2000,
    replanned: int = 20,
    worlds: int = 5,
    bound_limit: float = 20.0,
    out: str | None = None,
) -> None:
    """A campaign on a real catalogue, planned plainly and with a confidence, and rehearsed.

    Three chasers are launched three days apart among the 40 objects of the densest plane, each with
    1,000 m/s, for two weeks. Legs cost a factor of lognormal spread 0.05, services take one of 0.2,
    a capture succeeds with a chance of 0.9, two tries. Both plans are followed, and replanned when
    something goes otherwise; the gap is that to the bound on every policy of which penalties have
    taken out the luck of captures. With ``--out`` the rehearsals of the robust plan are written as
    a page.
    """
    crew = "--launches 3 --launch-every 3 --delta-v 1000 --no-refuelling --dynamics j2"
    instance = imported(catalogue, f"--max-targets 40 --duration-days 14 {crew}")
    world = Uncertainty(legs=_DEAR, service_s=_SLOW, capture={"success": 0.9, "tries": 2})
    plain = adr_opt.solve(instance, time_limit=limit).plan
    made = robust_plan(instance, world, 0.95, time_limit=limit)
    for note in made.notes:
        print(f"robust: {note}")
    bounded = bounds(instance, world, samples=worlds, time_limit=bound_limit)
    head("plan", "policy", "rehearsals", "planned", "prize", "as planned", "gap")
    lost = []
    plans = {"plain": plain, "robust": made.plan}
    for name, plan in ((name, plan) for name, plan in plans.items() if plan is not None):
        for policy, samples in (("follow", followed), ("replan", replanned)):
            flown = rehearse(instance, plan, world, policy=policy, samples=samples)
            told, gaps = flown.to_dict(), bounded.gaps(flown)
            gap = gaps.get("penalised", gaps["perfect"])["gap"]
            shares = f"{told['as_planned']['share']:.1%}", f"{gap:.1%}"
            prizes = f"{plan.objective:g}", _mean(told["expected_prize"])
            row(name, f"`{policy}`", samples, *prizes, *shares)
            most = Counter(told["losses"]).most_common(4)
            said = ", ".join(f"{reason} {number:.2f}" for reason, number in most)
            lost.append(f"{name}, {policy}: {said or 'nothing'}")
            if out and (name, policy) == ("robust", "follow"):
                write_page(out, rehearsed_page(flown, told))
    print("\nLost on average, by reason:", *lost, sep="\n")


def replan(
    seeds: tuple[int, ...] = (0, 1, 2, 3),
    days: tuple[float, ...] = (2.0, 3.0, 4.0),
    limit: float = 20.0,
) -> None:
    """From a new zone to a new plan: how long it takes, and what it collects.

    For each nominal field and each day on which a zone of ten kilometres falls in, for a day, an
    hour after it is known: the rest of the best-known plan is planned anew, timetable included,
    after a warm-up; times are the least of three runs. Beside it stand the rest by ``auto``, which
    tells what is still possible, and the whole mission by ``auto`` with the zone known from the
    start.
    """
    for method in ("beam", "auto"):
        adr_opt.solve(adr_opt.generate("tiny", 0), method, time_limit=5.0)
    head(
        *("field", "day", "wall", "processor", "collected", "by `auto`", "its rest"),
        *("without zone", "known from the start", "its bound"),
    )
    for seed, day in ((seed, day) for seed in seeds for day in days):
        instance, plan = adr_opt.generate("nominal", seed), best_plan(f"nominal-{seed:03d}")
        at_s = day * DAY_S
        zone = KeepOutZone(
            min_altitude_m=740e3, max_altitude_m=750e3, start_s=at_s + 3600.0, end_s=at_s + DAY_S
        )
        runs = [
            timed(lambda: replanned_by(instance, plan, at_s, zones=[zone]))  # noqa: B023
            for _ in range(3)
        ]
        made = runs[0][0]
        targets = {target.name for target in instance.targets}
        flown = sum(leg.destination in targets for state in made.states for leg in state.legs)
        best = replanned_by(instance, plan, at_s, zones=[zone], method="auto", time_limit=limit)
        known = adr_opt.solve(instance.replace(keep_out_zones=(zone,)), "auto", time_limit=limit)
        row(
            instance.name,
            f"{day:g}",
            *(f"{min(run[at] for run in runs):.2f} s" for at in (1, 2)),
            f"{flown + made.prize_after:g}",
            f"{flown + best.prize_after:g}",
            best.result.status,
            *(f"{each:g}" for each in (plan.objective, known.objective, known.upper_bound)),
        )


PAIRED = {
    "captures": Uncertainty(capture={"success": 0.8, "tries": 2}),
    "dear": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.2}}),
    "both": Uncertainty(
        capture={"success": 0.8, "tries": 2}, legs={"delta_v_factor": {"lognormal_sigma": 0.2}}
    ),
}
"""Scenarios in which replanning is compared with following."""


def drawn(family: str, seed: int, targets: int) -> Instance:
    """A field of a family; ``one-tank`` is ``reduced-time`` without its station, with 600 m/s."""
    if family != "one-tank":
        return adr_opt.generate(family, seed, targets=targets)
    made = adr_opt.generate("reduced-time", seed, targets=targets)
    start = InOrbit(orbit=made.stations[0].orbit)
    chaser = made.chaser.replace(start=start, end="anywhere", tank=Tank(delta_v_m_s=600.0))
    return made.replace(stations=(), chasers=(chaser,))


def paired(
    families: tuple[str, ...] = ("nominal", "reduced-time", "reduced-fuel", "one-tank"),
    scenarios: tuple[str, ...] = tuple(PAIRED),
    policy: str = "replan",
    targets: int = 50,
    fields: int = 3,
    first_field: int = 500,
    worlds: int = 10,
    first_world: int = 0,
    limit: float = 10.0,
) -> None:
    """What a policy collects beyond ``follow``, in the same worlds, from the same plan of ``auto``.

    ``captures``: a try succeeds with a chance of 0.8, two tries; ``dear``: legs cost a factor of
    lognormal spread 0.2; ``both``. Prizes are without the luck of captures; *p* is that of a paired
    test, two-sided, by the normal distribution. Limits count processor time.
    """
    count_processor_time()
    head("family", "scenario", "rehearsals", "`follow`", f"`{policy}`", "more", "p", "s each")
    plans = {
        (family, seed): (instance, adr_opt.solve(instance, time_limit=limit).plan)
        for family in families
        for seed in range(first_field, first_field + fields)
        for instance in (drawn(family, seed, targets),)
    }
    means = list[float]()
    for family, name in ((family, name) for family in families for name in scenarios):
        found: dict[str, list[float]] = {"follow": [], policy: []}
        took_s = 0.0
        for seed in range(first_field, first_field + fields):
            instance, plan = plans[family, seed]
            assert plan is not None
            for each, prizes in found.items():
                flown = rehearse(
                    instance,
                    plan,
                    PAIRED[name],
                    policy=each,
                    samples=worlds,
                    seed=first_world + 1000 * seed,
                )
                prizes += [outcome.expected for outcome in flown.outcomes]
                took_s += flown.runtime_s * (each == policy)
        more = np.array(found[policy]) - np.array(found["follow"])
        error = float(more.std(ddof=1)) / math.sqrt(more.size)
        p = math.erfc(abs(float(more.mean())) / error / math.sqrt(2.0)) if error > 0.0 else 1.0
        row(
            *(family, name, more.size),
            *(f"{mean(prizes):.2f}" for prizes in found.values()),
            f"{more.mean():+.2f} ± {error:.2f}",
            f"{p:.2g}",
            f"{took_s / more.size:.2f}",
        )
        means.append(float(more.mean()))
    print(f"\n{mean(means):+.3f} in the mean of {len(means)} settings, {min(means):+.3f} at worst")


def expected(
    scenarios: tuple[str, ...] = ("captures", "slow"),
    targets: int = 50,
    fields: int = 3,
    first_field: int = 600,
    limit: float = 60.0,
    followed: int = 500,
    replanned: int = 10,
    worlds: int = 5,
    bound_limit: float = 30.0,
    confidence: float = 0.9,
) -> None:
    """Plans for the expected prize beside plain ones and those with a confidence, in new worlds.

    Nominal fields in scenarios of ``scenarios``. The gap is that of the plan replanned to the
    penalised bound on every policy, of which penalties price time at what the plain plan collects
    in a day. Limits count processor time.
    """
    count_processor_time()
    head(
        *("field", "scenario", "plain, followed", f"kept with {confidence:g}", "expected, stated"),
        *("followed", "replanned", "bound", "gap followed", "gap replanned"),
    )
    for seed, name in (
        (seed, name) for seed in range(first_field, first_field + fields) for name in scenarios
    ):
        instance, world = adr_opt.generate("nominal", seed, targets=targets), SCENARIOS[name]
        plain = adr_opt.solve(instance, time_limit=limit).plan
        kept_plan = robust_plan(instance, world, confidence, time_limit=limit).plan
        made = expected_plan(instance, world, time_limit=limit).plan
        assert plain is not None
        assert made is not None
        assert made.expected is not None

        def flown(plan: Plan, policy: str, samples: int) -> Rehearsals:
            return rehearse(instance, plan, world, policy=policy, samples=samples)  # noqa: B023

        runs = [flown(made, "follow", followed), flown(made, "replan", replanned)]
        price = plain.objective / (instance.mission.duration_s / DAY_S)
        bounded = bounds(
            instance,
            world,
            samples=worlds,
            method="lagrangian",
            time_limit=bound_limit,
            time_price=price,
        )
        told = [_mean(run.to_dict()["expected_prize"]) for run in runs]
        others = [
            "none"
            if plan is None
            else _mean(flown(plan, "follow", followed).to_dict()["expected_prize"])
            for plan in (plain, kept_plan)
        ]
        row(
            *(instance.name, name, *others, f"{made.expected.prize:.2f}", *told),
            _mean(bounded.to_dict()["penalised"]),
            *(_gap(bounded.gaps(run).get("penalised")) for run in runs),
        )


if __name__ == "__main__":
    sys.exit(experiment(__doc__, speed, scenarios, robust, campaign, replan, paired, expected))
