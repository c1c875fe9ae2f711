"""Robust plans: what a confidence costs, and how often plans are kept when they are followed.

    python bench/robust.py --count 5 --time-limit 60
    python bench/robust.py --charges 5000
    python bench/robust.py --family campaign --count 3 --time-limit 120 --scenarios mixed

Each field is planned as it is, by the best-known plan or by "auto", and with a confidence of 0.95
in each scenario; both plans are followed in the same worlds, which planning does not know:

* ``dear``: legs cost a factor of lognormal spread 0.05; ``dearer``: of 0.1;
* ``mixed``: of 0.05, and services take a factor of spread 0.2;
* ``captures``: of 0.05, and a try succeeds with a chance of 0.8, two tries.

With ``--charges`` tanks of drawn legs are filled until they are just kept, and the table says how
much of them the charges on their legs take (docs/model.md section 13.4).

``prize`` is what going to the targets is worth on average, a target without captures its prize.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from pathlib import Path

import numpy as np
from machine import heading

import adr_opt
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.rehearse.tries import TryWorths
from adr_opt.analysis.robust.robust import robust
from adr_opt.legs.corrections import Moments, RiskCharge
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty

BEST_KNOWN = Path(__file__).parents[1] / "instances" / "best-known"

SCENARIOS = {
    "dear": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.05}}),
    "dearer": Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": 0.1}}),
    "mixed": Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.05}},
        service_s={"factor": {"lognormal_sigma": 0.2}},
    ),
    "captures": Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.05}}, capture={"success": 0.8, "tries": 2}
    ),
}


def plain(family: str, instance: Instance, seed: int, limit_s: float) -> Plan:
    """The best-known plan of a field, or one of "auto"."""
    path = BEST_KNOWN / f"{family}-{seed:03d}.json"
    if path.exists():
        return adr_opt.load_plan(path)
    plan = adr_opt.solve(instance, time_limit=limit_s).plan
    assert plan is not None
    return plan


def kept(instance: Instance, plan: Plan, uncertainty: Uncertainty, samples: int) -> float:
    """Share of rehearsals in which nothing is lost but to captures."""
    made = rehearse(instance, plan, uncertainty, samples=samples)
    return float(made.to_dict()["as_planned"]["share"])


def worth(instance: Instance, plan: Plan, uncertainty: Uncertainty) -> float:
    """What going to the targets of a plan is worth on average."""
    worths, number = TryWorths(instance, uncertainty), {n: i for i, n in enumerate(instance.names)}
    targets = {target.name for target in instance.targets}
    return math.fsum(worths.most(number[name]) for name in plan.destinations if name in targets)


def charges(count: int) -> None:
    """Print what charges take of drawn tanks that are just kept."""
    rng, taken = np.random.default_rng(0), []
    while len(taken) < count:
        legs, score = int(rng.integers(1, 20)), float(rng.uniform(0.0, 3.5))
        mean, sigma = np.exp(rng.uniform(-0.1, 0.1, legs)), rng.uniform(0.0, 0.3, legs)
        size = rng.exponential(1.0, legs) ** rng.uniform(0.3, 2.0)
        # Without a share that can be used, what a tank has to hold grows with its legs.
        full = float((mean * size).sum() + score * np.sqrt(((sigma * size) ** 2).sum()))
        factors = {
            (str(leg), "short"): Moments(float(mean[leg]), float(sigma[leg])) for leg in range(legs)
        }
        charge = RiskCharge(score, full, factors=factors)
        total = sum(float(charge.charged(str(leg), "short", size[leg])) for leg in range(legs))
        taken.append(total / full)
    print("| tanks | 5 % take less than | half take less than | most |")
    print("|---|---|---|---|")
    low, middle = np.quantile(taken, [0.05, 0.5])
    print(f"| {count} | {low:.1%} | {middle:.1%} | {max(taken):.4%} |")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--family", default="nominal")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=5)
    parser.add_argument("--confidence", type=float, default=0.95)
    parser.add_argument("--time-limit", type=float, default=60.0)
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--method", default="auto")
    parser.add_argument("--scenarios", nargs="+", default=list(SCENARIOS), choices=SCENARIOS)
    parser.add_argument("--charges", type=int, metavar="N", help="of N drawn tanks alone")
    asked = parser.parse_args()
    print(heading())
    if asked.charges:
        charges(asked.charges)
        return
    print("| field | scenario | plain: prize | kept | robust: prize | bound | kept | s |")
    print("|---|---|---|---|---|---|---|---|")
    rows: dict[str, list[tuple[float, float]]] = {}
    for seed in range(asked.first, asked.first + asked.count):
        instance = adr_opt.generate(asked.family, seed)
        known = plain(asked.family, instance, seed, asked.time_limit)
        for name in asked.scenarios:
            uncertainty, began = SCENARIOS[name], time.monotonic()
            made = robust(
                instance, uncertainty, asked.confidence, asked.method, time_limit=asked.time_limit
            )
            took_s = time.monotonic() - began
            without = worth(instance, known, uncertainty)
            before = kept(instance, known, uncertainty, asked.samples)
            row = f"| {instance.name} | {name} | {without:.2f} | {before:.1%} | "
            if made.plan is None:
                print(f"{row}none | {made.upper_bound:.2f} | | {took_s:.0f} |", flush=True)
                continue
            share = kept(instance, made.plan, uncertainty, asked.samples)
            collects = worth(instance, made.plan, uncertainty)
            scale = collects / made.worth if made.worth > 0.0 else 1.0
            print(
                f"{row}{collects:.2f} | {made.upper_bound * scale:.2f} | {share:.1%} | "
                f"{took_s:.0f} |",
                flush=True,
            )
            rows.setdefault(name, []).append((without - collects, share))
    for name, found in rows.items():
        print(
            f"\n{name}: {statistics.mean(loss for loss, _ in found):.2f} less in the mean, "
            f"{max(loss for loss, _ in found):.2f} at most; kept in "
            f"{min(share for _, share in found):.1%} at least, "
            f"{statistics.mean(share for _, share in found):.1%} in the mean"
        )


if __name__ == "__main__":
    main()
