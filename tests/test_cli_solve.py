"""`solve` and `bound`: options, start plans, interruption, progress."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli
from plans import with_legs

import adr_opt
from adr_opt import front
from adr_opt.cli.live import describe
from adr_opt.cli.timeline import clock, span
from adr_opt.instance import Instance
from adr_opt.mission import Mission
from adr_opt.plan import Plan, load_plan
from adr_opt.wording import shortened

METHODS = '''
"""Methods that show how they were called."""

import math
import time
from pathlib import Path

from adr_opt.result import Result, certify


def starter(mission, *, seed, stop, progress, start=None):
    """Return the start plan.

    And nothing else."""
    return certify(mission, "starter", start or (), seed=seed, runtime_s=0.0)


def worker(mission, *, seed, stop, progress, jobs=1, depth=3, fast=False, word="a", limit=math.inf):
    """Count the questions it may ask, up to 100."""
    count = 0
    while count < 100 and not stop(0.0, math.inf):
        count += 1
    counters = {"jobs": jobs, "depth": depth, "fast": fast, "asked": count}
    return certify(
        mission, "worker", (), seed=seed, runtime_s=0.0, counters=counters,
        notes=[f"jobs {jobs} depth {depth} fast {fast} word {word} asked {count}"],
    )


def hopeless(mission, *, seed, stop, progress):
    """Find nothing."""
    return certify(mission, "hopeless", None, seed=seed, runtime_s=0.0)


def patient(mission, *, seed, stop, progress):
    """Wait until it is told to stop, then return one visit."""
    progress(1.0, 4.0)
    if mission.instance.name == "tiny-000":  # and not the one that it practises on
        Path("started").touch()
    while not stop(1.0, 4.0):
        time.sleep(0.01)
    return certify(mission, "patient", (1,), seed=seed, runtime_s=0.0, upper_bound=4.0)


def deaf(mission, *, seed, stop, progress):
    """Never ask."""
    Path("started").touch()
    time.sleep(60.0)


def lid(mission, *, seed, stop, progress, start=None):
    """Bound by the number of targets."""
    bound = math.inf if mission.total_prize == 3.0 else mission.total_prize
    return Result(
        "lid", None, None, -math.inf, bound, "unknown", {"start": len(start or ())}, seed, 0.5
    )
'''


@pytest.fixture
def methods(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The methods above, installed as a package would be; returns the folder to import from."""
    home = tmp_path / "installed"
    metadata = home / "show_methods-1.0.dist-info"
    metadata.mkdir(parents=True)
    (home / "show_methods.py").write_text(METHODS, encoding="utf-8")
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: show-methods\nVersion: 1.0\n")
    planners = ("starter", "worker", "hopeless", "patient", "deaf", "absent")
    lines = ["[adr_opt.planners]", *(f"{name} = show_methods:{name}" for name in planners)]
    lines += ["[adr_opt.bounds]", "lid = show_methods:lid"]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(str(home))
    monkeypatch.setenv("PYTHONPATH", str(home), prepend=os.pathsep)
    sys.modules.pop("show_methods", None)
    return home


def test_json_is_the_plan_file_and_nothing_else(cli: Cli, tiny_file: Path) -> None:
    """`solve --json` prints exactly the plan that --out writes; --quiet silences the rest."""
    call = ("solve", tiny_file, "--method", "greedy-guarded", "--json")
    outcome = cli(*call, "--out", "plan.json", "--quiet")
    assert outcome.status == 0
    assert outcome.out == Path("plan.json").read_text(encoding="utf-8")
    assert outcome.err == ""
    assert json.loads(outcome.out)["format"] == "adr-opt-plan/2"


def test_solve_without_out_writes_no_file(cli: Cli, tiny_file: Path) -> None:
    """Without --out nothing appears in the working folder."""
    cli("solve", tiny_file, "--method", "greedy")
    cli("solve", tiny_file, "--method", "greedy", "--json")
    assert list(tiny_file.parent.iterdir()) == [tiny_file]


