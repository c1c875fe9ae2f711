r"""From the rocket bodies of a catalogue to a year's mission, proven, and its page: one command.

    python examples/rocket-bodies/plan_a_year.py catalogue.tle --out sl-16
    python examples/rocket-bodies/plan_a_year.py examples/rocket-bodies/bodies.tle \
        --name "SYNTHETIC R/B" --out made-up

The catalogue is a file of your own, TLE or OMM; the second command takes a made-up one. Nobody
refuels, and the chaser starts in the densest plane. The folder gets mission.json, plan.json and
page.html.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import adr_opt
from adr_opt.common.wording import status_words
from adr_opt.problem.chasers import Tank
from adr_opt.sources import catalogue
from adr_opt.ui.report import write_report

DAY_S = 86400.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan what the arguments say; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help="catalogue, TLE or OMM")
    parser.add_argument("--name", default="SL-16 R/B", help="part of the names to keep")
    parser.add_argument("--days", type=float, default=365.0, help="duration of the mission")
    parser.add_argument("--delta-v", type=float, default=3000.0, help="full tank, m/s")
    parser.add_argument("--time-limit", type=float, default=60.0, help="seconds for plan and proof")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    typed = parser.parse_args(arguments)
    try:
        made = catalogue.to_instance(
            catalogue.read(typed.files, skip_bad=True),
            filters=catalogue.Filters(names=(typed.name,)),
            skip_bad=True,
            mission=catalogue.MissionOutline(duration_s=DAY_S * typed.days, refuelling=False),
            crew=catalogue.Crew(Tank(delta_v_m_s=typed.delta_v)),
        )
        for warning in made.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        result = adr_opt.solve(made.instance, time_limit=typed.time_limit)
        plan = result.plan
        if plan is None:
            raise adr_opt.InputError(f"no plan: status {result.status}; raise --time-limit")
        violations = adr_opt.check(made.instance, plan)
        typed.out.mkdir(parents=True, exist_ok=True)
        (typed.out / "mission.json").write_text(made.instance.to_json(), encoding="utf-8")
        plan.save(typed.out / "plan.json")
        write_report(made.instance, plan, typed.out / "page.html")
    except (adr_opt.InputError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    most = min(result.upper_bound, float(len(made.instance.targets)))
    visits = f"{plan.objective:g} of {len(made.instance.targets)} visits"
    print(
        f"{visits} with {plan.delta_v_m_s:.0f} m/s, "
        f"at most {most:g} ({status_words(plan.status)}), "
        f"{len(violations)} violations: {typed.out / 'page.html'}"
    )
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
