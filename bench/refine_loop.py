"""The loop of planning and refining: plans that hold, and how many rounds they take.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/refine_loop.py

Twenty instances of eccentric orbits under J2: fields of the families with e up to 0.02, the family
of fragments, and real clouds from the folder (without it those are left out). Each is planned,
refined and planned again until it holds, with free burns and with the plan's own, and flown by
`fly` with another integrator. First and last round stand side by side, and what the corrected
connections said of the last plan beside what it flies: in total, as the mean error of a leg, and
of the legs alone between pairs of bodies that were not flown between before. With --spend-savings
connections may become cheaper, and every mission is planned at least twice.

    python bench/refine_loop.py --savings 5 --method auto --time-limit 15

Fields short of fuel, of circles under J2, with free burns: prizes without and with what legs save.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from machine import heading

import adr_opt
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.loop import Round
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli.entry import main as command_line

MOST_ECCENTRIC = 0.02
CLOUDS = (
    ("tle/celestrak_2025-02_iridium-33-debris.txt", 20, 3, 0.5),
    ("tle/celestrak_2025-02_iridium-33-debris.txt", 30, 7, 1.0),
    ("tle/celestrak_2025-02_iridium-33-debris.txt", 40, 7, 2.0),
    ("tle/celestrak_2025-02_iridium-33-debris.txt", 20, 30, 1.0),
    ("omm/celestrak_2025-04_iridium-33-debris.csv", 20, 3, 1.0),
    ("omm/celestrak_2025-04_iridium-33-debris.csv", 30, 5, 0.7),
    ("omm/celestrak_2025-04_iridium-33-debris.csv", 40, 10, 1.5),
    ("omm/celestrak_2025-04_iridium-33-debris.csv", 25, 20, 1.0),
)
"""File, targets, days, and the tank in km/s."""


def eccentric(instance: Instance, seed: int) -> Instance:
    """The same field under J2, its targets on ellipses of any shape up to the most eccentric."""
    rng = np.random.default_rng(seed)
    targets = tuple(
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=MOST_ECCENTRIC * float(rng.random()),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            )
        )
        for target in instance.targets
    )
    return instance.replace(dynamics="j2", targets=targets, name=f"{instance.name}-eccentric")


def instances() -> Iterator[Instance]:
    """All of them."""
    for family, seeds, targets in (
        ("reduced-fuel", 4, None),
        ("nominal", 3, 25),
        ("tiny", 2, None),
    ):
        for seed in range(seeds):
            yield eccentric(adr_opt.generate(family, seed, targets=targets), seed)
    for seed in range(3):
        yield adr_opt.generate("cloud", seed).replace(dynamics="j2")
    folder = os.environ.get("ADR_OPT_EXTERNAL_DATA")
    if folder is None:
        return
    with tempfile.TemporaryDirectory() as made:
        for number, (file, targets, days, tank) in enumerate(CLOUDS):
            path = Path(made) / "cloud.json"
            arguments = ["--max-targets", targets, "--duration-days", days, "--out", path]
            command_line(["import", f"{folder}/{file}", *map(str, arguments), "--quiet"])
            instance = adr_opt.load(path).with_limits(delta_v_m_s=1e3 * tank)
            yield instance.replace(name=f"iridium-33-{number}")


class Expected:
    """Expected cost of legs by the corrected connections, and their flown cost."""

    def __init__(self) -> None:
        self.legs: list[tuple[float, float, bool]] = []
        """Expected and flown [m/s], and whether the pair is new."""

    def hear(self, last: Round) -> None:
        """Add the legs of a round."""
        for leg in last.refined.legs:
            key = leg.origin, leg.destination, leg.kind
            expected = last.corrections.corrected(*key, leg.planned_delta_v_m_s)
            new = key not in last.corrections.shares
            self.legs.append((expected, leg.flown_delta_v_m_s, new))

    def __str__(self) -> str:
        return f"{_told(self.legs)} | {_told([leg for leg in self.legs if leg[2]])}"


def _told(legs: list[tuple[float, float, bool]]) -> str:
    if not legs:
        return "none"
    expected, flown = np.array([leg[:2] for leg in legs]).T
    total, leg = expected.sum() / flown.sum() - 1.0, np.abs(expected / flown - 1.0).mean()
    return f"{len(legs)}: {total:+.1%}, {leg:.1%}"


def print_row(
    instance: Instance, freedom: str, arguments: argparse.Namespace
) -> tuple[bool, tuple[Round, ...]]:
    """Print what the loop comes to; whether the last plan holds in `fly`, and the rounds."""
    began = time.process_time()
    found = adr_opt.solve_refined(
        instance,
        arguments.method,
        freedom=freedom,
        time_limit=arguments.time_limit,
        seed=0,
        rounds=arguments.rounds,
        jobs=arguments.jobs,
        spend_savings=arguments.spend_savings,
    )
    taken = time.process_time() - began
    first, last = found.rounds[0], found.rounds[-1]
    holds = False
    outcome, objective = found.reason, float("nan")
    if found.holds and found.refined is not None and found.plan is not None:
        flight = fly_refined(instance, found.refined)
        allowed = {"delta-v"} if arguments.spend_savings else set()
        assert {one.rule for one in adr_opt.check(instance, found.plan)} <= allowed
        holds = flight.holds
        outcome = "holds" if holds else "does not hold in `fly`"
        objective = found.plan.objective
    expected = Expected()
    expected.hear(last)
    print(
        f"| {instance.name} | {freedom} | {first.objective:g} | "
        f"{first.flown_delta_v_m_s / first.planned_delta_v_m_s - 1.0:+.1%} | "
        f"{'yes' if not first.troubles else 'no'} | {len(found.rounds)} | {objective:g} | "
        f"{last.flown_delta_v_m_s / last.planned_delta_v_m_s - 1.0:+.1%} | {expected} | "
        f"{outcome} | {taken:.0f} s |",
        flush=True,
    )
    return holds, found.rounds


def print_savings(seeds: int, arguments: argparse.Namespace) -> None:
    """Print what plans collect that spend what free burns save, and what those do that do not."""
    print("\n| field | prize | spending savings | rounds | planned m/s | flown m/s | holds |")
    print("|---" * 7 + "|")
    for seed in range(seeds):
        mission = adr_opt.Mission(adr_opt.generate("reduced-fuel", seed).replace(dynamics="j2"))
        mission.timetable  # noqa: B018 - so that both plan with all targets
        found = []
        for spend in (False, True):
            found.append(
                adr_opt.solve_refined(
                    mission,
                    arguments.method,
                    freedom="free",
                    time_limit=arguments.time_limit,
                    seed=0,
                    rounds=arguments.rounds,
                    jobs=arguments.jobs,
                    spend_savings=spend,
                )
            )
        plain, spent = found
        assert plain.plan is not None
        assert spent.plan is not None
        assert spent.refined is not None
        holds = fly_refined(mission.instance, spent.refined).holds
        print(
            f"| {mission.instance.name} | {plain.plan.objective:g} | {spent.plan.objective:g} | "
            f"{len(spent.rounds)} | {spent.refined.planned_delta_v_m_s:.0f} | "
            f"{spent.refined.flown_delta_v_m_s:.0f} | {'yes' if holds else 'no'} |",
            flush=True,
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method", default="greedy-guarded")
    parser.add_argument("--time-limit", type=float, default=30.0, help="of each planning [s]")
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--burns", choices=("free", "planned", "both"), default="both")
    parser.add_argument("--only", default="", help="instances whose name holds this")
    parser.add_argument("--spend-savings", action="store_true")
    parser.add_argument("--savings", type=int, metavar="N", help="so many fields short of fuel")
    arguments = parser.parse_args()
    print(heading())
    if arguments.savings is not None:
        print_savings(arguments.savings, arguments)
        return
    print(
        "\n| instance | burns | prize, first | flown against planned | holds at once | rounds | "
        "prize | flown against planned, last | expected against flown, legs: total, a leg | "
        "of new pairs | outcome | processor time |"
    )
    print("|---" * 12 + "|")
    burns = ("free", "planned") if arguments.burns == "both" else (arguments.burns,)
    counts = {one: np.zeros(3, dtype=int) for one in burns}
    expected = {one: {False: Expected(), True: Expected()} for one in burns}
    for instance in instances():
        if arguments.only in instance.name:
            for one in burns:
                holds, rounds = print_row(instance, one, arguments)
                counts[one] += (1, not rounds[0].troubles, holds)
                expected[one][len(rounds) > 1].hear(rounds[-1])
    for one, (every, at_once, held) in counts.items():
        print(f"\n{one} burns: {held} of {every} end with a plan that holds, {at_once} at once")
        for again, legs in expected[one].items():
            rounds_taken = "more rounds" if again else "one round"
            print(f"expected against flown, legs, and of new pairs, {rounds_taken}: {legs}")


if __name__ == "__main__":
    main()