def test_timeline_shows_every_leg_and_the_summary(cli: Cli) -> None:
    """The table has a row per leg, refuelling marked, and the summary adds up."""
    cli("generate", "nominal", "--targets", "12", "--out", "my.json")
    outcome = cli("solve", "my.json", "--method", "greedy-guarded", "--out", "plan.json")
    plan = load_plan("plan.json")
    refuellings = plan.destinations.count("station")
    rows = [line for line in outcome.out.splitlines() if line.startswith("│")]
    assert len(rows) == len(plan.legs) > 0
    assert sum("refuels" in row for row in rows) == refuellings > 0
    for row, leg in zip(rows, plan.legs, strict=True):
        for text in (
            f"{leg.origin} → {leg.destination}",
            clock(leg.departure_s),
            clock(leg.arrival_s),
            span(leg.departure_s - leg.ready_s),
            f"{leg.delta_v_m_s:.1f}",
            f"{leg.delta_v_left_m_s:.1f}",
            f" {leg.phasing_revolutions} ",
        ):
            assert text in row
    last = outcome.out.splitlines()[-1]
    assert f"visits {len(plan.legs) - refuellings} of 12" in last
    assert f"ΔV {plan.delta_v_m_s:.1f} m/s" in last
    assert f"refuellings {refuellings}" in last


@pytest.fixture(scope="module")
def of_a_cloud() -> tuple[Instance, Plan]:
    """A plan over objects that share one long name but for the number at its end."""
    tiny = adr_opt.generate("nominal", 0, targets=12)
    instance = tiny.replace(
        targets=tuple(
            target.replace(name=f"COSMOS 2251 DEB {34020 + at}")
            for at, target in enumerate(tiny.targets)
        )
    )
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert "station" in plan.destinations
    return instance, plan


@pytest.mark.parametrize("verb", ["solve", "fly"])
@pytest.mark.parametrize("columns", [40, 60, 80, 100, 200, None])
def test_numbers_are_never_cut_and_names_can_be_told_apart(
    cli: Cli,
    monkeypatch: pytest.MonkeyPatch,
    of_a_cloud: tuple[Instance, Plan],
    verb: str,
    columns: int | None,
) -> None:
    """At any width rows keep their numbers and differ in their names; a pipe has whole names."""
    instance, plan = of_a_cloud
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("plan.json")
    monkeypatch.setenv("COLUMNS", "80" if columns is None else str(columns))
    if columns is not None:
        monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes standard output for a terminal
        monkeypatch.setenv("TERM", "dumb" if columns == 80 else "xterm")
    if verb == "fly":
        pytest.importorskip("boinor")
        flight = json.loads(cli("fly", "my.json", "plan.json", "--json").out)
        numbers = [
            [f"{leg[key]:.2g}" for key in ("miss_m", "relative_speed_m_s", "arrival_miss_m")]
            for leg in flight["legs"]
        ]
        out = cli("fly", "my.json", "plan.json").out
    else:
        numbers = [
            [
                clock(leg.departure_s),
                span(leg.departure_s - leg.ready_s),
                f"{leg.delta_v_m_s:.1f}",
                f"{leg.delta_v_left_m_s:.1f}",
                str(leg.phasing_revolutions),
                clock(leg.arrival_s),
            ]
            for leg in plan.legs
        ]
        out = cli("solve", "my.json", "--method", "greedy-guarded").out
    plain = re.sub(r"\x1b\[[0-9;]*m", "", out)
    rows = [line for line in plain.splitlines() if re.match(r"[│ ]* \d+ .*→", line)]
    assert len(rows) == len(plan.legs) > 3
    if columns is None or columns >= 60:
        assert max(map(len, rows)) <= (columns or 200)
    seen = set()
    for row, texts, leg in zip(rows, numbers, plan.legs, strict=True):
        cells = " ".join(row.replace("│", " ").split())
        assert cells.endswith(" ".join(texts))
        assert "…" not in cells.partition(texts[0])[2]
        number = leg.destination.rpartition(" ")[2]
        assert number in cells or "(refuels)" in cells or leg.destination == "station"
        if columns is None or columns >= 200:
            assert f"{leg.origin} → {leg.destination}" in cells
        if leg.destination != "station":
            seen.add(cells.partition("→")[2].partition(texts[0])[0])
    assert len(seen) == len(set(plan.destinations) - {"station"})


def test_names_are_cut_to_different_ones() -> None:
    """Short names stay; of long ones the middle goes, or else what they begin with in common."""
    cloud = [f"COSMOS 2251 DEB {number}" for number in (34021, 34022)]
    short = shortened(["station", *cloud], 12)
    assert list(short.values()) == ["station", "COSM…B 34021", "COSM…B 34022"]
    for width in range(6, 22):
        assert len(set(shortened(cloud, width).values())) == 2
    front = [f"{letter} of the long long cloud" for letter in "ab"]
    inside = [f"object {letter}{number} of the cloud" for letter in "ab" for number in (1, 2, 10)]
    for names in (front, inside, [*front, *inside, *cloud]):
        for width in (6, 10, 16):
            short = shortened(names, width)
            assert len(set(short.values())) == len(names)
            assert all(len(text) <= width for text in short.values())


