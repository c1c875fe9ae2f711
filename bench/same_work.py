"""Results of `auto` and `exact` under limits in work: plans, labels, certificates, by commit.

    python bench/same_work.py --out before.json
    python bench/same_work.py --against before.json

Iterations and labels are limited and time is not, so that a change of code that is not to change
what comes out can be judged by it: each line is a field, a method and a digest of routes, bound,
counters and certificate. With ``--against``, the status is 1 where a line differs or is new.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tables import experiment

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.certify import certificate_of

FIELDS = {
    **dict.fromkeys(("tiny", "nominal", "reduced-time", "reduced-fuel", "campaign", "cloud"), 5),
    **dict.fromkeys(("sso", "rocket-bodies", "removal", "electric", "fragment-cloud"), 5),
    "large": 5,
}
"""Number of fields by family."""

WORK = {"auto": 2, "exact": 3}
"""Iterations by method."""

LABELS = 100_000
"""Maximum number of labels per search."""

LIMIT_S = 3600.0


def lines(families: list[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Results, field by field."""
    for family in families:
        for seed in range(FIELDS[family]):
            instance = adr_opt.generate(family, seed)
            for method, iterations in WORK.items():
                result = adr_opt.solve(
                    instance,
                    method,
                    time_limit=LIMIT_S,
                    iterations=iterations,
                    jobs=1,
                    most_labels=LABELS,
                )
                yield f"{instance.name} {method}", _line(instance, result)


def _line(instance: adr_opt.Instance, result: adr_opt.Result) -> dict[str, Any]:
    """Routes, schedule, bound, counters and certificate, by their digests."""
    legs = [
        (route.chaser, leg.destination, leg.departure_s, leg.delta_v_m_s)
        for route in ([] if result.plan is None else result.plan.routes)
        for leg in route.legs
    ]
    try:
        certificate = certificate_of(instance, result)
        stated: Any = certificate.model_dump(mode="json", exclude={"plan_sha256"})
    except InputError as error:
        stated = str(error)
    return {
        "objective": result.objective,
        "upper_bound": str(result.upper_bound),
        "counters": dict(result.counters),
        "plan": _digest(legs),
        "certificate": _digest(stated),
    }


def _digest(what: Any) -> str:
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:16]


def same(*families: str, out: Path | None = None, against: Path | None = None) -> int:
    """Print the lines of some families, or all, and what differs from those of another commit."""
    before = json.loads(against.read_text()) if against else {}
    found, equal = {}, 0
    for name, line in lines(list(families or FIELDS)):
        found[name] = line
        was = before.get(name)
        equal += was == line
        told = "" if not before else "same" if was == line else f"before: {was}"
        print(
            f"{name:28} {line['plan']} {line['objective']:g} of {line['upper_bound']}, "
            f"{line['counters'].get('labels', 0):,.0f} labels  {told}",
            flush=True,
        )
    if out:
        out.write_text(json.dumps(found, indent=1) + "\n")
    if against:
        print(f"{equal} of {len(found)} are the same")
    return int(bool(before) and equal < len(found))


if __name__ == "__main__":
    sys.exit(experiment(__doc__, same))
