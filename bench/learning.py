"""The environment and the learned policy: steps per second, visits, and curves of training.

python bench/learning.py environment --slots 32 --runs 5 --steps 40
python bench/learning.py curve
python bench/learning.py evaluated --fields 50 --budget 16 --beams 10 30
python bench/learning.py levels --fields 30
python bench/learning.py decisions --targets 50 500 5000
python bench/learning.py flown --width 64
python bench/learning.py prior --fields 20
python bench/learning.py rivals
python bench/learning.py offline --out offline.npz
python bench/learning.py ablation --steps 131072
python bench/learning.py bounds reduced-time reduced-fuel --fields 12
"""

from __future__ import annotations

import csv
import json
import math
import re
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from statistics import fmean, median, stdev
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Discrete
from scipy.stats import t, wilcoxon
from tables import experiment, head, row

import adr_opt
import adr_opt.learning
from adr_opt.analysis.rehearse.flight import Situation, rehearsed
from adr_opt.analysis.rehearse.intended import Intended, intended
from adr_opt.analysis.rehearse.learned import Learned
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.common.files import write_text
from adr_opt.kernels.episodes import episodes as episode_kernels
from adr_opt.kernels.episodes.choices import COST, SAFE
from adr_opt.kernels.episodes.episodes import Episodes, StackedFields
from adr_opt.learning.decoding import Field
from adr_opt.learning.environment import OBSERVATIONS, MissionEnv, MissionVecEnv
from adr_opt.learning.environment.fields import FIRST_SEED
from adr_opt.learning.episodes import Board
from adr_opt.learning.evaluation import APART, KINDS, digest, evaluate, splits
from adr_opt.learning.held_out import FAMILIES as HELD_FAMILIES
from adr_opt.learning.held_out import HeldFields, chaser_by_chaser
from adr_opt.learning.policy import SHIPPED, load_policy
from adr_opt.mission.mission import Mission
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld


class Cheap:
    """Chooses the cheapest legal move from which the station can be reached, if there is one."""

    def __init__(self, count: int, targets: int) -> None:
        self.board = Board("choices", count, targets)

    def __call__(self, pool: StackedFields, episodes: Episodes) -> npt.NDArray[np.int64]:
        """Actions of all episodes."""
        self.board.observe(pool, episodes, 0, self.board.legal.size)
        seen = self.board.arrays
        assert isinstance(seen, dict)
        cost = seen["moves"][:, :, COST] + 3.0 * (seen["moves"][:, :, SAFE] == 0.0)
        actions: npt.NDArray[np.int64] = np.where(self.board.mask, cost, np.inf).argmin(axis=1)
        return actions


