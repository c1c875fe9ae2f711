"""Quality against time: the learned policy, guarded greedy, beams on demand, and replanning.

    python bench/frontier.py known --targets 50 500 5000 --fields 40 24 3
    python bench/frontier.py uncertain --scenarios dear captures slow --fields 40

Fields of the family nominal with seeds from 200 on, of which none was used in training, with more
targets as told. ``known``: missions as planned. ``uncertain``: one world a field, the same for all,
in the scenarios of ``bench/rehearsals.py``, and in ``mixed``, where legs cost a factor of spread
0.1, services take one of spread 0.5, a try succeeds with a chance of 0.8 (two tries), and 5 % of
the targets are gone. Greedy and beams are asked anew for every leg there, and keep the same reserve
in their tanks as the learned policy does. "Cheapest leg, same guard" is the learned policy with the
cost of a leg in place of the network. Policies "with a plan" begin with that of a beam of width 64
on the timetable, whose time counts for everything.

Times are those of the processor, in one thread: for a decision, and for everything with all tables,
from the instance to the end of the mission. A learned policy holds a point of the frontier if every
other method is either worse, by Wilcoxon's signed-rank test and by a paired t-test over the fields,
or slower, by the first; one-sided. For another method the chance is twice the smaller of the two,
for the claim the largest over all methods; and all claims that a command tests share p < 0.01 by
Holm's procedure (S. Holm, Scandinavian Journal of Statistics 6, 1979, pp. 65-70).
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from machine import heading
from next_leg.claims import chance, chance_of_mean, holds, print_claims
from next_leg.drawn import MIXED
from next_leg.rivals import AskedAnew, CheapestLegs, beam_next, guarded_next, on_demand
from rehearsals import SCENARIOS

import adr_opt
from adr_opt.analysis.rehearse.flight import MissionPolicy, Situation, rehearsed
from adr_opt.analysis.rehearse.intended import Intended, intended
from adr_opt.analysis.rehearse.learned import Learned, usual_reserve
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.analysis.rehearse.visible_legs import RANKS as LEARNED_RANKS
from adr_opt.learning.next_leg.scorer import LegScorer, load_scorer, shipped
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld
from adr_opt.run.table_budget import RANKS
from solvers.beams.beams import beam_search, usual_settings, with_time_value
from solvers.beams.greedy_order import guarded_sequence

FIRST_SEED = 200
WORLDS = {**SCENARIOS, "mixed": MIXED}
CHEAPEST = "cheapest leg, same guard"
PLAN_WIDTH = 64
"""Width of the beam that makes the plans with which policies begin that have one."""


class Run(NamedTuple):
    """What a method did in one field: prize, and times for a decision and for everything [s]."""

    prize: float
    decision_s: float
    total_s: float


class Clocked:
    """A policy whose decisions are timed."""

    def __init__(self, policy: MissionPolicy) -> None:
        self._policy = policy
        self.tries_again = policy.tries_again
        self.spent_s, self.decisions = 0.0, 0

    def next_leg(self, now: Situation) -> object:
        """The decision of the policy."""
        began = time.process_time()
        found = self._policy.next_leg(now)
        self.spent_s += time.process_time() - began
        self.decisions += 1
        return found


Maker = Callable[[MissionFacts, Uncertainty], MissionPolicy]


def flown(instance: Instance, uncertainty: Uncertainty, seed: int, made: Maker) -> Run:
    """A mission flown by a policy, from the instance on."""
    began = time.process_time()
    facts = MissionFacts(instance, cores=1)
    policy = Clocked(made(facts, uncertainty))
    world = DrawnWorld(instance, uncertainty, seed)
    done = rehearsed(facts, world, policy, (0,) * len(facts.chasers))  # type: ignore[arg-type]
    total_s = time.process_time() - began
    return Run(done.prize, policy.spent_s / max(1, policy.decisions), total_s)


def planned(instance: Instance, width: int, ranks: int) -> Run:
    """A mission planned by a beam of a width on demand; by guarded greedy for width 0."""
    began = time.process_time()
    mission = on_demand(MissionFacts(instance), ranks)
    if width:
        mission = with_time_value(mission)
    ready = time.process_time()
    if width:
        sequence = beam_search(mission, usual_settings(mission, width))[0]
    else:
        sequence = guarded_sequence(mission)
    ended = time.process_time()
    prize = float(mission.rules.prize[sequence].sum())
    return Run(prize, (ended - ready) / max(1, sequence.size), ended - began)


def learned(scorer: LegScorer | CheapestLegs) -> Maker:
    """The learned policy without a plan, or with another way to score legs."""

    def made(facts: MissionFacts, uncertainty: Uncertainty) -> MissionPolicy:
        nothing = Intended(None, ((),) * len(facts.chasers), (0,) * len(facts.chasers))
        return Learned(facts, nothing, uncertainty, 0, scorer)  # type: ignore[arg-type]

    return made


_plans: dict[str, tuple[Plan, float]] = {}
"""Plans that policies begin with, and what they took [s], by name of the instance."""


def with_plan(policy: str, uncertainty: Uncertainty) -> Callable[[Instance, int], Run]:
    """A policy that begins with the plan of a beam, whose time counts for everything."""

    def run(instance: Instance, seed: int) -> Run:
        if instance.name not in _plans:
            began = time.process_time()
            plan = adr_opt.solve(instance, "beam", width=PLAN_WIDTH, time_limit=math.inf).plan
            assert plan is not None
            _plans[instance.name] = plan, time.process_time() - began
        plan, took_s = _plans[instance.name]

        def made(facts: MissionFacts, uncertainty: Uncertainty) -> MissionPolicy:
            begun = intended(facts, plan)
            if policy == CHEAPEST:
                return Learned(facts, begun, uncertainty, 0, CheapestLegs())  # type: ignore[arg-type]
            return policy_of(policy)(facts, begun, uncertainty, 0)

        done = flown(instance, uncertainty, seed, made)
        return done._replace(total_s=done.total_s + took_s)

    return run


def asked_anew(width: int, ranks: int) -> Maker:
    """Guarded greedy or a beam, asked for every leg."""

    def made(facts: MissionFacts, uncertainty: Uncertainty) -> MissionPolicy:
        chooser = beam_next(width) if width else guarded_next
        factor = uncertainty.legs.delta_v_factor
        reserve = usual_reserve(0.0 if factor is None else factor.lognormal_sigma)
        return AskedAnew(facts, on_demand(facts, ranks), chooser, reserve)

    return made


def methods(
    arguments: argparse.Namespace, uncertainty: Uncertainty
) -> dict[str, Callable[[Instance, int], Run]]:
    """The methods by name, each a function of an instance and the seed of a world."""
    known = arguments.what == "known"
    scorer = shipped() if arguments.weights is None else load_scorer(arguments.weights)
    makers = {"learned": learned(scorer), CHEAPEST: learned(CheapestLegs())}
    found: dict[str, Callable[[Instance, int], Run]] = {}
    for name, maker in makers.items():

        def run(instance: Instance, seed: int, maker: Maker = maker) -> Run:
            return flown(instance, uncertainty, seed, maker)

        found[name] = run
    for width, ranks in product((0, *arguments.widths), arguments.ranks):
        name = f"beam of {width}" if width else "guarded greedy"
        if ranks < RANKS and max(arguments.targets) <= ranks:
            continue  # all of them
        if ranks < RANKS:
            name += f", nearest {ranks}"

        def asked(instance: Instance, seed: int, width: int = width, ranks: int = ranks) -> Run:
            if known:
                return planned(instance, width, ranks)
            return flown(instance, uncertainty, seed, asked_anew(width, ranks))

        found[name] = asked
    if not known:
        for name in (
            "learned",
            CHEAPEST,
            "follow",
            "skip",
            *(["replan"] if arguments.replans else []),
        ):
            found[f"{name} with a plan"] = with_plan(name, uncertainty)
    return found


def table(runs: dict[str, list[Run]]) -> dict[str, float]:
    """Print the rows of a size; chances of the claims that a learned policy holds a point."""
    for name, made in runs.items():
        each = np.array(made)
        prize = f"{each[:, 0].mean():.2f}"
        if len(each) > 1:
            prize += f" ± {1.96 * each[:, 0].std(ddof=1) / math.sqrt(len(each)):.2f}"
        cells = [
            name,
            str(len(each)),
            prize,
            f"{1e3 * np.median(each[:, 1]):.3g} ms",
            f"{1e3 * np.median(each[:, 2]):.3g} ms",
        ]
        print(f"| {' | '.join(cells)} |", flush=True)
    claims = dict[str, float]()
    for own in [name for name in runs if name.startswith("learned")]:
        print(f"\n| {own} against | p better | by mean | p quicker a decision | p quicker in all |")
        print("|---|---|---|---|---|")
        decisions, everything = list[float](), list[float]()
        for name, made in runs.items():
            if name.startswith("learned"):
                continue
            each, mine = np.array(made), np.array(runs[own])[: len(made)]
            decisions.append(holds(mine, each, 1))
            everything.append(holds(mine, each, 2))
            better, by_mean = (test(mine[:, 0], each[:, 0]) for test in (chance, chance_of_mean))
            quicker, sooner = (chance(each[:, at], mine[:, at]) for at in (1, 2))
            cells = [name, *(f"{p:.2g}" for p in (better, by_mean, quicker, sooner))]
            print(f"| {' | '.join(cells)} |")
        claims[f"{own} | time per decision"] = max(decisions)
        claims[f"{own} | total time"] = max(everything)
    return claims


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=["known", "uncertain"])
    parser.add_argument("--targets", type=int, nargs="+", default=[50])
    parser.add_argument("--scenarios", nargs="+", default=list(WORLDS), choices=WORLDS)
    parser.add_argument("--fields", type=int, nargs="+", default=[40], help="for each size")
    parser.add_argument("--widths", type=int, nargs="+", default=[1, 4, 16, 64])
    parser.add_argument(
        "--ranks",
        type=int,
        nargs="+",
        default=[RANKS, LEARNED_RANKS],
        help="nearest destinations of each body for greedy and beams",
    )
    parser.add_argument("--replans", type=int, default=0, help="fields of which replan flies")
    parser.add_argument("--weights", help="weights other than those that come with the package")
    arguments = parser.parse_args()
    print(heading())
    worlds = {"known": Uncertainty()}
    if arguments.what == "uncertain":
        worlds = {name: WORLDS[name] for name in arguments.scenarios}
    fields = arguments.fields * (len(arguments.targets) if len(arguments.fields) == 1 else 1)
    sizes = list(zip(arguments.targets, fields, strict=True))
    claims = dict[str, float]()
    for (world, uncertainty), (targets, count) in product(worlds.items(), sizes):
        known = methods(arguments, uncertainty)
        for run in known.values():  # kernels are loaded before anything is timed
            run(adr_opt.generate("nominal", FIRST_SEED - 1, targets=30), 0)
        runs: dict[str, list[Run]] = {name: [] for name in known}
        for number in range(count):
            instance = adr_opt.generate("nominal", FIRST_SEED + number, targets=targets)
            for name, run in known.items():
                if name.startswith("replan") and number >= arguments.replans:
                    continue
                runs[name].append(run(instance, number))
        print(f"\n**{targets} targets, {world}**\n")
        print("| method | fields | prize | a decision | all |")
        print("|---|---|---|---|---|")
        for claim, p in table(runs).items():
            claims[f"{targets} targets, {world} | {claim}"] = p
    print_claims(claims)


if __name__ == "__main__":
    main()