def test_a_margin_is_left_in_every_tank(cli: Cli, tiny_file: Path) -> None:
    """`--margin` keeps a share of each tank; the plan is legal and says what it was made with."""
    call = ("--margin", "0.2", "--time-limit", "20")
    solved = cli(
        "solve", tiny_file, "--method", "beam", "--bound", "exact", *call, "--out", "plan.json"
    )
    assert solved.status == 0
    assert "prize" in solved.out
    assert "bound" not in solved.out
    assert "gap" not in solved.out
    instance, plan = adr_opt.load(tiny_file), load_plan("plan.json")
    assert plan.upper_bound is None
    budget = instance.chaser.tank.delta_v_m_s
    assert min(leg.delta_v_left_m_s for leg in plan.legs) >= 0.2 * budget
    assert cli("check", tiny_file, "plan.json").status == 0
    said = f"no plan that keeps back 20 % of each tank ({0.2 * budget:g} m/s) collects more than"
    assert said in solved.err
    assert any(said in note for note in plan.notes)
    bound = cli("bound", tiny_file, "--method", "exact", *call, "--json")
    assert said in bound.err
    assert json.loads(bound.out)["margin"] == 0.2
    assert cli("solve", tiny_file, "--margin", "1").status == 2


def test_times_are_written_as_clocks() -> None:
    """Days count from 0, minutes are rounded and carry into hours and days."""
    assert clock(0.0) == "0d 00:00"
    assert clock(86400.0 + 3 * 3600.0 + 25 * 60.0 + 29.0) == "1d 03:25"
    assert clock(2 * 86400.0 - 1.0) == "2d 00:00"
    assert span(25 * 3600.0 + 61.0) == "25:01"


def test_same_seed_same_plan_on_the_command_line(cli: Cli, tiny_file: Path) -> None:
    """The command line gives the plan of the Python call."""
    outcome = cli("solve", tiny_file, "--method", "greedy", "--option", "beta=0.01", "--json")
    expected = adr_opt.solve(adr_opt.load(tiny_file), "greedy", beta=0.01).plan
    assert expected is not None
    assert json.loads(outcome.out)["routes"] == expected.to_dict()["routes"]


@pytest.mark.usefixtures("methods")
def test_options_are_converted_by_their_defaults(cli: Cli, tiny_file: Path) -> None:
    """--option, --jobs and --iterations reach the planner with their types."""
    outcome = cli(
        "solve", tiny_file, "--method", "worker", "--jobs", "2", "--iterations", "7",
        "--option", "depth=5", "--option", "fast=true", "--option", "word=b=c",
        "--option", "limit=inf",
    )  # fmt: skip
    assert outcome.status == 0
    assert "note: jobs 2 depth 5 fast True word b=c asked 7" in outcome.err


@pytest.mark.usefixtures("methods")
def test_jobs_and_start_are_refused_where_they_mean_nothing(cli: Cli, tiny_file: Path) -> None:
    """A method that cannot use --jobs or --start says so and names those that can."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    jobs = cli("solve", tiny_file, "--method", "starter", "--jobs", "2")
    assert jobs.status == 2
    assert "worker" in jobs.err.partition("or use one of: ")[2]
    start = cli("solve", tiny_file, "--method", "worker", "--start", "plan.json")
    assert start.status == 2
    assert "starter" in start.err.partition("or use one of: ")[2]
    assert cli("solve", tiny_file, "--method", "worker", "--jobs", "-1").status == 2
    twice = cli("solve", tiny_file, "--method", "worker", "--jobs", "2", "--option", "jobs=3")
    assert twice.status == 2
    assert "twice" in twice.err


@pytest.mark.usefixtures("methods")
def test_a_start_plan_is_handed_over_as_bodies(cli: Cli, tiny_file: Path) -> None:
    """--start gives the planner the plan's bodies."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    cli("solve", tiny_file, "--method", "starter", "--start", "plan.json", "--out", "again.json")
    assert load_plan("again.json").legs == load_plan("plan.json").legs != ()