def vector_rate(
    env: MissionVecEnv, cheap: Cheap, steps: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Steps of single missions a second of one run, by a clock."""
    spent = 0.0
    for _ in range(steps):
        actions = cheap(env.pool.arrays, env.episodes)
        began = clock()
        env.step(actions)
        env.action_masks()
        spent += clock() - began
    return steps * env.num_envs / spent


def single_rate(env: MissionEnv, steps: int) -> float:
    """The same of one mission after the other in a Python loop; resets are not timed."""
    cheap = Cheap(1, int(cast(Discrete, env.action_space).n) - 1)
    spent = 0.0
    over = True
    for _ in range(steps):
        if over:
            env.reset()
        assert env._played is not None
        action = cheap(env._played.pool.arrays, env._episodes)[0]
        began = time.perf_counter()
        _, _, over, _, _ = env.step(action)
        env.action_masks()
        spent += time.perf_counter() - began
    return steps / spent


def environment(
    runs: int = 7,
    steps: int = 60,
    slots: int = 64,
    counts: tuple[int, ...] = (256, 1024),
    threads: tuple[int, ...] = (1, 2),
    observations: tuple[str, ...] = tuple(OBSERVATIONS),
) -> None:
    """Steps per second of the environments, with masks and observations.

    Nominal fields, played by a policy that prefers cheap moves with a way back, so that episodes
    are about as long as those of a trained policy. Choosing actions is not timed. Rates are medians
    over runs, with the best in brackets; ratios are to the one-by-one loop of the same call.
    """
    head("environment", "observation", "missions", "threads", "steps/s", "ratio")

    def line(what: tuple[object, ...], rate: Callable[[], float], base: float | None) -> float:
        rates = [rate() for _ in range(runs)]
        middle = median(rates)
        ratio = 1.0 if base is None else middle / base
        row(*what, f"{middle:,.0f} ({max(rates):,.0f})", f"{ratio:.1f} ×")
        return middle

    instance = adr_opt.generate("nominal", 0)
    for seen in observations:
        env = MissionEnv(instance, observation=seen)
        single_rate(env, 50)
        what = "`MissionEnv`, one by one", seen, 1, 1
        base = line(what, lambda env=env: single_rate(env, 400), None)
        for count in counts:
            many = MissionVecEnv(count, observation=seen, slots=slots, threads=max(threads))
            many.reset()
            cheap = Cheap(count, int(cast(Discrete, many.action_space).n) - 1)
            vector_rate(many, cheap, steps)
            for used in threads:
                many.threads = used
                what = "`MissionVecEnv`", seen, count, used
                line(what, lambda many=many, cheap=cheap: vector_rate(many, cheap, steps), base)
            many.close()


def interval(values: list[float]) -> str:
    """Mean with its 95 % interval (Student)."""
    if len(values) < 2:
        return f"{fmean(values):.2f}"
    half = t.ppf(0.975, len(values) - 1) * stdev(values) / len(values) ** 0.5
    return f"{fmean(values):.2f} ± {half:.2f}"


def curve(file: str = SHIPPED) -> None:
    """The curve of a training, by the card of a policy or the file ``evaluations.csv``."""
    families: dict[str, dict[str, float]] = {}
    if file.endswith(".csv"):
        with Path(file).open(newline="", encoding="utf-8") as lines:
            names, *found = list(csv.reader(lines))
    else:
        card = load_policy(file).card
        families = card["families"]
        names, found = ["steps", "seconds", *families], card["curve"]
    head("steps", "minutes", *names[2:])
    if before := [of["untrained"] for of in families.values() if "imitating" in of]:
        row("untrained", "", *(f"{each:.2f}" for each in before))
    for steps, seconds, *visits in found:
        minutes = f"{float(seconds) / 60:.0f}"
        row(f"{float(steps):,.0f}", minutes, *(f"{float(each):.2f}" for each in visits))


def evaluated(
    file: str = SHIPPED,
    split: str = "test",
    budget: int = 1,
    fields: int | None = None,
    beams: tuple[int, ...] = (),
    kinds: tuple[str, ...] = KINDS,
    after: int = 0,
) -> None:
    """What a policy collects on a block of fields, beside what is proven of them, and beams."""
    leads = [f"lead over beam {width}, paired" for width in beams]
    head("family", "fields", "visits", "gap", "share optimal", *leads, "ms a field")
    found = evaluate(
        file, split=split, budget=budget, fields=fields, beams=beams, kinds=kinds, after=after
    )
    for family, of in found.items():
        known = int((~np.isnan(of.optima)).sum())
        row(
            family,
            of.visits.size,
            "{:.2f} ± {:.2f}".format(*of.mean),
            "{:.1%} ± {:.1%} ({} fields)".format(*of.gap, known) if known else "",
            f"{of.optimal:.0%}" if known else "",
            *("{:+.2f} ± {:.2f}".format(*of.lead(w)) if of.beams else "" for w in beams),
            ", ".join(f"{1e3 * each.seconds:.0f}" for each in (of, *of.beams.values())),
        )
    tables = ", ".join(f"{name} {1e3 * of.table_seconds:.0f}" for name, of in found.items())
    print(f"\nProcessor time of a field; that of its timetable besides [ms]: {tables}.")


def decisions(targets: tuple[int, ...] = (50, 500, 5000), fields: int = 5) -> None:
    """Processor time from a state to a move, the least of three, and what comes of the moves.

    With the timetable of an environment, and with connections worked out on demand.
    """
    head("targets", "connections", "fields", "prize", "ms a decision, median", "of 90 % of them")
    policy = load_policy()

    def least_ms(decide: Callable[[], Any]) -> float:
        def once() -> float:
            began = time.process_time()
            decide()
            return 1e3 * (time.process_time() - began)

        return min(once() for _ in range(3))

    def line(count: int, how: str, prizes: list[float], spent: list[float]) -> None:
        middle, most = np.quantile(spent, (0.5, 0.9))
        row(count, how, len(prizes), interval(prizes), f"{middle:.2f}", f"{most:.2f}")

    spent, prizes = list[float](), list[float]()
    for number in range(-1, fields):  # the first one loads kernels
        field = Field(Mission(adr_opt.generate("nominal", 200 + number)), policy)
        episodes, rewards = field.begin(1), np.zeros(1, dtype=np.float32)
        while (seen := field.judged(episodes))[1].legal[0]:
            spent.append(least_ms(lambda: field.judged(episodes)[0].argmax(axis=1)))  # noqa: B023
            episode_kernels.act(field.pool.arrays, episodes, 0, 1, seen[0].argmax(axis=1), rewards)
        if number < 0:
            spent.clear()
        else:
            prizes.append(float(episodes.serviced[0]))
    line(50, "timetable", prizes, spent)
    for count in targets:
        spent, prizes = [], []
        for number in range(-1, fields):  # the first one loads kernels
            facts = MissionFacts(adr_opt.generate("nominal", 200 + number, targets=count), cores=1)
            flies = Learned(facts, Intended(None, ((),), (0,)), Uncertainty(), 0, policy)

            def timed_leg(now: Situation, by: Learned = flies, to: list[float] = spent) -> Any:
                to.append(least_ms(lambda: by._best_scored(now)))
                return Learned.next_leg(by, now)

            flies.next_leg = timed_leg  # type: ignore[method-assign]
            world = DrawnWorld(facts.instance, Uncertainty(), 0)
            prize = rehearsed(facts, world, flies, (0,)).prize
            if number >= 0:
                prizes.append(prize)
            else:
                spent.clear()
        line(count, "on demand", prizes, spent)


FLOWN_SEED = 8_300_000
"""First seed of the fields of :func:`flown`."""


def flown(
    fields: int = 20,
    worlds: int = 3,
    width: int = 0,
    policies: tuple[str, ...] = ("learned", "skip", "follow"),
) -> None:
    """Prizes without the luck of captures in known and uncertain worlds, the same for any policy.

    Nominal fields; with ``--width`` missions begin with the plan of a beam of that width, and leads
    of the first policy over others are paired by field, with p by Wilcoxon's test times the number
    of all comparisons in uncertain worlds.
    """
    legs = {"delta_v_factor": {"lognormal_sigma": 0.1}}
    slow, captures = {"factor": {"lognormal_sigma": 0.5}}, {"success": 0.8, "tries": 2}
    late = {"chance": 0.1, "mean_s": 14400.0}
    models: dict[str, dict[str, Any]] = {
        "known": {},
        "dear": {"legs": legs},
        "captures": {"capture": captures, "gone": 0.05},
        "slow": {"service_s": slow | {"added": late}},
        "mixed": {"legs": legs, "service_s": slow, "capture": captures, "gone": 0.05},
    }
    used = policies if width else policies[:1]
    prizes = {(name, policy): list[float]() for name in models for policy in used}
    for number in range(fields):
        facts = MissionFacts(adr_opt.generate("nominal", FLOWN_SEED + number), cores=1)
        begun = Intended(None, ((),), (0,))
        if width:
            plan = adr_opt.solve(facts.instance, "beam", width=width, time_limit=math.inf).plan
            begun = intended(facts, plan)
        for name, policy in prizes:
            uncertainty = Uncertainty(**models[name])
            collected = [
                rehearsed(
                    facts,
                    DrawnWorld(facts.instance, uncertainty, 100 * number + world),
                    policy_of(policy)(facts, begun, uncertainty, 0),
                    (0,),
                ).expected
                for world in range(worlds if models[name] else 1)
            ]
            prizes[name, policy].append(fmean(collected))
    head("worlds", "fields", *used, *(f"lead over {each}, p" for each in used[1:]))
    tests = (len(models) - 1) * (len(used) - 1)
    for name in models:
        leads = []
        for other in used[1:]:
            pairs = zip(prizes[name, used[0]], prizes[name, other], strict=True)
            lead = [mine - theirs for mine, theirs in pairs]
            p = wilcoxon(lead).pvalue if any(lead) else 1.0
            leads.append(f"{interval(lead)}, {min(1.0, p * tests):.2g}")
        row(name, fields, *(interval(prizes[name, each]) for each in used), *leads)


def prior(
    *what: str,
    first: int = 8_200_000,
    fields: int = 20,
    beams: tuple[int, ...] = (30, 300, 1000, 3000),
    guided: tuple[int, ...] = (10, 30),
    worth: float = 0.05,
) -> None:
    """Beams with the policy as prior beside the plain beam that takes as long, or a little longer.

    Families. Leads are paired by field; p by Wilcoxon's test, times the number of all comparisons.
    """
    families = what or HELD_FAMILIES
    head("family", "beam", "visits", "ms", "plain beam", "visits", "ms", "lead", "p, corrected")
    for family in families:
        visits: dict[tuple[str, int], list[float]] = {}
        spent: dict[tuple[str, int], list[float]] = {}
        for number in range(-1, fields):  # the first one loads kernels
            mission = Mission(adr_opt.generate(family, first + number), threads=1)
            adr_opt.solve(mission, "beam", width=1, time_limit=math.inf)
            for name in (*(("plain", w) for w in beams), *(("guided", w) for w in guided)):
                more = {"policy": SHIPPED, "prior_weight": worth} if name[0] == "guided" else {}
                began = time.process_time()
                made = adr_opt.solve(mission, "beam", width=name[1], time_limit=math.inf, **more)
                if number >= 0:
                    spent.setdefault(name, []).append(time.process_time() - began)
                    visits.setdefault(name, []).append(made.objective)
        for width in guided:
            own = fmean(spent["guided", width])
            rivals = [w for w in beams if fmean(spent["plain", w]) >= own] or [beams[-1]]
            rival = min(rivals)
            mine, theirs = visits["guided", width], visits["plain", rival]
            lead = [a - b for a, b in zip(mine, theirs, strict=True)]
            p = wilcoxon(lead).pvalue if any(lead) else 1.0
            row(
                family,
                f"guided, {width}",
                interval(mine),
                f"{1e3 * own:.0f}",
                rival,
                interval(theirs),
                f"{1e3 * fmean(spent['plain', rival]):.0f}",
                interval(lead),
                f"{min(1.0, p * len(guided) * len(families)):.2g}",
            )


RIVALS = Path(__file__).parent / "curves" / "rivals.csv"
"""What :func:`rivals` writes, and docs/draw_tasks.py draws."""


def collected(family: str, first: int, fields: int, method: str, **more: Any) -> list[float]:
    """Prizes of a planner on the first fields of a block, chaser by chaser."""
    prizes = list[float]()
    for number in range(first, first + fields):
        plans = list[adr_opt.Plan]()
        for mission in chaser_by_chaser(adr_opt.generate(family, number), plans):
            made = adr_opt.solve(mission, method, time_limit=math.inf, **more).plan
            plans += [] if made is None else [made]
        prizes.append(sum(plan.objective for plan in plans))
    return prizes


def levels(
    *kinds: str, split: str = "test", fields: int = 30, after: int = 0, width: int = 30
) -> None:
    """Visits of planners and of the policy, all chaser by chaser; campaigns and clouds if none."""
    named = kinds or APART
    ours = evaluate(split=split, fields=fields, kinds=named, after=after)
    methods: dict[str, dict[str, Any]] = {
        "greedy": {},
        "greedy-guarded": {},
        "beam": {"width": width},
    }
    head("family", "fields", *methods, "policy", "lead over the beam, paired")
    for family in named:
        first = int(ours[family].seeds[0])
        found = [collected(family, first, fields, name, **more) for name, more in methods.items()]
        mine = ours[family].visits.tolist()
        lead = [own - other for own, other in zip(mine, found[-1], strict=True)]
        row(family, fields, *map(interval, (*found, mine, lead)))


def rivals(fields: int = 20, width: int = 30, file: Path = RIVALS) -> None:
    """Mean visits of planners on the first fields of the sealed block, and bounds."""
    told = splits()["blocks"]["test"]
    lines = ["family,what,visits"]
    for family in HELD_FAMILIES:
        for method, more in (("greedy-guarded", {}), ("beam", {"width": width})):
            visits = collected(family, told["first"], fields, method, **more)
            lines.append(f"{family},{method},{fmean(visits):.3f}")
        if of := told["bounds"].get(family):
            lines.append(f"{family},least bound,{fmean(bound for _, bound in of.values()):.3f}")
    write_text(file, "\n".join(lines) + "\n")


def offline(out: str = "offline.npz", fields: int = 12, limit: float = 60.0) -> None:
    """States, actions, and optimum to go of proven optimal plans, for learning without play.

    Seeds are those of training. Plans that need another schedule than the moves of
    the environment have are left out.
    """
    from adr_opt.learning.training.imitation import states_of

    parts: dict[str, list[Any]] = {name: [] for name in ("moves", "mission", "action", "to_go")}
    made = 0
    for family, number in ((f, FIRST_SEED + at) for f in HELD_FAMILIES for at in range(fields)):
        mission = Mission(adr_opt.generate(family, number))
        found = adr_opt.solve(mission, "exact", time_limit=limit)
        if found.plan is None or found.objective != found.upper_bound:
            continue
        states = states_of(mission, found.plan)
        if len(states) == len(found.plan.legs):
            made += 1
            for name, column in zip(parts, zip(*states, strict=True), strict=True):
                parts[name] += column
    card = {"fields": made, "tried": fields * len(HELD_FAMILIES), "method": "exact", "limit": limit}
    arrays = {name: np.array(part) for name, part in parts.items()}
    np.savez_compressed(out, card=np.frombuffer(json.dumps(card).encode(), np.uint8), **arrays)
    print(f"{out}: {made} fields of {card['tried']}, {len(arrays['action'])} states")


FRESH_SEED = 8_100_000
"""First seed of the fields of :func:`ablation`."""


def ablation(steps: int = 131_072, seeds: int = 1, fields: int = 50) -> None:
    """What rate, observation and sharing of weights are worth at equal steps on nominal fields."""
    from adr_opt.learning.training.configs import POLICY, PUBLISHED_CONFIG
    from adr_opt.learning.training.trainer import train

    ours = replace(POLICY, kinds=PUBLISHED_CONFIG.kinds, models=(), steps=steps, slots=48)
    flat = replace(ours, network=PUBLISHED_CONFIG.network)
    slow, absolute = {"rate": PUBLISHED_CONFIG.rate}, {"observation": "published"}
    arms = {
        ("shared", "choices"): ours,
        ("shared", "choices "): replace(ours, **slow),
        ("none", "choices"): flat,
        ("none", "absolute elements"): replace(flat, **absolute),
        ("none", "absolute elements "): replace(flat, **absolute, **slow),
        ("published, none", "absolute elements"): replace(PUBLISHED_CONFIG, steps=steps, slots=48),
    }
    head("weights of moves", "observation", "rate", "steps", "visits on fresh fields, by seed")
    held = HeldFields(FRESH_SEED, fields)
    for (sharing, seen), config in arms.items():
        visits = []
        for seed in range(1, 1 + seeds):
            with TemporaryDirectory() as folder:
                told: dict[str, float] = {}

                def report(_: int, means: Mapping[str, float], to: Any = told) -> None:
                    to.update(means)

                train(config, Path(folder), seed=seed, report=report, held_out=held)
                visits.append(f"{told['nominal']:.2f}")
        row(sharing, seen.strip(), f"{config.rate:g}", steps, ", ".join(visits))


def bounds(
    *families: str, block: str = "test", fields: int = 12, after: int = 0, limit: float = 60.0
) -> None:
    """Write digests of a block, and bounds of the exact method for some fields, to the splits.

    Families; without any digests alone. Fields begin behind the first ``--after``. What is
    known is kept, so that a call goes on where the one before ended.
    """
    file, blocks = Path(str(files(adr_opt.learning) / "weights" / "splits.json")), splits()
    told = (blocks["blocks"] | blocks["announced"])[block]

    def keep() -> None:
        text = json.dumps(blocks, indent=1)
        write_text(file, re.sub(r"\[\s+([\d.]+),\s+([\d.]+)\s+\]", r"[\1, \2]", text) + "\n")

    if not told.setdefault("digests", []):
        for first in range(told["first"], told["first"] + told["fields"], told["each"]):
            told["digests"].append(digest(first, told["each"]))
        keep()
    for family in families:
        known = told["bounds"].setdefault(family, {})
        first = told["first"] + after
        for number in range(first, first + fields):
            if str(number) not in known:
                found = adr_opt.solve(adr_opt.generate(family, number), "exact", time_limit=limit)
                known[str(number)] = [found.objective, found.upper_bound]
                keep()
    head("family", "fields", "proven")
    for family, known in told["bounds"].items():
        row(family, len(known), sum(best == bound for best, bound in known.values()))


if __name__ == "__main__":
    sys.exit(
        experiment(
            __doc__,
            environment,
            curve,
            evaluated,
            levels,
            decisions,
            flown,
            prior,
            rivals,
            offline,
            ablation,
            bounds,
        )
    )
