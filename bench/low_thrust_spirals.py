"""Tows by spirals: how much longer than planned they take to end on a circle.

    python bench/low_thrust_spirals.py

Tows are drawn of the family `electric`: an object, a time of the mission, and a chaser with a full
tank. Each spiral may begin as early as it has to for a circle in the integrated flight under J2, in
steps of 6 % of its duration. The table has the durations over the planned one.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.refine.bodies import TrueBodies, near_circle, state_of
from adr_opt.fly.refine.spiral import NoSpiral, SpiralTow, towed_by_spiral
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.thrusting import Push
from adr_opt.plan.tows import removals_by_name
from adr_opt.problem.drives import drive_of, since_j2000_s

CIRCLE = 0.001
"""Largest mean eccentricity of a release."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tows", type=int, default=60, help="drawn tows")
    options = parser.parse_args()
    print(heading())
    rng, ratios, eccentric, missing = np.random.default_rng(5), [], 0, 0
    begun = time.process_time()
    for number in range(options.tows):
        instance = adr_opt.generate("electric", number % 20)
        drive = drive_of(instance.chasers[0], instance.targets)
        assert drive is not None
        target = instance.targets[rng.integers(len(instance.targets))]
        planned = removals_by_name(instance, drive)[target.name]
        end_s = float(rng.uniform(300.0 * DAY_S, instance.mission.duration_s))
        push = Push(
            drive.thrust_n,
            drive.exhaust_m_s,
            drive.heaviest_kg + planned.object_kg,
            since_j2000_s(instance.epoch),
        )
        tow = SpiralTow(
            target.name,
            0.0,
            end_s - planned.time_s,
            end_s,
            planned.radius_m,
            planned.delta_v_m_s,
            push,
        )
        bodies = TrueBodies(instance, "j2", [target.name])
        try:
            flown = towed_by_spiral(bodies, tow)
        except NoSpiral:
            missing += 1
            continue
        mean = near_circle(state_of(flown.released), FIELDS["j2"])
        if math.hypot(mean[1], mean[2]) > CIRCLE:
            eccentric += 1
            continue
        ratios.append((end_s - flown.start_s) / planned.time_s)
    parts = np.quantile(ratios, [0.0, 0.25, 0.5, 0.75, 0.9, 1.0])
    print(
        "\n| tows | least | quarter | median | three quarters | nine tenths | most | eccentric "
        "| none | within 1.0 | 1.1 | 1.25 | 1.4 | processor time |"
    )
    print("|" + "---|" * 14)
    within = [f"{np.mean(np.array(ratios) <= most + 0.005):.0%}" for most in (1.0, 1.1, 1.25, 1.4)]
    print(
        f"| {options.tows} | "
        + " | ".join(f"{part:.2f}" for part in parts)
        + f" | {eccentric} | {missing} | "
        + " | ".join(within)
        + f" | {time.process_time() - begun:.0f} s |"
    )


if __name__ == "__main__":
    main()
