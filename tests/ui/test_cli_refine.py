"""``refine``, and ``fly`` and ``export`` of what it writes."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import threading
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from plans import solved

import adr_opt
from adr_opt.fly.refine import all_legs
from adr_opt.fly.refine.ephemeris import tracks
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli.fly_refined import FLOWN
from adr_opt.ui.cli.refine import FREEDOMS, GRAVITIES
from adr_opt.ui.cli.refine import command as refine_command


@pytest.fixture
def mission(cli: Cli) -> Instance:
    """A small mission under J2 and its plan, as files where the command line runs."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    solved(instance).save("plan.json")
    return instance


def test_refine_fly_export(cli: Cli, mission: Instance) -> None:
    """A plan is refined, flies with exit status 0, and says planned against flown."""
    told = cli("refine", "my.json", "plan.json", "--out", "refined.json")
    assert told.status == 0
    assert "wrote refined.json" in told.err
    assert "in the field j2: planned with" in told.out
    flown = cli("fly", "my.json", "refined.json", "--out", "flown.json")
    assert flown.status == 0, flown.out
    assert "every tank holds" in flown.out
    assert cli("fly", "my.json", "flown.json", "--out", "again.json").status == 0
    (note,) = adr_opt.load_refined("again.json").notes
    assert note.startswith(FLOWN)
    told_json = json.loads(cli("fly", "my.json", "refined.json", "--json").out)
    assert told_json["holds"] is True
    assert told_json["worst_miss_m"] < 1.0
    assert told_json["worst_miss_m_s"] < 1e-3
    assert {"standoff_miss_m", "arrival_miss_m_s", "arrives"} <= set(told_json["legs"][0])


def test_refine_tells_json_and_takes_options(cli: Cli, mission: Instance) -> None:
    """`--gravity` and `--burns` reach the file, and `--json` prints totals and legs."""
    outcome = cli(
        "refine my.json plan.json --out r.json --gravity j4 --burns planned --jobs 1 --json --quiet"
    )
    assert (outcome.status, outcome.err) == (0, "")
    told = json.loads(outcome.out)
    one = adr_opt.load_refined("r.json")
    assert (told["gravity"], told["burns"]) == (one.gravity, one.freedom) == ("j4", "planned")
    assert told["flown_delta_v_m_s"] == one.flown_delta_v_m_s
    assert [leg["leg"] for leg in told["legs"]] == [leg.leg for leg in one.legs]


def test_the_command_line_offers_what_there_is() -> None:
    """The choices of `refine` are the fields and freedoms of the package."""
    choices = {option.name: getattr(option.type, "choices", ()) for option in refine_command.params}
    assert tuple(choices["gravity"]) == tuple(FIELDS) == GRAVITIES == all_legs.GRAVITIES
    assert tuple(choices["freedom"]) == FREEDOMS == all_legs.FREEDOMS


def test_wrong_input_is_one_sentence(cli: Cli, mission: Instance) -> None:
    """What is wrong is named with its file, and nothing is written."""
    plan = Path("plan.json").read_text(encoding="utf-8")
    Path("other.json").write_text(adr_opt.generate("tiny", 3).to_json(), encoding="utf-8")
    refused(cli("refine", "my.json", "plan.json"), "missing option '--out'")
    refused(cli("refine", "my.json", "none.json", "--out", "r.json"), "none.json: no such file")
    refused(cli("refine", "other.json", "plan.json", "--out", "r.json"), "plan.json: the plan bel")
    refused(cli("refine", "my.json", "plan.json", "--out", "plan.json"), "this is the input")
    refused(
        cli("refine", "my.json", "plan.json", "--out", "r.json", "--gravity", "j9"), "'j9' is not"
    )
    refused(cli("refine", "my.json", "plan.json", "--out", "r.json", "--jobs", "-2"), "jobs = -2")
    assert not Path("r.json").exists()
    assert Path("plan.json").read_text(encoding="utf-8") == plan
    cli("refine", "my.json", "plan.json", "--out", "r.json", "--quiet")
    refused(cli("fly", "other.json", "r.json"), "r.json: the refined plan belongs to the instance")
    refused(cli("export", "my.json", "r.json", "--out", "r.oem", "--leg", "99"), "no such leg")
    refused(cli("export", "my.json", "r.json", "--out", "r.oem", "--body", "x"), "'x' is not a")
    refused(cli("export", "my.json", "plan.json", "--out", "r.oem", "--body", "x"), "--body x")
    refused(cli("refine", "my.json", "r.json", "--out", "s.json"), "r.json: field")
    Path("cut.json").write_text(Path("r.json").read_text(encoding="utf-8")[:900], encoding="utf-8")
    refused(cli("fly", "my.json", "cut.json"), "cut.json: not JSON")
    assert not Path("r.oem").exists()


