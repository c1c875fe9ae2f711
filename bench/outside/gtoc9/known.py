"""What is known of GTOC9: the winner's campaign as flown, by the estimate, and re-timed."""

from __future__ import annotations

from pathlib import Path

from ..tables import Row, table
from . import campaign, debris
from .estimate import legs_m_s
from .retiming import retimed
from .scoring import Score, score

PUBLISHED_MEUR = 731.2756
"""J of the winning solution (Petropoulos et al., Acta Futura 11, 2018, 25–35)."""

ROUNDED_D = 0.2
"""Times of the file are rounded to a hundredth of a day, those of a mission one after another."""

STEP_D = 0.1


def _line(name: str, found: Score) -> str:
    return (
        f"| {name} | {found.total_meur:.2f} | {max(found.propellant_kg):.0f} | "
        f"{len(found.violations)} |"
    )


def report(folder: Path, step_d: float = STEP_D) -> str:
    """The tables, in Markdown."""
    rows = debris.read_debris(folder / debris.FILE)
    missions = campaign.read_campaign(folder / campaign.FILE)
    flown = score(missions, [mission.flown_m_s for mission in missions], len(rows), ROUNDED_D)
    planned = score(
        missions, [legs_m_s(mission, rows) for mission in missions], len(rows), ROUNDED_D
    )
    better = [retimed(mission, rows, step_d) for mission in missions]
    best = score(better, [legs_m_s(mission, rows) for mission in better], len(rows), ROUNDED_D)
    legs = sum(len(mission.stops) - 1 for mission in missions)
    lines = [
        f"{len(rows)} debris; the winner's {len(missions)} missions with {legs} legs.",
        "",
        "| the winner's sequences | J [M€] | most propellant [kg] | rules broken |",
        "|---|---|---|---|",
        _line("ΔV as flown", flown),
        _line("ΔV of the estimate, at its times", planned),
        _line(f"ΔV of the estimate, re-timed within each mission to {step_d:g} d", best),
        "",
        table([Row("GTOC9", PUBLISHED_MEUR, flown.total_meur)], "M€", ".2f"),
    ]
    broken = dict.fromkeys((*flown.violations, *planned.violations, *best.violations))
    return "\n".join([*lines, *broken])
