"""The loop of planning and refining: plans that hold, and how many rounds they take."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from fields import ROOT, eccentric, imported
from tables import head, row, timed

import adr_opt
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.loop import Round
from adr_opt.plan.refined_plan import Freedom
from adr_opt.problem.instance import Instance

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


def instances(priced: Literal["sequence", "free"] = "free") -> Iterator[Instance]:
    """Twenty instances of eccentric orbits under J2, by a price; without external data twelve."""

    def by_price(field: Instance) -> Instance:
        return field.replace(transfer=field.transfer.replace(burns=priced))

    for family, seeds, targets in (
        ("reduced-fuel", 4, None),
        ("nominal", 3, 25),
        ("tiny", 2, None),
    ):
        for seed in range(seeds):
            field = eccentric(adr_opt.generate(family, seed, targets=targets), 0.02, seed).replace(
                dynamics="j2"
            )
            yield by_price(field.replace(name=f"{field.name}-eccentric"))
    for seed in range(3):
        yield by_price(adr_opt.generate("cloud", seed).replace(dynamics="j2"))
    if folder := os.environ.get("ADR_OPT_EXTERNAL_DATA"):
        for number, (file, targets, days, tank) in enumerate(CLOUDS):
            made = imported(
                Path(folder) / file, f"--max-targets {targets} --duration-days {days}"
            ).with_limits(delta_v_m_s=1e3 * tank)
            yield by_price(made.replace(name=f"iridium-33-{number}"))


def expected(last: Round) -> list[tuple[float, float, bool]]:
    """For each leg of a round: expected and flown [m/s], and whether the pair is new."""
    legs = []
    for leg in last.refined.legs:
        key = leg.origin, leg.destination, leg.kind
        cost = last.corrections.corrected(*key, leg.planned_delta_v_m_s)
        legs.append((cost, leg.flown_delta_v_m_s, key not in last.corrections.shares))
    return legs


def _told(legs: list[tuple[float, float, bool]]) -> tuple[str, str]:
    """Number, error in total and mean error of legs, and of those of new pairs."""
    said = []
    for some in (legs, [leg for leg in legs if leg[2]]):
        if not some:
            said.append("none")
            continue
        planned, flown = np.array([leg[:2] for leg in some]).T
        total, leg = planned.sum() / flown.sum() - 1.0, np.abs(planned / flown - 1.0).mean()
        said.append(f"{len(some)}: {total:+.1%}, {leg:.1%}")
    return said[0], said[1]


def loop(
    method: str = "greedy-guarded",
    limit: float = 30.0,
    rounds: int = 10,
    jobs: int = 2,
    burns: tuple[Freedom, ...] = ("free", "planned"),
    only: str = "",
    priced: Literal["sequence", "free"] = "free",
    spend_savings: bool = False,
) -> None:
    """Plan, refine and plan again until plans hold, on twenty instances of eccentric orbits.

    First and last round stand side by side, and what the corrected connections said of the last
    plan beside what it flies: in total, as the mean error of a leg, and of the legs alone between
    pairs of bodies that were not flown between before. With ``--spend-savings`` connections may
    become cheaper, and every mission is planned at least twice. ``--priced`` is what legs cost by.
    """
    head(
        *("instance", "burns", "prize, first", "flown against planned", "holds at once", "rounds"),
        *("prize", "flown against planned, last", "expected against flown, legs: total, a leg"),
        *("of new pairs", "outcome", "processor time"),
    )
    counts = {one: np.zeros(3, dtype=int) for one in burns}
    heard = defaultdict[tuple[str, bool], list[tuple[float, float, bool]]](list)
    for instance in instances(priced):
        for freedom in burns if only in instance.name else ():
            found, _, taken = timed(
                lambda: adr_opt.solve_refined(
                    instance,  # noqa: B023
                    method,
                    freedom=freedom,  # noqa: B023
                    time_limit=limit,
                    seed=0,
                    rounds=rounds,
                    jobs=jobs,
                    spend_savings=spend_savings,
                )
            )
            first, last = found.rounds[0], found.rounds[-1]
            holds, outcome, objective = False, found.reason, float("nan")
            if found.holds and found.refined is not None and found.plan is not None:
                broken = {one.rule for one in adr_opt.check(instance, found.plan)}
                assert broken <= ({"delta-v"} if spend_savings else set())
                holds = fly_refined(instance, found.refined).holds
                outcome = "holds" if holds else "does not hold in `fly`"
                objective = found.plan.objective
            legs = expected(last)
            row(
                instance.name,
                freedom,
                f"{first.objective:g}",
                f"{first.flown_delta_v_m_s / first.planned_delta_v_m_s - 1.0:+.1%}",
                "yes" if not first.troubles else "no",
                len(found.rounds),
                f"{objective:g}",
                f"{last.flown_delta_v_m_s / last.planned_delta_v_m_s - 1.0:+.1%}",
                *_told(legs),
                outcome,
                f"{taken:.0f} s",
            )
            counts[freedom] += (1, not first.troubles, holds)
            heard[freedom, len(found.rounds) > 1] += legs
    for one, (every, at_once, held) in counts.items():
        print(f"\n{one} burns: {held} of {every} end with a plan that holds, {at_once} at once")
        for again, taken in ((False, "one round"), (True, "more rounds")):
            said = " | ".join(_told(heard[one, again]))
            print(f"expected against flown, legs, and of new pairs, {taken}: {said}")


def savings(seeds: int = 5, method: str = "auto", limit: float = 15.0, rounds: int = 10) -> None:
    """What plans collect that spend what free burns save, and what those do that do not.

    Fields short of fuel, of circles under J2.
    """
    head("field", "prize", "spending savings", "rounds", "planned m/s", "flown m/s", "holds")
    for seed in range(seeds):
        mission = adr_opt.Mission(adr_opt.generate("reduced-fuel", seed).replace(dynamics="j2"))
        mission.timetable  # noqa: B018 - so that both plan with all targets
        plain, spent = (
            adr_opt.solve_refined(
                mission,
                method,
                freedom="free",
                time_limit=limit,
                seed=0,
                rounds=rounds,
                spend_savings=spend,
            )
            for spend in (False, True)
        )
        assert plain.plan is not None
        assert spent.plan is not None
        assert spent.refined is not None
        row(
            mission.instance.name,
            f"{plain.plan.objective:g}",
            f"{spent.plan.objective:g}",
            len(spent.rounds),
            f"{spent.refined.planned_delta_v_m_s:.0f}",
            f"{spent.refined.flown_delta_v_m_s:.0f}",
            "yes" if fly_refined(mission.instance, spent.refined).holds else "no",
        )


CHASER = "--thrust 0.2 --dry-mass 400 --propellant 60 --isp 1500 --duration-days 365"


def thrust(*names: str, targets: int = 8, rounds: int = 4, limit: float = 20.0) -> None:
    """The loop with low thrust: plans that hold, and the rounds they take.

    ``cloud`` is the example catalogue, imported with a chaser of 0.2 N for a year; ``electric-N`` a
    small field of the family, with tows. Each plan is flown by ``fly`` with another integrator.
    """
    head(
        *("instance", "prize", "planned → flown", "troubles", "rounds", "prize"),
        *("planned → flown", "", "processor time"),
    )
    for name in names or ("cloud", "electric-0", "electric-1"):
        if name == "cloud":
            file = ROOT / "examples" / "catalogue" / "cloud.tle"
            instance = imported(file, f"{CHASER} --max-targets {targets}")
        else:
            seed = int(name.removeprefix("electric-"))
            instance = adr_opt.generate("electric", seed, targets=targets)
        found, _, taken = timed(
            lambda: adr_opt.solve_refined(instance, time_limit=limit, rounds=rounds, seed=0)  # noqa: B023
        )
        first, outcome, cells = found.rounds[0], found.reason, ["", ""]
        if found.holds and found.refined is not None and found.plan is not None:
            assert not adr_opt.check(instance, found.plan)
            holds = fly_refined(instance, found.refined).holds
            outcome = "holds" if holds else "does not hold in `fly`"
            planned, flown = found.refined.planned_delta_v_m_s, found.refined.flown_delta_v_m_s
            cells = [f"{found.plan.objective:g}", f"{planned:.0f} → {flown:.0f} m/s"]
        burns = f"{first.planned_delta_v_m_s:.0f} → {first.flown_delta_v_m_s:.0f} m/s"
        counts = len(first.troubles), len(found.rounds)
        row(name, f"{first.objective:g}", burns, *counts, *cells, outcome, f"{taken:.0f} s")
