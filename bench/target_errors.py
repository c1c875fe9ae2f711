"""What errors of where targets are cost a refined plan at 95 %, and when it is known how much.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/target_errors.py

Two catalogues of Iridium 33, of February and April 2025, give element sets of two epochs. The 60
targets with the nearest planes of the first one, for a week, are planned by ``beam`` and refined
onto SGP4; a thousand flights with the default errors follow: with every body where it is planned,
and with errors that the two catalogues show, by the time before the stand-off from which it is
known where the target is.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.dispersion import Dispersion, sample_flights
from adr_opt.sources import catalogue
from adr_opt.sources.ephemerides.imported import with_ephemerides
from adr_opt.sources.uncertainty import SetsCompared, compared

TARGETS, DAYS, FLIGHTS = 60, 7.0, 1000
BEFORE_S = (2.0 * DAY_S, DAY_S, 12000.0, None, 3000.0, 1500.0)


def main() -> None:
    """Measure and print."""
    folder = Path(os.environ["ADR_OPT_EXTERNAL_DATA"])
    files = [*folder.glob("tle/*iridium-33*"), *folder.glob("omm/*iridium-33*")]
    print(f"{heading()}\n")
    made = catalogue.to_instance(
        catalogue.read(files[0], skip_bad=True),
        max_targets=TARGETS,
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=DAYS * DAY_S),
    )
    with tempfile.TemporaryDirectory() as beside:
        path = Path(beside) / "field.json"
        with_ephemerides(made, path).write(path)
        instance = adr_opt.load(path)
        plan = adr_opt.solve(instance, method="beam", time_limit=60.0).plan
        refined = adr_opt.refine(instance, plan, ephemerides=True)
        shown = compared(instance, files)
        _print_shown(shown)
        print(
            "\n| known before the stand-off | 95 % m/s | its interval | over refined "
            "| over planned places m/s | worst leg m/s | stand-off, worst leg m | late "
            "| off linear |\n|---|---|---|---|---|---|---|---|---|"
        )
        sure = sample_flights(instance, refined, FLIGHTS)
        print(f"| where they are planned | {_row(sure, sure)}")
        for before_s in BEFORE_S:
            found = sample_flights(
                instance, refined, FLIGHTS, targets=shown.errors, known_before_s=before_s
            )
            said = "a revolution" if before_s is None else f"{before_s:g} s"
            print(f"| {said} | {_row(found, sure)}", flush=True)
        far = sorted(
            (leg.target_off_m.value / 1e3, leg.destination)
            for leg in found.legs
            if leg.target_off_m is not None
        )
    print(
        f"\nAt 95 % targets are {far[len(far) // 2][0]:.1f} km off in the median, and at most "
        f"{far[-1][0]:.0f} km ({far[-1][1]})."
    )


def _print_shown(shown: SetsCompared) -> None:
    print(
        f"{len(shown.differences)} objects compared, {shown.median_age_days:.1f} days apart in the "
        f"median; {len(shown.by_median)} by the median, {len(shown.by_largest)} by the largest\n\n"
        "| 1σ | median | 90 % | largest |\n|---|---|---|---|"
    )
    growths = [shown.growths[body] for body in shown.differences]
    for field in growths[0]._fields:
        values = sorted(getattr(growth, field) for growth in growths)
        nine = values[int(0.9 * (len(values) - 1))]
        print(f"| {field} | {values[len(values) // 2]:.4g} | {nine:.4g} | {values[-1]:.4g} |")


def _row(found: Dispersion, sure: Dispersion) -> str:
    need, linear = found.delta_v_m_s, found.linearity
    more = max(
        leg.delta_v_m_s.value - other.delta_v_m_s.value
        for leg, other in zip(found.legs, sure.legs, strict=True)
    )
    return (
        f"{need.value:.1f} | {need.low:.1f} to {need.high:.1f} "
        f"| {need.value / found.refined_delta_v_m_s - 1.0:+.2%} "
        f"| {need.value - sure.delta_v_m_s.value:.1f} | {more:.1f} "
        f"| {max(leg.standoff_miss_m.value for leg in found.legs):.0f} | {found.late_share:.1%} "
        f"| {linear.delta_v_m_s:.2g} m/s, {linear.standoff_m:.2g} m |"
    )


if __name__ == "__main__":
    main()