@pytest.mark.usefixtures("methods")
def test_an_illegal_start_plan_is_refused_or_repaired(cli: Cli, tiny_file: Path) -> None:
    """An illegal start names its leg and why; --repair keeps what is legal and says how much."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = load_plan("plan.json")
    assert len(plan.legs) >= 3
    first, second = plan.legs[:2]
    legs = (first, second.replace(destination=first.destination), *plan.legs[2:])
    with_legs(plan, legs).save("bad.json")
    call = ("solve", tiny_file, "--method", "starter", "--start", "bad.json")
    refused = cli(*call, "--out", "new.json")
    assert refused.status == 2
    assert "start plan: leg 2: order: goes from" in refused.err
    assert not Path("new.json").exists()
    repaired = cli(*call, "--out", "new.json", "--repair")
    assert repaired.status == 0
    note = f"only the first 1 of the start plan's {len(legs)} legs could be kept"
    assert note in repaired.err
    # What is left is flown at a schedule of its own.
    assert load_plan("new.json").destinations == (first.destination,)
    assert cli("check", tiny_file, "new.json").status == 0
    assert note in load_plan("new.json").notes


@pytest.mark.usefixtures("methods")
def test_repair_takes_a_plan_to_a_changed_instance(cli: Cli, tiny_file: Path) -> None:
    """A plan of another instance needs --repair, which times it anew and drops unknown bodies."""
    instance = adr_opt.load(tiny_file)
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = load_plan("plan.json")
    gone = plan.legs[2].destination
    left = tuple(target for target in instance.targets if target.name != gone)
    Path("less.json").write_text(instance.replace(targets=left).to_json(), encoding="utf-8")
    call = ("solve", "less.json", "--method", "starter", "--start", "plan.json")
    refused = cli(*call)
    assert refused.status == 2
    assert "start plan: the plan belongs to the instance" in refused.err
    assert cli(*call, "--repair", "--out", "new.json").status == 0
    assert load_plan("new.json").destinations == plan.destinations[:2]
    assert cli("check", "less.json", "new.json").status == 0


def test_help_states_the_time_limits(cli: Cli) -> None:
    """The default time limits in the help are those of the front door."""
    assert f"included; {front.DEFAULT_TIME_LIMIT_S:g} s." in cli("solve", "--help").out
    assert f"included; {front.DEFAULT_BOUND_TIME_LIMIT_S:g} s." in cli("bound", "--help").out


def test_repair_without_start_is_refused(cli: Cli, tiny_file: Path) -> None:
    """--repair alone is a mistake, and is called one."""
    outcome = cli("solve", tiny_file, "--method", "greedy", "--repair")
    assert outcome.status == 2
    assert "--start" in outcome.err


@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize(
    ("sequence", "named"),
    [
        ((0,), "leg 1 refuels, but no target was visited"),
        ((1, 1), "leg 2 goes from 'debris-001' to itself"),
        ((1, 2, 1), "leg 3 goes to 'debris-001', which was visited before"),
        ((1, 0, 0), "leg 3 refuels, but no target was visited"),
        ((99,), "bodies 0 to"),
    ],
)
def test_a_start_sequence_is_judged_by_the_rules(sequence: tuple[int, ...], named: str) -> None:
    """In Python a start may be a sequence of bodies; the first illegal move is named."""
    instance = adr_opt.generate("tiny", 0)
    mission = Mission(instance.with_limits(duration_s=1e6, delta_v_m_s=1e4))
    with pytest.raises(adr_opt.InputError, match=named):
        front.solve(mission, "starter", start=sequence)


@pytest.mark.usefixtures("methods")
def test_a_start_sequence_that_breaks_a_limit_says_which() -> None:
    """Too little ΔV and too little time are told apart."""
    instance = adr_opt.generate("tiny", 0)
    for limits, named in (
        ({"delta_v_m_s": 1.0}, r"needs .* m/s, but only 1 m/s are left"),
        ({"duration_s": 20000.0}, "ends at .* s at the earliest, too late"),
        ({"duration_s": 10.0}, "to which there is no transfer any more"),
    ):
        changed = instance.with_limits(**limits)
        with pytest.raises(adr_opt.InputError, match=named):
            front.solve(changed, "starter", start=(1,))
        assert front.solve(changed, "starter", start=(1,), repair=True).sequence == ()


@pytest.mark.usefixtures("methods")
def test_no_plan_is_exit_one(cli: Cli, tiny_file: Path) -> None:
    """A planner that finds nothing ends with 1 and writes nothing, but still speaks JSON."""
    outcome = cli("solve", tiny_file, "--method", "hopeless", "--json", "--out", "plan.json")
    assert outcome.status == 1
    assert json.loads(outcome.out)["status"] == "unknown"
    assert "no plan" in outcome.err
    assert not Path("plan.json").exists()


@pytest.mark.usefixtures("methods")
def test_a_method_that_cannot_be_imported_says_so(cli: Cli, tiny_file: Path) -> None:
    """A declared method without its code is one sentence, and does not spoil the list."""
    outcome = cli("solve", tiny_file, "--method", "absent")
    assert outcome.status == 2
    assert "'absent' is declared, but cannot be imported" in outcome.err
    listed = {
        entry["name"]: entry for entry in json.loads(cli("methods", "--json").out)["planners"]
    }
    assert "cannot be imported" in listed["absent"]["summary"]
    assert listed["starter"] == {
        "name": "starter", "summary": "Return the start plan.", "default": False,
        "takes_start": True, "options": [],
    }  # fmt: skip
    assert listed["worker"]["options"][-1] == {
        "name": "limit", "type": "float", "default": "inf", "unit": "", "allowed": "",
        "meaning": "",
    }  # fmt: skip


@pytest.mark.usefixtures("methods")
def test_bound_prints_its_certificate(cli: Cli, tiny_file: Path) -> None:
    """`bound --json` gives bound, status, runtime and counters; a start plan reaches the bound."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    call = ("bound", tiny_file, "--method", "lid", "--start", "plan.json")
    content = json.loads(cli(*call, "--json").out)
    assert content["upper_bound"] == len(adr_opt.load(tiny_file).targets)
    assert content["status"] == "unknown"
    assert content["runtime_s"] == 0.5
    assert content["counters"] == {"start": len(load_plan("plan.json").legs)}
    assert cli(*call).out.startswith(f"upper bound {content['upper_bound']:g}, unknown")


