"""Reasons why removing an object is worth much, in one clause each."""

from __future__ import annotations

from .worth import RemovalWorth

SHORT = 0.9
"""Share of the horizon that an object has to stay for its own decay not to matter."""


def figure(value: float) -> str:
    """A number with four digits, or all those before the point."""
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.4g}"


def reason(worth: RemovalWorth, at: int) -> str:
    """Mass, encounters and stay of an object, and the object most dangerous to it."""
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
