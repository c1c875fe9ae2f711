"""Options of ``generate`` and ``import`` for tanks, kits and tows."""

from __future__ import annotations

from collections.abc import Callable

from . import take


def fitting_options(usual: str) -> Callable[[take.Function], take.Function]:
    """The options of tanks, kits and tows; ``usual`` is the ΔV of a tank by default."""
    return take.together(
        take.number("--delta-v", "M_S", f"ΔV of a full tank; {usual}."),
        take.number("--dry-mass", "KG", "For a tank by mass: mass without propellant."),
        take.number("--propellant", "KG", "For a tank by mass: propellant when full."),
        take.number("--isp", "S", "For a tank by mass: specific impulse."),
        take.count("--kits", "K", "Each target needs a kit; at most K aboard."),
        take.number("--kit-mass", "KG", "Mass of a kit; default 0."),
        take.number("--tow", "KG", "Mass of each target, which is to be towed."),
        take.number(
            "--disposal-altitude", "KM", "Altitude of the circular orbit that targets are towed to."
        ),
    )