@pytest.mark.usefixtures("methods")
def test_a_bound_that_proves_nothing_is_null(cli: Cli) -> None:
    """An infinite bound is null in JSON and said in words in text."""
    cli("generate", "tiny", "--targets", "3", "--out", "three.json")
    call = ("bound", "three.json", "--method", "lid")
    assert json.loads(cli(*call, "--json").out)["upper_bound"] is None
    assert "none proven" in cli(*call).out


def test_front_bound_is_the_python_call(methods: Path) -> None:
    """`front.bound` finds bounds in their own group and knows no planners."""
    instance = adr_opt.generate("tiny", 0)
    assert front.bound(instance, "lid", start=(1,)).counters == {"start": 1}
    with pytest.raises(adr_opt.InputError, match=r"'greedy' is unknown; use one of: .*lid"):
        front.bound(instance, "greedy")


@pytest.mark.parametrize(
    ("incumbent", "bound", "expected"),
    [
        (float("-inf"), float("inf"), "2.5 s  no plan yet"),
        (3.0, float("inf"), "2.5 s  incumbent 3"),
        (3.0, 4.0, "2.5 s  incumbent 3  bound 4  gap 25.0%"),
        (float("-inf"), 4.0, "2.5 s  no plan yet  bound 4"),
    ],
)
def test_live_line_tells_what_is_known(incumbent: float, bound: float, expected: str) -> None:
    """The line has the elapsed time, and incumbent, bound and gap as far as there are any."""
    assert describe(2.5, incumbent, bound) == expected


def test_live_line_tells_how_much_of_the_timetable_is_built() -> None:
    """Before there is anything to plan with, the line says how far that is."""
    assert describe(2.5, -math.inf, math.inf, 0.374) == "2.5 s  timetable 37 %"


# Children of a script in the background inherit an ignored SIGINT; a user's shell does not do that.
CHILD = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from adr_opt.__main__ import main; sys.exit(main())"
)


def begin(tiny_file: Path, method: str, *more: str, **how: Any) -> subprocess.Popen[str]:
    """Start `solve` as a process and wait until the planner runs."""
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, "solve", str(tiny_file), "--method", method,
         "--time-limit", "60", *more],
        cwd=tiny_file.parent, text=True, stdout=subprocess.PIPE,
        **{"stderr": subprocess.PIPE, **how},
    )  # fmt: skip
    deadline = time.monotonic() + 60.0
    while not (tiny_file.parent / "started").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return process


posix = pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")


