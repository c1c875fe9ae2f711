"""Known results of GTOC9: the winner's campaign as flown and estimated; and ours.

J of the estimate and J of a campaign that was flown are different things.
"""

from __future__ import annotations

from pathlib import Path

from tables import head, row

from adr_opt.common.errors import InputError

from . import campaign, debris
from .ephemeris import read_ephemeris
from .estimate import legs_m_s
from .expense import expense_meur, launched_kg
from .flown import read_flown
from .instance import contest
from .judging import judged
from .scoring import STAY_D, WITHIN_D, score

PUBLISHED_MEUR = 731.2756
"""J of the winning solution (Petropoulos et al., Acta Futura 11, 2018, 25–35)."""

ROUNDED_D = 0.2
"""Rounding of the file's times to hundredths of a day, accumulated over a mission."""

HERE = Path(__file__).parent


def write_instance(folder: Path, file: Path, step_d: float) -> None:
    """Write the contest as an instance file, on a grid of connections.

    Raises
    ------
    InputError
        The step is not above 0, or the file cannot be written.
    """
    if not 0.0 < step_d <= WITHIN_D - STAY_D:
        raise InputError(f"--step {step_d:g}: give days above 0, at most {WITHIN_D - STAY_D:g}")
    made = contest(debris.read_debris(folder / debris.FILE), step_d)
    made.save(file)
    print(f"{file}: {len(made.targets)} targets, connections on a grid of {step_d:g} d")


def judge(folder: Path, flown: Path) -> None:
    """Print a campaign with its impulses, flown once more and scored, mission by mission."""
    rows, bodies = debris.read_debris(folder / debris.FILE), read_ephemeris(folder / debris.FILE)
    missions = read_flown(flown, len(rows))
    head(
        *("mission", "begins [MJD2000]", "debris", "estimate [M€]", "flown [M€]"),
        *("propellant [kg]", "off [m]", "off [m/s]", "lowest perigee [km]"),
    )
    whole, estimates = judged(missions, bodies), list[float]()
    for number, (mission, legs) in enumerate(zip(missions, whole.legs, strict=True)):
        estimates.append(expense_meur(launched_kg(legs_m_s(mission.removals, rows))))
        row(
            number,
            f"{mission.removals.begin_d:.1f}",
            len(mission.removals.stops),
            f"{estimates[-1]:.2f}",
            f"{whole.score.missions_meur[number]:.2f}",
            f"{whole.score.propellant_kg[number]:.0f}",
            f"{max((leg.miss_m for leg in legs), default=0.0):.1e}",
            f"{max((leg.miss_m_s for leg in legs), default=0.0):.1e}",
            f"{min((leg.perigee_m for leg in legs), default=float('nan')) / 1e3:.0f}",
        )
    print(
        f"\n{sum(map(len, whole.legs))} legs. J is {sum(estimates):.2f} M€ by the estimate at "
        f"these times and {whole.score.total_meur:.2f} M€ flown; {len(whole.violations)} rules "
        "broken.",
        *whole.violations,
        sep="\n",
    )


def report(folder: Path) -> None:
    """Print J of the winner's campaign, as flown and by the estimate, and of ours."""
    rows = debris.read_debris(folder / debris.FILE)
    winner = campaign.read_campaign(folder / campaign.FILE)
    ours = campaign.read_campaign(HERE / "best.json")
    flown = judged(read_flown(HERE / "flown.json", len(rows)), read_ephemeris(folder / debris.FILE))
    print(f"{len(rows)} debris. The winner's J as published: {PUBLISHED_MEUR:.2f} M€.")
    head("sequences", "J [M€]", "most propellant [kg]", "rules broken")
    theirs, own = ([legs_m_s(mission, rows) for mission in each] for each in (winner, ours))
    published = [mission.flown_m_s for mission in winner]
    for name, found in (
        ("the winner's, ΔV as flown", score(winner, published, len(rows), ROUNDED_D)),
        ("the winner's, ΔV of the estimate", score(winner, theirs, len(rows), ROUNDED_D)),
        ("ours of `best.json`, ΔV of the estimate", score(ours, own, len(rows))),
        ("ours of `flown.json`, flown with the full J2", flown.score),
    ):
        broken = len(found.violations)
        row(name, f"{found.total_meur:.2f}", f"{max(found.propellant_kg):.0f}", broken)
    print(*flown.violations, sep="\n")
