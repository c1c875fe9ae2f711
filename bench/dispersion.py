"""Flights with errors: what plans need at 95 %, misses at stand-offs, linearity, and times.

    python bench/dispersion.py

Nominal fields under J2 and a drawn cloud, planned by `greedy-guarded` and refined, are flown a
thousand times with the default errors, by number of burns for corrections alone; then the first one
with other errors.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

from machine import heading

import adr_opt
from adr_opt.fly.dispersion import Dispersion, FlightErrors, sample_flights
from adr_opt.plan.refined_plan import Freedom, RefinedPlan

FREEDOMS: tuple[Freedom, ...] = "planned", "free"
CORRECTIONS = 0, 1, 2, 3

HEAD = (
    "legs | m/s | 95 % m/s | its interval | stand-off, median leg | worst leg | wait | late | "
    "off linear | CPU |"
)


def row(refined: RefinedPlan, found: Dispersion, taken_s: float) -> str:
    """The cells of a table's row, but for its name."""
    need = found.delta_v_m_s
    misses = sorted(leg.standoff_miss_m.value for leg in found.legs)
    return (
        f"{len(refined.legs)} | {found.refined_delta_v_m_s:.1f} | "
        f"{need.value / found.refined_delta_v_m_s - 1.0:+.2%} | "
        f"{need.low:.1f} to {need.high:.1f} | "
        f"{misses[len(misses) // 2]:.0f} m | {misses[-1]:.0f} m | {found.waits_s.value:.0f} s | "
        f"{found.late_share:.1%} | {found.linearity.delta_v_m_s:.2g} m/s, "
        f"{found.linearity.standoff_m:.2g} m | {taken_s:.2f} s |"
    )


def timed(
    instance: adr_opt.Instance, refined: RefinedPlan, flights: int, **options: object
) -> tuple[Dispersion, float]:
    """Flights and the processor time that they take."""
    began = time.process_time()
    found = sample_flights(instance, refined, flights, **options)  # type: ignore[arg-type]
    return found, time.process_time() - began


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="nominal fields, by seed from 0")
    parser.add_argument("--flights", type=int, default=1000)
    arguments = parser.parse_args()
    print(heading())
    fields = [adr_opt.generate("nominal", seed) for seed in range(arguments.seeds)]
    fields.append(adr_opt.generate("cloud", 0))
    print(f"\n{arguments.flights} flights with {FlightErrors()}\n")
    print(f"| field, burns, corrections | {HEAD}\n{'|---' * 11}|")
    kept: list[tuple[adr_opt.Instance, RefinedPlan]] = []
    for field in fields:
        instance = field.replace(dynamics="j2")
        plan = adr_opt.solve(instance, "greedy-guarded", time_limit=100.0, seed=0).plan
        assert plan is not None
        for freedom in FREEDOMS:
            refined = adr_opt.refine(instance, plan, freedom=freedom)
            kept.append((instance, refined))
            sample_flights(instance, refined, 10)  # kernels are loaded
            for corrections in CORRECTIONS if len(kept) <= len(FREEDOMS) else (2,):
                found, taken = timed(instance, refined, arguments.flights, corrections=corrections)
                name = f"{instance.name}, {freedom}, {corrections}"
                print(f"| {name} | {row(refined, found, taken)}", flush=True)
    usual = FlightErrors()
    instance, refined = kept[1]
    print(f"\n{instance.name}, free burns\n\n| errors | {HEAD}\n{'|---' * 11}|")
    for name, errors in (
        ("burn magnitude 2 %", replace(usual, burn_magnitude=0.02)),
        ("pointing 2°", replace(usual, burn_pointing_deg=2.0)),
        (
            "navigation 1 km, 1 m/s",
            replace(usual, navigation_position_m=1000.0, navigation_velocity_m_s=1.0),
        ),
        ("no errors of burns", replace(usual, burn_magnitude=0.0, burn_pointing_deg=0.0)),
    ):
        found, taken = timed(instance, refined, arguments.flights, errors=errors)
        print(f"| {name} | {row(refined, found, taken)}")


if __name__ == "__main__":
    main()
