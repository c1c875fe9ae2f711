"""Known results of GTOC9: the winner's campaign as flown, estimated and re-timed; and ours.

J of the estimate, J re-timed and J of a campaign that was flown are different things.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from adr_opt.common.errors import InputError

from ..tables import Row, head, line
from ..telling import Doing, silent
from . import campaign, debris
from .ephemeris import read_ephemeris
from .estimate import legs_m_s
from .flights import mission_table, report_flights
from .flown import read_flown
from .instance import contest
from .judging import judged
from .retiming import retimed
from .scoring import STAY_D, WITHIN_D, Score, score

PUBLISHED_MEUR = 731.2756
"""J of the winning solution (Petropoulos et al., Acta Futura 11, 2018, 25–35)."""

ROUNDED_D = 0.2
"""Rounding of the file's times to hundredths of a day, accumulated over a mission."""

STEP_D = 0.1


def _line(name: str, found: Score) -> str:
    return (
        f"| {name} | {found.total_meur:.2f} | {max(found.propellant_kg):.0f} | "
        f"{len(found.violations)} |"
    )


BEST = Path(__file__).parent / "best.json"
"""Our best campaign by the estimate."""

FLOWN = Path(__file__).parent / "flown.json"
"""A campaign of ours with all its impulses."""


def flights(
    folder: Path, plan: Path, number: int | None, write: Path | None, doing: Doing = silent
) -> Iterator[str]:
    """A campaign as flown, or one mission of it, in Markdown."""
    rows = debris.read_debris(folder / debris.FILE)
    yield from report_flights(folder / debris.FILE, plan, rows, number, write, doing=doing)


def written(folder: Path, file: Path, step_d: float) -> Iterator[str]:
    """The contest as an instance file, on a grid of connections; a sentence about it.

    Raises
    ------
    InputError
        The step is not above 0, or the file cannot be written.
    """
    if not 0.0 < step_d <= WITHIN_D - STAY_D:
        raise InputError(f"--step {step_d:g}: give days above 0, at most {WITHIN_D - STAY_D:g}")
    made = contest(debris.read_debris(folder / debris.FILE), step_d)
    made.save(file)
    yield f"{file}: {len(made.targets)} targets, connections on a grid of {step_d:g} d"


def judged_again(folder: Path, flown: Path, doing: Doing = silent) -> Iterator[str]:
    """A campaign with its impulses flown once more and scored, in Markdown."""
    rows = debris.read_debris(folder / debris.FILE)
    missions = read_flown(flown, len(rows))
    doing("flying", 0, 1)
    yield from mission_table(missions, read_ephemeris(folder / debris.FILE), rows)


def report(folder: Path, step_d: float = STEP_D, doing: Doing = silent) -> Iterator[str]:
    """The tables, in Markdown, each line as soon as it is known.

    Parameters
    ----------
    folder : Path
    step_d : float
        Of the grid on which missions get better times [d].
    doing : callable
        Hears of each part before it is done.
    """
    rows = debris.read_debris(folder / debris.FILE)
    missions = campaign.read_campaign(folder / campaign.FILE)
    count = len(missions) + 1
    flown = score(missions, [mission.flown_m_s for mission in missions], len(rows), ROUNDED_D)
    as_planned = score(
        missions, [legs_m_s(mission, rows) for mission in missions], len(rows), ROUNDED_D
    )
    legs = sum(len(mission.stops) - 1 for mission in missions)
    yield f"{len(rows)} debris; the winner's {len(missions)} missions with {legs} legs.\n"
    yield "| sequences | J [M€] | most propellant [kg] | rules broken |\n|---|---|---|---|"
    yield _line("the winner's, ΔV as flown", flown)
    yield _line("the winner's, ΔV of the estimate, at its times", as_planned)
    better = []
    for number, mission in enumerate(missions):
        doing("re-timing the winner's", number, count)
        better.append(retimed(mission, rows, step_d))
    best = score(better, [legs_m_s(mission, rows) for mission in better], len(rows), ROUNDED_D)
    yield _line(
        f"the winner's, ΔV of the estimate, re-timed within each mission to {step_d:g} d", best
    )
    row = Row("GTOC9", PUBLISHED_MEUR, flown.total_meur)
    broken = [*flown.violations, *as_planned.violations, *best.violations]
    if BEST.is_file():
        kept = campaign.read_campaign(BEST)
        known = score(kept, [legs_m_s(mission, rows) for mission in kept], len(rows))
        name = f"kept in `{BEST.name}`, {len(kept)} missions"
        yield _line(f"ours {name}, ΔV of the estimate", known)
        row = replace(row, ours=known.total_meur)
        broken += known.violations
    doing("flying", count - 1, count)
    if FLOWN.is_file():
        whole = judged(read_flown(FLOWN, len(rows)), read_ephemeris(folder / debris.FILE))
        yield _line(f"ours of `{FLOWN.name}`, flown with the full J2", whole.score)
        broken += whole.violations
    yield ""
    yield head("M€")
    yield line(row, ".2f")
    yield from dict.fromkeys(broken)
