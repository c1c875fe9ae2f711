"""What plans leave out is said: objects that drag moves far, missions too short for any leg."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import as_tle, field
from conftest import Cli

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.legs.service_limits import limits_of
from adr_opt.problem.least_time import least_end_s, too_short
from adr_opt.sources.catalogue import read, to_instance
from adr_opt.sources.catalogue.drag import DECAYS, along_track_km, drag_warning
from adr_opt.sources.catalogue.propagation import satellite_of

ROOT = Path(__file__).parents[2]
EXTERNAL = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ROOT / "../shared/data"))
IRIDIUM = EXTERNAL / "tle" / "celestrak_2025-02_iridium-33-debris.txt"

STILL = replace(field(1)[0], bstar=0.0, mean_motion_dot_rev_day2=0.0)
"""An object that nothing slows down."""


def test_an_object_without_drag_is_not_moved() -> None:
    """With no B* and no derivative an object stays where its mean motion takes it, for a year."""
    assert along_track_km(STILL, STILL.epoch, 365.0 * DAY_S) == pytest.approx(0.0, abs=1e-6)
    assert drag_warning([STILL], STILL.epoch, 365.0 * DAY_S) is None


@pytest.mark.parametrize("late_days", [0.0, 5.0])
def test_derivatives_count_from_the_epoch_of_the_instance(late_days: float) -> None:
    """The way is the integral of what the mean motion gains after the epoch, in whole orbits."""
    record = replace(STILL, mean_motion_dot_rev_day2=2e-5, mean_motion_ddot_rev_day3=3e-7)
    days = np.linspace(0.0, 10.0, 10_001)
    gained = 2.0 * 2e-5 * days + 3.0 * 3e-7 * ((days + late_days) ** 2 - late_days**2)
    turns = float(np.sum(0.5 * (gained[1:] + gained[:-1])) * 1e-3)
    axis_km = (398600.8 / (record.mean_motion_rev_day * 2.0 * math.pi / DAY_S) ** 2) ** (1.0 / 3.0)
    found = along_track_km(record, record.epoch + timedelta(days=late_days), 10.0 * DAY_S)
    assert found == pytest.approx(2.0 * math.pi * turns * axis_km, rel=2e-3)


@pytest.mark.parametrize("late_days", [0.0, 4.0])
def test_bstar_counts_as_sgp4_moves_the_object(late_days: float) -> None:
    """It is what SGP4's anomaly gains on one that goes on as at the epoch of the instance."""
    record = replace(STILL, bstar=1.5e-3)
    satellite, days = satellite_of(record), 3.0

    def place(minutes: float) -> float:
        assert satellite.sgp4_tsince(minutes)[0] == 0
        return satellite.mm + satellite.om

    start, step = 1440.0 * late_days, 1.0
    rate = math.remainder(place(start + step) - place(start - step), math.tau)
    rate = (rate if rate > 0.0 else rate + math.tau) / (2.0 * step)
    gained = math.remainder(
        place(start + 1440.0 * days) - place(start) - rate * 1440.0 * days, math.tau
    )
    found = along_track_km(record, record.epoch + timedelta(days=late_days), days * DAY_S)
    assert found > 5.0
    assert found == pytest.approx(gained * satellite.a * satellite.radiusearthkm, rel=0.02)


def test_far_up_only_drag_counts() -> None:
    """Where the Moon and resonances move an axis too, what SGP4 does without B* is taken off."""
    high = replace(STILL, mean_motion_rev_day=1.0027, inclination_deg=0.1, eccentricity=1e-4)
    assert satellite_of(high).method == "d"
    assert along_track_km(high, high.epoch, 60.0 * DAY_S) == pytest.approx(0.0, abs=1e-6)


def test_the_warning_says_how_many_and_the_worst() -> None:
    """Those beyond 100 km are counted, whichever of the two moves them; the worst is named."""
    dragged = replace(STILL, name="FAST", number=11, mean_motion_dot_rev_day2=3e-4)
    pulled = replace(STILL, name="SLOW", number=12, bstar=3e-3)
    said = drag_warning([STILL, dragged, pulled], STILL.epoch, 7.0 * DAY_S)
    assert said is not None
    assert "moves 2 of 3 objects more than 100 km along the track within the 7 days" in said
    assert f"FAST 11 by {along_track_km(dragged, STILL.epoch, 7.0 * DAY_S):,.0f} km" in said
    assert drag_warning([STILL, dragged], STILL.epoch, DAY_S) is None


