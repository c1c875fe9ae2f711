"""Campaigns and costs: the least cost at the best prize, and designs of campaigns.

python bench/campaigns.py cost nominal --limit 60 --out cost.jsonl
python bench/campaigns.py cost removal --targets 12 --chasers 3 --expense 55,0,2e-3 --limit 60
python bench/campaigns.py cost nominal --duration --count 5
python bench/campaigns.py cost rocket-bodies --electric --targets 8 --count 5 --limit 20
python bench/campaigns.py designs
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Any

from fields import ready
from tables import experiment, head, kept, row, timed
from worth import DODGING, bodies_of

import adr_opt
from adr_opt.analysis import Axis, CampaignPrices, design_study
from adr_opt.common.clock import count_processor_time
from adr_opt.common.constants import DAY_S
from adr_opt.problem.chasers import TankByMass
from adr_opt.sources import catalogue, worth
from adr_opt.sources.generator.rocket_bodies import ELECTRIC_TRANSFER, electric_chaser
from adr_opt.ui.report.designs import design_columns


def cost(
    family: str,
    first: int = 0,
    count: int = 20,
    limit: float = 60.0,
    targets: int | None = None,
    chasers: int | None = None,
    expense: str = "",
    duration: bool = False,
    electric: bool = False,
    processor: bool = False,
    out: Path | None = None,
) -> None:
    """The least cost at the best prize: what ``exact`` proves of it in a time, field by field.

    With ``--targets`` and ``--chasers`` fields are smaller or larger than those of the family, and
    with ``--expense`` the cost is no ΔV, but what chasers take: each one so much if it is used, for
    each kilogram that it carries, and for each square of one. With ``--duration`` it is the end of
    the last service. With ``--electric`` chasers thrust, as those of the family `electric` do:
    stages like SL-16 are those of `rocket-bodies`; there what is least with the legs of the
    heaviest chaser is proven, which bounds no others. The time limit starts with a ready timetable
    and covers the proof of the prizes, too; with ``--processor`` it counts the processor time of
    all threads. Every plan is checked. Rows are kept in ``--out``, and gone on with.
    """
    names = ("fixed", "per_kg", "per_kg_squared")
    prices = [float(each) for each in expense.split(",") if each]

    def drawn(family: str, seed: int, targets: int | None) -> adr_opt.Instance:
        instance = adr_opt.generate(family, seed, targets=targets, chasers=chasers)
        if electric:
            thrusting = tuple(electric_chaser(each) for each in range(len(instance.chasers)))
            instance = instance.replace(chasers=thrusting, transfer=ELECTRIC_TRANSFER)
        if duration:
            return instance.replace(objective={"cost": "duration"})
        if not prices:
            return instance
        each = dict(zip(names, prices, strict=False))
        crew = tuple(chaser.replace(expense=each) for chaser in instance.chasers)
        return instance.replace(chasers=crew, objective={"cost": "expense"})

    def measured(instance: adr_opt.Instance, limit_s: float) -> dict[str, Any]:
        problem = ready(instance)
        result, wall, cpu = timed(
            lambda: adr_opt.solve(problem, "exact", time_limit=limit_s, seed=0, cost=True)
        )
        plan = result.plan
        assert plan is not None
        told = {name: getattr(plan, name) for name in ("cost", "cost_bound", "cost_gap")}
        told |= {"objective": result.objective, "cost_status": plan.cost_status}
        return {
            **told,
            "wall_s": wall,
            "cpu_s": cpu,
            "violations": len(adr_opt.check(problem.instance, plan)),
        }

    measured(drawn(family if prices or electric else "tiny", 0, 3), 20.0)  # compiles
    if processor:
        count_processor_time()
    asked = {"limit_s": limit, "targets": targets, "chasers": chasers}
    asked |= {"expense": prices, "duration": duration, "electric": electric}
    rows = [
        kept(
            out,
            {"family": family, "seed": seed, **asked},
            lambda seed=seed: measured(drawn(family, seed, targets), limit),
        )
        for seed in range(first, first + count)
    ]
    what, unit = ("expense", "") if prices else ("end", " s") if duration else ("ΔV", " m/s")
    print(f"Family `{family}`, at most {limit:g} s each.")
    head("seed", "prize", what, "no plan below", "gap", "time", "processor time")
    for one in rows:
        known = one["cost_bound"] is not None
        row(
            one["seed"],
            f"{one['objective']:g}",
            f"{one['cost']:,.1f}{unit}",
            f"{one['cost_bound']:,.1f}{unit}" if known else "",
            f"{100 * one['cost_gap']:.2f} %" if known else "",
            f"{one['wall_s']:.1f} s",
            f"{one['cpu_s']:.1f} s",
        )
    gaps = [1.0 if one["cost_gap"] is None else one["cost_gap"] for one in rows]
    proven = (
        f"{sum(one['cost_status'] == 'optimal' for one in rows)} proven, "
        f"{sum(gap <= 0.02 for gap in gaps)} within 2 %, median gap {100 * median(gaps):.2f} %, "
    )
    print(
        f"\n{len(rows)} fields: {'' if electric else proven}"
        f"median time {median(one['wall_s'] for one in rows):.1f} s, "
        f"{sum(one['violations'] for one in rows)} violations."
    )


def designs(candidates: int = 80, limit: float = 20.0, jobs: int = 2) -> None:
    """Ten designs of campaigns with three launches, planned, bounded and evaluated, with the time.

    Candidates are those of the synthetic population (``worth.py population``) that are most worth
    removing. Prices are round numbers, of no one's rocket.
    """
    axes = (Axis("kits", (4.0, 8.0)), Axis("propellant", (100.0, 200.0, 300.0, 400.0, 500.0)))
    crew = catalogue.Crew(
        tank=TankByMass(dry_mass_kg=500.0, propellant_kg=200.0, isp_s=300.0),
        launches=3,
        apart_s=365 * DAY_S,
        kits=6,
        kit_mass_kg=40.0,
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = worth.worth_of(bodies_of(folder, 20_000, DODGING), 50.0)
        prizes = worth.prizes_of(found, candidates)
        pairs, table = folder / "pairs.json", folder / "prizes.csv"
        pairs.write_text(worth.pairs_json(prizes), encoding="utf-8")
        table.write_text(prizes.prizes_csv(), encoding="utf-8")
        wanted = catalogue.Demands(wishes=catalogue.read_wishes(table), only_wished=True)
        instance = catalogue.to_instance(
            catalogue.read(folder / "catalogue.csv"),
            mission=catalogue.MissionOutline(duration_s=1826 * DAY_S, refuelling=False),
            crew=crew,
            demands=wanted,
        ).instance
        worths = worth.load_set_worths(pairs)
    study, taken_s, _ = timed(
        lambda: design_study(
            instance,
            axes,
            worths=worths,
            prices=CampaignPrices(launch=20e6, kit=1e6, kilogram=2e4),
            time_limit=limit,
            jobs=jobs,
        )
    )
    broken = sum(
        len(adr_opt.check(point.instance, point.plan)) for point in study.points if point.plan
    )
    print(
        f"{len(study.points)} designs of {len(instance.chasers)} launches over "
        f"{len(instance.targets)} candidates: {taken_s:.0f} s on {jobs} cores, {broken} violations."
    )
    columns = design_columns(study)
    head(*columns)
    for each in enumerate(study.points):
        row(*(tell(*each) for tell in columns.values()))


if __name__ == "__main__":
    sys.exit(experiment(__doc__, cost, designs))
