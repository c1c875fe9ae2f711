"""The output of ``worth`` as plain data."""

from __future__ import annotations

from collections import Counter
from typing import Any

from .prizes import RemovalPrizes, reference
from .satcat import Satcat
from .worth import UNIT, RemovalWorth

SHORT = 0.9
"""Share of the horizon above which an object's own decay does not matter."""


def figure(value: float) -> str:
    """A number with four digits, or all those before the point."""
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.4g}"


def reason(worth: RemovalWorth, at: int) -> str:
    """Reasons of a worth: mass, encounters, lifetime, and the most dangerous other object."""
    bodies = worth.bodies
    encounters, catastrophic = worth.encounters[at], worth.catastrophic[at]
    parts = [
        f"{figure(bodies.masses[at])} kg ({bodies.mass_sources[at]})",
        f"{1e3 * encounters:.3g} encounters in 1,000 years"
        + (f", {catastrophic / encounters:.0%} catastrophic" if encounters else ""),
    ]
    if worth.lives[at] < SHORT * worth.years:
        parts.append(f"comes down in {worth.lives[at]:.2g} years")
    partner = int(worth.partners[at])
    if partner >= 0:
        share = worth.partner_worths[at] / worth.alone[at]
        parts.append(f"most with {bodies.records[partner].label} ({share:.1%})")
    return "; ".join(parts)


LISTED = 10
"""Number of objects listed with their reasons."""

SETS = (10, 50)
"""Sizes of the sets whose worth is reported."""


def answer(prizes: RemovalPrizes, satcat: Satcat | None) -> dict[str, Any]:
    """Sums, sources, the best objects with reasons, and worths of sets."""
    worth = prizes.worth
    bodies = worth.bodies
    ranks = {int(at): place for place, at in enumerate(prizes.candidates)}
    return {
        "objects": len(bodies),
        "left_out": bodies.left_out,
        "years": worth.years,
        "activity": worth.activity,
        "unit": {"value": prizes.unit, "of": UNIT},
        "total": worth.total,
        "catastrophic_per_year": 0.5 * float(worth.catastrophic.sum()),
        "satcat": None
        if satcat is None
        else {"objects": len(satcat), "updated": satcat.updated, "matched": bodies.matched},
        "masses": dict(Counter(bodies.mass_sources)),
        "default_masses": bodies.default_masses,
        "sizes": dict(Counter(bodies.size_sources)),
        "areas": dict(Counter(bodies.area_sources)),
        "candidates": len(prizes.candidates),
        "best": [
            {
                "object": reference(bodies.records[at]),
                "name": bodies.records[at].label,
                "prize": float(prizes.prizes[ranks[at]]),
                "worth_alone": float(worth.alone[at]),
                "floor": float(prizes.floors[ranks[at]]),
                "reason": reason(worth, at),
            }
            for at in map(int, prizes.candidates[:LISTED])
        ],
        "sets": [_set(prizes, ranks, size) for size in SETS if size <= len(prizes.candidates)],
    }


def _set(prizes: RemovalPrizes, ranks: dict[int, int], size: int) -> dict[str, Any]:
    worth = prizes.worth
    chosen = worth.best_set(size, prizes.candidates)
    avoided = worth.of_set(chosen)
    return {
        "size": size,
        "worth": avoided,
        "share": avoided / worth.total if worth.total else 0.0,
        "sum_alone": float(worth.alone[chosen].sum()),
        "sum_floors": float(sum(prizes.floors[ranks[at]] for at in chosen)),
        "objects": [reference(worth.bodies.records[at]) for at in chosen],
    }