def test_a_flight_that_does_not_hold_ends_with_1(cli: Cli, mission: Instance) -> None:
    """A leg that strays, or a leg that is missing, is exit status 1 and named."""
    cli("refine", "my.json", "plan.json", "--out", "r.json", "--quiet")
    content = json.loads(Path("r.json").read_text(encoding="utf-8"))
    vector = content["legs"][0]["burns"][0]["delta_v_m_s"]
    size = float(np.linalg.norm(vector))
    content["legs"][0]["burns"][0]["delta_v_m_s"] = [1.001 * part for part in vector]
    content["legs"][0]["flown_delta_v_m_s"] += 0.001 * size
    Path("strayed.json").write_text(json.dumps(content), encoding="utf-8")
    refused(cli("fly", "my.json", "strayed.json"), "not legal: leg 1")
    strayed = cli("fly", "my.json", "strayed.json", "--unjudged")
    assert strayed.status == 1
    assert "leg 1 missed by more than 1 m or 1 mm/s" in strayed.out
    content = json.loads(Path("r.json").read_text(encoding="utf-8"))
    content["legs"].pop(0)
    content |= {"status": "incomplete", "missing": [{"leg": 1, "reason": "interrupted"}]}
    Path("some.json").write_text(json.dumps(content), encoding="utf-8")
    some = cli("fly", "my.json", "some.json")
    assert some.status == 1
    assert "not refined: leg 1" in some.out


def seconds(instance: Instance, label: str) -> float:
    time = datetime.fromisoformat(label.removesuffix("Z")).replace(tzinfo=UTC)
    return (time - instance.epoch) / timedelta(seconds=1)


def test_the_oem_of_chaser_and_target_meet(cli: Cli, mission: Instance) -> None:
    """Read by ``oem``: states are the flight's, and at each arrival chaser and target are one."""
    oem = pytest.importorskip("oem")
    cli("refine", "my.json", "plan.json", "--out", "r.json")
    told = cli("export", "my.json", "r.json", "--out", "chaser.oem", "--json")
    assert told.status == 0
    one = adr_opt.load_refined("r.json")
    read = oem.OrbitEphemerisMessage.open("chaser.oem")
    written = tracks(one)
    assert len(read.segments) == len(written) == json.loads(told.out)["arcs"]
    for segment, track in zip(read.segments, written, strict=True):
        assert segment.metadata["OBJECT_NAME"] == "CHASER"
        states = list(segment.states)
        assert len(states) == track.arc.times_s.size
        for at in (0, len(states) // 2, -1):
            apart = 1e3 * states[at].position - track.arc.positions_m[at]
            assert np.linalg.norm(apart) < 0.01  # a label is half a microsecond off
    for leg in one.legs:
        ends = [
            segment
            for segment in read.segments
            if abs(seconds(mission, segment.metadata["STOP_TIME"].isot) - leg.arrival_s) < 1e-5
        ]
        assert len(ends) == 1
        assert (
            cli(
                "export", "my.json", "r.json", "--out", "body.oem", "--body", leg.destination
            ).status
            == 0
        )
        body = oem.OrbitEphemerisMessage.open("body.oem")
        (whole,) = body.segments
        assert whole.metadata["OBJECT_NAME"] == leg.destination
        docked = list(ends[0].states)[-1]
        there = whole(docked.epoch)
        assert np.linalg.norm(1e3 * (docked.position - there.position)) < 1.0
        assert len(body.segments) == 1


def test_tracks_are_joined_by_the_burns(cli: Cli, mission: Instance) -> None:
    """Each arc begins where the one before ends, and velocities differ by burns alone."""
    cli("refine", "my.json", "plan.json", "--out", "r.json")
    one = adr_opt.load_refined("r.json")
    for leg in one.legs:
        arcs = [track.arc for track in tracks(one, leg=leg.leg)]
        jumps = 0.0
        for before, after in itertools.pairwise(arcs):
            assert after.start_s == pytest.approx(before.end_s, abs=1e-6)
            assert np.linalg.norm(after.positions_m[0] - before.positions_m[-1]) < 0.02
            jumps += float(np.linalg.norm(after.velocities_m_s[0] - before.velocities_m_s[-1]))
        assert jumps <= leg.flown_delta_v_m_s + 1e-3
        assert jumps > 0.9 * leg.flown_delta_v_m_s


CHILD = (
    "import signal, sys, time; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from adr_opt.fly.refine import all_legs; inner = all_legs.refine_leg\n"
    "def slow(*a):\n    time.sleep(0.4); print('leg', file=sys.stderr, flush=True); "
    "return inner(*a)\n"
    "all_legs.refine_leg = slow\n"
    "from adr_opt.__main__ import main; sys.exit(main())"
)


@pytest.mark.slow
def test_interrupted_keeps_what_is_done(mission: Instance) -> None:
    """Ctrl-C writes the legs that are done, says which are missing, and ends with 1."""
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            CHILD,
            "refine",
            "my.json",
            "plan.json",
            "--out",
            "r.json",
            "--jobs",
            "1",
        ],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    killer = threading.Timer(120.0, process.kill)
    killer.start()
    assert process.stderr is not None
    process.stderr.readline()
    os.kill(process.pid, signal.SIGINT)
    out, _ = process.communicate()
    killer.cancel()
    assert process.returncode == 1
    assert "is missing: interrupted" in out
    one = adr_opt.load_refined("r.json")
    assert one.status == "incomplete"
    assert len(one.legs) >= 1
    assert one.missing
