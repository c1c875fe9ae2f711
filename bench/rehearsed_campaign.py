"""A campaign on a real catalogue, planned plainly and with a confidence, and rehearsed.

    python bench/rehearsed_campaign.py CATALOGUE --time-limit 60 --replanned 20 --worlds 5

Three chasers are launched three days apart among the 40 objects of the densest plane, each with
1,000 m/s, for two weeks. Legs cost a factor of lognormal spread 0.05, services take one of 0.2, a
capture succeeds with a chance of 0.9, two tries. Both plans are followed, and replanned when
something goes otherwise; the gap is that to the bound on every policy of which penalties have taken
out the luck of captures. With ``--out`` the rehearsals of the robust plan are written as a page.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.analysis.rehearse.bounds import bounds
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.robust.robust import robust
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.ui.report.plain import write_page
from adr_opt.ui.report.rehearsed import rehearsed_page

UNCERTAIN = Uncertainty(
    legs={"delta_v_factor": {"lognormal_sigma": 0.05}},
    service_s={"factor": {"lognormal_sigma": 0.2}},
    capture={"success": 0.9, "tries": 2},
)

CREW = (
    "--max-targets",
    "40",
    "--duration-days",
    "14",
    "--launches",
    "3",
    "--launch-every",
    "3",
    "--delta-v",
    "1000",
    "--no-refuelling",
    "--dynamics",
    "j2",
)


def campaign(catalogue: str) -> Instance:
    """The campaign, as ``import`` makes it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "campaign.json"
        command = [sys.executable, "-m", "adr_opt", "import", catalogue, *CREW, "--out", str(path)]
        subprocess.run(command, check=True)
        return adr_opt.load(path)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("catalogue")
    parser.add_argument("--time-limit", type=float, default=60.0)
    parser.add_argument("--followed", type=int, default=2000)
    parser.add_argument("--replanned", type=int, default=20)
    parser.add_argument("--worlds", type=int, default=5)
    parser.add_argument("--bound-time-limit", type=float, default=20.0)
    parser.add_argument("--out")
    asked = parser.parse_args()
    instance = campaign(asked.catalogue)
    print(heading())
    plain = adr_opt.solve(instance, time_limit=asked.time_limit).plan
    made = robust(instance, UNCERTAIN, 0.95, time_limit=asked.time_limit)
    for note in made.notes:
        print(f"robust: {note}")
    bounded = bounds(instance, UNCERTAIN, samples=asked.worlds, time_limit=asked.bound_time_limit)
    print("\n| plan | policy | rehearsals | planned | prize | as planned | gap |")
    print("|---|---|---|---|---|---|---|")
    lost = []
    for name, plan in (("plain", plain), ("robust", made.plan)):
        if plan is None:
            continue
        for policy, samples in (("follow", asked.followed), ("replan", asked.replanned)):
            flown = rehearse(instance, plan, UNCERTAIN, policy=policy, samples=samples)
            told, gaps = flown.to_dict(), bounded.gaps(flown)
            gap = gaps.get("penalised", gaps["perfect"])["gap"]
            prize = told["expected_prize"]
            print(
                f"| {name} | `{policy}` | {samples} | {plan.objective:g} | {prize['mean']:.2f} "
                f"± {prize['standard_error']:.2f} | {told['as_planned']['share']:.1%} | "
                f"{gap:.1%} |",
                flush=True,
            )
            reasons = Counter(told["losses"])
            said = ", ".join(f"{reason} {number:.2f}" for reason, number in reasons.most_common(4))
            lost.append(f"{name}, {policy}: {said or 'nothing'}")
            if asked.out and name == "robust" and policy == "follow":
                write_page(asked.out, rehearsed_page(flown, told))
    print("\nLost on average, by reason:")
    print("\n".join(lost))


if __name__ == "__main__":
    main()
