"""Ten designs of campaigns with three launches, planned, bounded and evaluated, with the time.

    python bench/designs.py
    python bench/designs.py --candidates 60 --time-limit 10 --jobs 1

Candidates are those of the synthetic population (`bench/population.py`) that are most worth
removing. Prices are round numbers, of no one's rocket.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from machine import heading
from population import write_population

import adr_opt
from adr_opt.analysis import Axis, CampaignPrices, DesignStudy, design_study
from adr_opt.problem.chasers import TankByMass
from adr_opt.sources import catalogue, worth
from adr_opt.ui.report.designs import design_columns, designs_page

DODGING = ("RELAY*", "HIGH RELAY*")
"""Constellations of the population, whose satellites are taken to dodge."""

AXES = (Axis("kits", (4.0, 8.0)), Axis("propellant", (100.0, 200.0, 300.0, 400.0, 500.0)))

PRICES = CampaignPrices(launch=20e6, kit=1e6, kilogram=2e4)

DAYS = 1826.0


def candidates_of(folder: Path, count: int) -> tuple[adr_opt.Instance, worth.SetWorths]:
    """A campaign over the objects most worth removing, and the worths of their sets."""
    path, satcat = write_population(folder)
    bodies = worth.bodies_of(
        catalogue.read(path).records, worth.read_satcat(satcat), excluded=DODGING
    )
    prizes = worth.prizes_of(worth.worth_of(bodies, 50.0), count)
    pairs, table = folder / "pairs.json", folder / "prizes.csv"
    pairs.write_text(worth.pairs_json(prizes), encoding="utf-8")
    table.write_text(prizes.prizes_csv(), encoding="utf-8")
    crew = catalogue.Crew(
        tank=TankByMass(dry_mass_kg=500.0, propellant_kg=200.0, isp_s=300.0),
        launches=3,
        apart_s=365 * 86400.0,
        kits=6,
        kit_mass_kg=40.0,
    )
    made = catalogue.to_instance(
        catalogue.read(path),
        mission=catalogue.MissionOutline(duration_s=DAYS * 86400.0, refuelling=False),
        crew=crew,
        demands=catalogue.Demands(wishes=catalogue.read_wishes(table), only_wished=True),
    )
    return made.instance, worth.load_set_worths(pairs)


def print_study(study: DesignStudy) -> None:
    """Print the table of a study."""
    titles = design_columns(study)
    print(f"| {' | '.join(titles)} |\n|{'---|' * len(titles)}")
    for each in enumerate(study.points):
        print(f"| {' | '.join(tell(*each) for tell in titles.values())} |")


def main() -> None:
    """Run the study and print the time and the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--candidates", type=int, default=80)
    parser.add_argument("--time-limit", type=float, default=20.0, help="of a plan, or a bound [s]")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--page", type=Path, help="HTML file to write")
    call = parser.parse_args()
    print(heading())
    with tempfile.TemporaryDirectory() as name:
        instance, worths = candidates_of(Path(name), call.candidates)
    begin = time.perf_counter()
    study = design_study(
        instance, AXES, worths=worths, prices=PRICES, time_limit=call.time_limit, jobs=call.jobs
    )
    taken_s = time.perf_counter() - begin
    violations = sum(
        len(adr_opt.check(point.instance, point.plan)) for point in study.points if point.plan
    )
    print(
        f"{len(study.points)} designs of {len(instance.chasers)} launches over "
        f"{len(instance.targets)} candidates: {taken_s:.0f} s on {call.jobs} cores, "
        f"{violations} violations.\n"
    )
    print_study(study)
    if call.page is not None:
        begin = time.perf_counter()
        call.page.write_text(designs_page(study), encoding="utf-8")
        print(
            f"\npage of {call.page.stat().st_size / 1e3:.0f} kB in "
            f"{time.perf_counter() - begin:.1f} s"
        )


if __name__ == "__main__":
    main()