@posix
@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_first_signal_asks_for_the_best_plan(tiny_file: Path, number: int) -> None:
    """Ctrl-C once: the best plan so far is printed and written, exit 0, a message on stderr."""
    process = begin(tiny_file, "patient", "--json", "--out", "plan.json")
    process.send_signal(number)
    out, err = process.communicate(timeout=30.0)
    assert process.returncode == 0, err
    # Its one visit is fewer than those of the plan that every method falls back on.
    assert json.loads(out)["objective"] == 3.0
    assert load_plan(tiny_file.parent / "plan.json").to_json() == out
    assert "interrupted: this is the best result until then" in err
    assert "Traceback" not in err


@posix
@pytest.mark.usefixtures("methods")
def test_second_signal_aborts(tiny_file: Path) -> None:
    """Ctrl-C twice ends a planner that does not listen: exit 130, nothing written."""
    process = begin(tiny_file, "deaf", "--out", "plan.json")
    process.send_signal(signal.SIGINT)
    assert process.stderr is not None
    assert "once more to abort" in process.stderr.readline()
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30.0)
    assert process.returncode == 130
    assert out == ""
    assert err == "adr-opt: aborted\n"
    assert not (tiny_file.parent / "plan.json").exists()


@posix
@pytest.mark.usefixtures("methods")
def test_aborting_gives_the_cursor_back(tiny_file: Path) -> None:
    """The live line hides the cursor; also after the second Ctrl-C it is shown again."""
    ours, theirs = os.openpty()
    environment = {**os.environ, "TERM": "xterm"}
    process = begin(tiny_file, "deaf", stderr=theirs, env=environment)
    os.close(theirs)
    said = b""
    sent = 0
    try:
        while part := os.read(ours, 4096):
            said += part
            if sent == (b"to abort" in said):
                process.send_signal(signal.SIGINT)
                sent += 1
    except OSError:  # Linux says EIO when the other end is closed
        pass
    os.close(ours)
    assert process.wait(timeout=30.0) == 130
    hidden, shown = said.rfind(b"\x1b[?25l"), said.rfind(b"\x1b[?25h")
    assert 0 <= hidden < shown


@posix
@pytest.mark.usefixtures("methods")
@pytest.mark.parametrize("more", [[], ["--json"], ["--quiet"]])
def test_live_line_only_on_a_terminal(tiny_file: Path, more: list[str]) -> None:
    """On a terminal the line shows incumbent, bound and gap, but not with --json or --quiet."""
    ours, theirs = os.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    process = begin(tiny_file, "patient", *more, stderr=theirs, env=environment)
    os.close(theirs)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    said = b""
    try:
        while part := os.read(ours, 4096):
            said += part
    except OSError:  # Linux says EIO when the other end is closed
        pass
    os.close(ours)
    out, _ = process.communicate(timeout=30.0)
    assert process.returncode == 0
    assert ("incumbent 1  bound 4  gap 75.0%" in said.decode()) == (not more)
    assert "gap 25.0%" in out or "--json" in more


@posix
@pytest.mark.usefixtures("methods")
def test_no_live_line_without_a_terminal(tiny_file: Path) -> None:
    """Into a pipe or a file nothing is said but messages."""
    process = begin(tiny_file, "patient")
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30.0)
    assert all(line.startswith("adr-opt: ") for line in err.splitlines())
    assert "incumbent" not in err


@posix
def test_interrupted_while_the_timetable_is_built(tmp_path: Path) -> None:
    """A build of minutes is shown, and Ctrl-C ends it soon: a plan or a sentence, no traceback."""
    path = tmp_path / "large.json"
    instance = adr_opt.generate("nominal", 0, targets=150)
    path.write_text(instance.with_limits(duration_s=200 * 86400.0).to_json())
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, "solve", str(path), "--time-limit", "900"],
        stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm"}, text=True,
    )  # fmt: skip
    os.close(theirs)
    said = b""
    sent = math.inf
    try:
        while part := os.read(ours, 4096):
            said += part
            if b"timetable" in said and sent == math.inf:
                process.send_signal(signal.SIGINT)
                sent = time.monotonic()
    except OSError:  # Linux says EIO when the other end is closed
        pass
    os.close(ours)
    process.communicate(timeout=30.0)
    assert time.monotonic() - sent < 10.0
    assert process.returncode in (0, 1)
    assert b"Traceback" not in said
    assert b"of 150 targets" in said or b"no time to begin" in said
