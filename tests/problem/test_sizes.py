"""How transfers are laid out by the length of a mission, and what `import` makes of it."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import as_csv, field
from conftest import Cli
from drifting_plans import orbit

import adr_opt
from adr_opt.common.constants import DAY_S, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.problem.settings import TransferSettings
from adr_opt.problem.transfer_sizes import SHORT_S, phase_period_s, told, transfers_for


@pytest.fixture
def catalogue(cli: Cli) -> str:
    """A small catalogue in the folder of the test."""
    Path("a.csv").write_text(as_csv(field(30)), encoding="utf-8")
    return "a.csv"


@pytest.mark.parametrize("days", [0.01, 1.0, 7.0, 14.0])
def test_short_missions_drift_nowhere(days: float) -> None:
    """Up to two weeks a file says nothing about the grid: every crossing, no long transfers."""
    assert transfers_for(days * DAY_S) == TransferSettings()


@pytest.mark.parametrize("days", [14.1, 30.0, 90.0, 365.0, 730.0, 3650.0, 36500.0])
def test_long_missions_have_a_grid_in_proportion(days: float) -> None:
    """Steps are about a 150th of the mission and no less than a day, departures come in between."""
    made = transfers_for(days * DAY_S)
    step = made.drift_step_s / DAY_S
    assert step >= 1.0
    assert 2.0 * step == round(2.0 * step)
    assert step == 1.0 or days / step == pytest.approx(150.0, rel=0.15)
    assert made.max_drift_s == days * DAY_S
    assert 0.2 * step <= made.departure_spacing_s / DAY_S <= 0.5 * step
    assert 0.1 <= made.delta_v_resolution_m_s <= 5.0
    assert days < 365.0 or made.delta_v_resolution_m_s == 5.0


@pytest.mark.parametrize(
    ("altitudes_km", "days"), [((750, 950), 0.5), ((770, 860), 1.0), ((790, 800), 2.0)]
)
def test_steps_of_weeks_follow_the_phase(altitudes_km: tuple[float, float], days: float) -> None:
    """Where phases come back soon steps are short, as a share of that period."""
    orbits = [orbit(altitude, 86.4, 0.0) for altitude in altitudes_km]
    assert transfers_for(40.0 * DAY_S, orbits=orbits).drift_step_s == days * DAY_S
    # Half a lap in as many days as the period has: the mean motions differ by that much.
    motions = [math.sqrt(MU_M3_S2 / one.semi_major_axis_m**3) for one in orbits]
    period = phase_period_s(orbits)
    assert period == pytest.approx(2.0 * math.pi / (motions[0] - motions[1]), rel=0.01)
    assert transfers_for(1500.0 * DAY_S, orbits=orbits).drift_step_s == 10.0 * DAY_S


def test_orbits_alike_have_no_phase_to_wait_for() -> None:
    """One body has no period, and bodies on one orbit an infinite one."""
    one = orbit(800, 71.0, 0.0)
    assert phase_period_s([one]) is None
    assert phase_period_s([one, one]) == math.inf
    assert transfers_for(40.0 * DAY_S, orbits=[one, one]).drift_step_s == 2.0 * DAY_S


def test_the_median_of_large_fields_is_near_that_of_all() -> None:
    """A sample of thousands of bodies tells the period as all pairs do."""
    rng = np.random.default_rng(0)
    orbits = [orbit(altitude, 86.4, 0.0) for altitude in rng.uniform(600.0, 900.0, 1400)]
    sampled = phase_period_s(orbits)
    few = phase_period_s(orbits[:450])
    assert sampled == pytest.approx(few, rel=0.1)


def test_a_file_without_a_grid_gets_one_by_its_mission() -> None:
    """`drift_step_s` that is left out follows from the mission; without drift legs it is a day."""
    field = adr_opt.generate("sso", 0)
    content = json.loads(field.to_json())
    content["mission"]["duration_s"] = 900.0 * DAY_S
    del content["transfer"]["drift_step_s"]
    assert adr_opt.load(content).transfer.drift_step_s == 6.0 * DAY_S
    content["transfer"]["max_drift_s"] = 0.0
    assert adr_opt.load(content).transfer.drift_step_s == DAY_S


def test_longer_missions_are_never_laid_out_finer() -> None:
    """Step, spacing and resolution grow with the length of the mission, or stay."""
    made = [transfers_for(days * DAY_S) for days in range(1, 1500, 7)]
    for short, long in pairwise(made):
        assert short.departure_spacing_s <= long.departure_spacing_s
        assert short.delta_v_resolution_m_s <= long.delta_v_resolution_m_s
        assert short.drift_step_s <= long.drift_step_s or short.max_drift_s == 0.0


def test_what_is_given_counts() -> None:
    """Numbers that are given replace those by the length, also 0; the spacing follows a step."""
    made = transfers_for(
        365.0 * DAY_S, drift_step_s=10.0 * DAY_S, max_drift_s=0.0, delta_v_resolution_m_s=0.0
    )
    assert made.drift_step_s == 10.0 * DAY_S
    assert made.max_drift_s == made.delta_v_resolution_m_s == 0.0
    assert made.departure_spacing_s == 4.0 * DAY_S
    assert transfers_for(DAY_S, max_drift_s=SHORT_S).max_drift_s == SHORT_S
    assert transfers_for(365.0 * DAY_S, departure_spacing_s=7.0).departure_spacing_s == 7.0
    with pytest.raises(InputError, match="drift_step_s"):
        transfers_for(DAY_S, drift_step_s=0.0)


def test_sizes_are_told_in_words() -> None:
    """The words name what is in the settings, and what is not there."""
    assert told(TransferSettings()) == "no long transfers, every departure, ΔV to 0.1 m/s"
    assert told(transfers_for(365.0 * DAY_S)) == (
        "long transfers of up to 365 days in steps of 2.5 days, departures of a pair at least "
        "1 day apart, ΔV to 5 m/s"
    )


def test_an_import_drifts_unless_it_is_told_otherwise(cli: Cli, catalogue: str) -> None:
    """The instance has the dynamics of the call, j2 by default, and the sizes by its duration."""
    outcome = cli("import", catalogue, "--out", "out.json", "--duration-days", "200", "--json")
    assert outcome.status == 0
    made = adr_opt.load("out.json")
    assert made.dynamics == "j2"
    bodies = [target.orbit for target in made.targets]
    assert made.transfer == transfers_for(200.0 * DAY_S, orbits=bodies)
    assert f"dynamics j2: {told(made.transfer)}" in outcome.err
    account = json.loads(outcome.out)
    assert account["dynamics"] == "j2"
    assert account["transfer"] == made.transfer.model_dump(mode="json")
    assert "warning: nodes drift" not in outcome.err
    outcome = cli("import", catalogue, "--out", "out.json", "--dynamics", "two-body")
    made = adr_opt.load("out.json")
    assert made.dynamics == "two-body"
    assert made.transfer == TransferSettings()
    assert "dynamics two-body: no long transfers" in outcome.err
    assert "warning: nodes drift" in outcome.err


def test_sizes_are_set_by_hand(cli: Cli, catalogue: str) -> None:
    """Each option of an import reaches its field, in days or m/s."""
    outcome = cli(
        f"import {catalogue} --out out.json --drift-step-days 3 --max-drift-days 60 "
        "--departure-spacing-days 0.5 --resolution 2.5 --duration-days 100"
    )
    assert outcome.status == 0
    made = adr_opt.load("out.json").transfer
    assert made == TransferSettings(
        drift_step_s=3 * DAY_S,
        max_drift_s=60 * DAY_S,
        departure_spacing_s=0.5 * DAY_S,
        delta_v_resolution_m_s=2.5,
    )


def test_without_refuelling_there_is_no_station(cli: Cli, catalogue: str) -> None:
    """The chaser starts in the orbit where the station would be, and the account says so."""
    cli("import", catalogue, "--out", "with.json", "--station", "750,86.4,10")
    outcome = cli(f"import {catalogue} --out out.json --station 750,86.4,10 --no-refuelling --json")
    assert outcome.status == 0
    made, other = adr_opt.load("out.json"), adr_opt.load("with.json")
    assert made.stations == ()
    assert made.start_bodies == {"chaser": other.stations[0].orbit}
    assert made.targets == other.targets
    account = json.loads(outcome.out)
    assert "station" not in account
    assert account["start"]["name"] == "chaser"
    assert "start as told: altitude 750.0 km" in outcome.err


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--drift-step-days", "0"], "--drift-step-days = 0: must be a number of at least 0.01"),
        (["--drift-step-days", "nan"], "--drift-step-days = nan: must be a number"),
        (["--max-drift-days", "-1"], "--max-drift-days = -1: must be a number of at least 0"),
        (["--departure-spacing-days", "inf"], "--departure-spacing-days = inf: must be a number"),
        (["--resolution", "-0.1"], "--resolution = -0.1: must be a number of at least 0"),
        (["--dynamics", "j3"], "'j3' is not one of"),
        (
            ["--dynamics", "two-body", "--max-drift-days", "9"],
            "--max-drift-days = 9: no plane drifts in two-body motion; leave it out",
        ),
        (
            ["--dynamics", "two-body", "--drift-step-days", "9"],
            "--drift-step-days = 9: no plane drifts in two-body motion",
        ),
        (["--duration-days", "1e6"], "--duration-days = 1e+06: must be at most 36525"),
    ],
)
def test_sizes_that_make_no_sense(cli: Cli, catalogue: str, options: list[str], named: str) -> None:
    """Each is refused in one sentence that names the option and its value; nothing is written."""
    outcome = cli("import", catalogue, "--out", "out.json", *options)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert named in outcome.err
    assert not Path("out.json").exists()