def test_an_object_that_comes_down_is_said_to() -> None:
    """Where SGP4 loses an object within the mission, nothing is as bad."""
    falling = replace(STILL, name="FALLING", number=13, mean_motion_rev_day=16.0, bstar=8e-3)
    assert along_track_km(falling, falling.epoch, 60.0 * DAY_S) == DECAYS
    said = drag_warning([STILL, falling, falling], falling.epoch, 60.0 * DAY_S)
    assert said is not None
    assert said.endswith("FALLING 13 comes down before its end, and so does 1 more")


def test_import_warns_of_drag(cli: Cli, tmp_path: Path) -> None:
    """Import tells it on standard error and in --json, and the longer the mission the worse."""
    path = tmp_path / "a.tle"
    path.write_text(as_tle([replace(one, bstar=2e-3) for one in field(5)]), encoding="utf-8")
    told = {}
    for days in ("0.5", "7", "45"):
        done = cli("import", path, "--out", "my.json", "--json", "--duration-days", days)
        assert done.status == 0
        told[days] = [one for one in json.loads(done.out)["warnings"] if one.startswith("drag,")]
        assert done.err.count("warning: drag, which plans leave out, moves ") == len(told[days])
    assert told["0.5"] == []
    assert len(told["7"]) == len(told["45"]) == 1
    assert told["7"] != told["45"]


@pytest.mark.external
@pytest.mark.skipif(not IRIDIUM.is_file(), reason=f"there is no file {IRIDIUM}")
def test_fragments_of_iridium_33_are_warned_of() -> None:
    """Of 119 real objects 87 are moved beyond 100 km in a week, one that falls by a whole orbit."""
    found = read(IRIDIUM)
    (said,) = (one for one in to_instance(found).warnings if one.startswith("drag,"))
    assert "moves 87 of 119 objects more than 100 km along the track within the 7 days" in said
    assert "IRIDIUM 33 DEB 34086" in said
    (named,) = (record for record in found if record.number == 36483)
    assert along_track_km(named, named.epoch, 7.0 * DAY_S) == pytest.approx(106.4, abs=0.2)
    assert along_track_km(named, named.epoch, 45.0 * DAY_S) == pytest.approx(4396.0, abs=10.0)


@pytest.mark.parametrize("family", ["tiny", "cloud", "rocket-bodies", "campaign"])
def test_no_service_ends_before_the_bound(family: str) -> None:
    """Of every connection from a start the service ends later; by hours where planes are near."""
    instance = adr_opt.generate(family, 0, **({} if family == "tiny" else {"targets": 8}))
    least = least_end_s(instance)
    assert least is not None
    timetable, service = adr_opt.Timetable(instance), limits_of(instance).service
    ends = [math.inf]
    for start in set(instance.starts):
        for body in range(instance.first_target, len(instance.names)):
            arrivals = timetable.connections(instance.names[start], instance.names[body]).arrival
            ends += [float(arrivals.min()) + float(service[body])] if arrivals.size else []
    assert least <= min(ends) < math.inf
    if family in ("tiny", "cloud"):
        assert min(ends) < least + DAY_S


def test_a_launched_chaser_only_needs_the_service() -> None:
    """To a first target onto which it is launched a chaser takes no time."""
    instance = adr_opt.generate("removal", 0, targets=6)
    assert instance.launches
    least = least_end_s(instance)
    assert least is not None
    shortest = min(
        2.0 * math.pi * math.sqrt(target.orbit.semi_major_axis_m**3 / 3.986004418e14)
        for target in instance.targets
    )
    service = instance.mission.service_s or (instance.mission.service_revolutions or 0) * shortest
    assert least == pytest.approx(0.99 * service)


def test_a_mission_too_short_for_any_leg_is_warned_of(cli: Cli, tmp_path: Path) -> None:
    """Import and solve say it in one sentence; a mission just long enough is not warned of."""
    cloud = ROOT / "examples" / "catalogue" / "cloud.tle"
    made = cli(
        "import", cloud, "--max-targets", 4, "--duration-days", 1095.0 / DAY_S, "--out", "a.json"
    )
    assert made.status == 0
    said = "the mission of 1095 s is too short for any leg: the first service cannot end before"
    assert made.err.count(f"warning: {said}") == 1
    solved = cli("solve", "a.json", "--method", "greedy", "--out", "plan.json")
    assert solved.status == 0
    assert solved.err.count(f"note: {said}") == 1
    assert any(said in note for note in adr_opt.load_plan("plan.json").notes)

    instance = adr_opt.load("a.json")
    least = least_end_s(instance)
    assert least is not None
    assert too_short(instance.with_limits(duration_s=least)) is None
    assert too_short(instance.with_limits(duration_s=0.999 * least)) is not None
