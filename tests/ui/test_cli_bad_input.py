"""Bad input: one sentence that says what is wrong and what to do, exit 2, nothing written."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused

from adr_opt.common.errors import InputError
from adr_opt.problem.settings import KeepOutZone

Content = dict[str, Any]
Change = Callable[[Content], None]


def rename(*path: str | int) -> Change:
    """Change the name of a field: what comes before the last two leads to it."""
    *way, old, new = path

    def change(content: Any) -> None:
        for key in way:
            content = content[key]
        content[new] = content.pop(old)

    return change


def put(*path: Any) -> Change:
    """Set the field at a path to the last argument."""
    *keys, last, value = path

    def change(content: Content) -> None:
        place: Any = content
        for key in keys:
            place = place[key]
        place[last] = value

    return change


def drop(*path: Any) -> Change:
    """Remove the field at a path."""
    *keys, last = path

    def change(content: Content) -> None:
        place: Any = content
        for key in keys:
            place = place[key]
        del place[last]

    return change


def twice(key: str) -> Change:
    """Add the first entry of a list to it once more, by another name."""

    def change(content: Content) -> None:
        content[key].append({**content[key][0], "name": "another"})

    return change


TARGET = ("targets", 0)
ORBIT = ("targets", 0, "orbit")
CHASER = ("chasers", 0)
TANK = ("chasers", 0, "tank")
VERBS_OF_PLANS = {
    "check": [],
    "fly": [],
    "export": ["--out", "m.oem"],
    "report": ["--out", "m.html"],
}
"""Verbs that read an instance and a plan, each with the options that it must have."""


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (drop("stations"), "field stations: missing"),
        (drop(*ORBIT, "raan_deg"), "field targets[0].orbit.raan_deg: missing"),
        (put("statoin", 1), "field statoin: unknown; did you mean stations?"),
        (put(*ORBIT, "raan_rad", 0.1), "orbit.raan_rad: unknown; did you mean raan_deg?"),
        (put(*TARGET, "prise", 2.0), "field targets[0].prise: unknown; did you mean prize?"),
        (put(*TARGET, "sunglasses", 2.0), "field targets[0].sunglasses: unknown; remove it or cor"),
        (
            rename(*ORBIT, "raan_deg", "raan"),
            "tiny.json: field targets[0].orbit.raan: unknown; did you mean raan_deg?\n",
        ),
        (
            rename(*TANK, "delta_v_m_s", "delta_v"),
            "field chasers[0].tank.delta_v: unknown; did you mean delta_v_m_s?",
        ),
        (
            rename("mission", "duration_s", "duration"),
            "tiny.json: field mission.duration: unknown; did you mean duration_s?\n",
        ),
        *(
            (put("transfer", "given", {"file": file}), "must be the name of a file beside this one")
            for file in ("../w/t.parquet", "w/t.nc", "t.csv", "a\0.nc")
        ),
        (put("mission", "duration_s", "a week"), 'field mission.duration_s = "a week"'),
        (put("mission", "duration_s", None), "field mission.duration_s = null"),
        (put("targets", {}), "field targets: must be a JSON list"),
        (put("stations", 0, 3), "field stations[0] = 3: must be a JSON object"),
        (
            put("format", "adr-opt-instance/4"),
            "'adr-opt-instance/3'; this is another version of it",
        ),
        (put("epoch", "2026-01-01T00:00:00"), "field epoch"),
        (put("epoch", 0), "field epoch = 0: must be a time like"),
        (put("epoch", "0"), 'field epoch = "0": must be a time like'),
        (put("epoch", "2026-13-01T00:00:00Z"), 'field epoch = "2026-13-01T00:00:00Z": must be a t'),
        (put("epoch", "9999-12-31T23:59:59-12:00"), "must lie in the years 1 to 9999 in UTC"),
        (put(*ORBIT, "semi_major_axis_m", 1e20), "semi_major_axis_m = 1e+20: must be less than"),
        (put(*ORBIT, "true_anomaly_deg", 1e20), "true_anomaly_deg = 1e+20: must be less than"),
        (put("targets", 0, "prize", 1e300), "field targets[0].prize = 1e+300: must be less than"),
        (put("targets", 0, "prize", 1e-310), "prize = 1e-310: must be 0 or at least 1e-12"),
        (put(*TANK, "delta_v_m_s", 1e16), "field chasers[0].tank.delta_v_m_s = 1e+16: must be"),
        (put("name", ""), 'field name = "": must not be empty'),
        (put("name", "a\0b"), 'field name = "a\\u0000b": must not contain a NUL'),
        (put(*ORBIT, "raan_deg", math.nan), "field targets[0].orbit.raan_deg = NaN: must be a fin"),
        (put("targets", 1, "prize", math.inf), "field targets[1].prize = Infinity: must be a fini"),
        (put(*TANK, "delta_v_m_s", -math.inf), "chasers[0].tank.delta_v_m_s = -Infinity: must"),
        (put(*ORBIT, "eccentricity", 1.0), "field targets[0].orbit.eccentricity = 1.0: must be le"),
        (put(*ORBIT, "eccentricity", -0.1), "field targets[0].orbit.eccentricity = -0.1: must be"),
        (put(*ORBIT, "semi_major_axis_m", 6.3e6), "perigee radius of 6300000 m is under the gro"),
        (put(*ORBIT, "eccentricity", 0.5), "field targets[0].orbit: the perigee radius"),
        (put("targets", 2, "name", "debris-001"), "field targets[2].name = 'debris-001': another"),
        (put("stations", 0, "name", "debris-002"), "field targets[1].name = 'debris-002': another"),
        (put("mission", "duration_s", -1.0), "field mission.duration_s = -1.0: must be greater"),
        (
            put("mission", "duration_s", 8.86e9),
            "field mission.duration_s = 8860000000.0: must be l",
        ),
        (put("transfer", "max_phasing_revolutions", 1.5), "max_phasing_revolutions = 1.5: must be"),
        (put("transfer", "max_altitude_m", 2e5), "max_altitude_m = 200000.0 must be greater than"),
        (
            put("transfer", "drift_step_s", 0.0),
            "field transfer.drift_step_s = 0.0: must be greater",
        ),
        (put("transfer", "delta_v_resolution_m_s", -0.1), "delta_v_resolution_m_s = -0.1: must be"),
        (put("transfer", "departure_spacing_s", -1.0), "departure_spacing_s = -1.0: must be great"),
        (put("transfer", "time_value_m_s_per_h", 75.0), "transfer.time_value_m_s_per_h: unknown"),
        (put("mission", "delta_v_m_s", 3000.0), "field mission.delta_v_m_s: unknown; remove it"),
        (put("mission", "service_revolutions", -1.0), "mission.service_revolutions = -1.0: must"),
        (put("mission", "service_s", 60.0), "field mission: must give service_revolutions or serv"),
        (put("mission", "service_revolutions", None), "or service_s, but gives none of them"),
        (put("chasers", []), "field chasers: must not be empty"),
        (drop("chasers"), "field chasers: missing"),
        (put(*CHASER, "name", "debris-002"), "field chasers[0].name = 'debris-002': another body"),
        (put(*CHASER, "start", {"station": "here"}), "chasers[0].start.station = 'here': unknown"),
        (put(*CHASER, "end", {"station": "there"}), "chasers[0].end.station = 'there': unknown"),
        (put(*CHASER, "start", {"station": 3}), "field chasers[0].start.station = 3: must be a st"),
        (put(*CHASER, "start", {"place": 3}), 'field chasers[0].start: must be {"station": NAME}'),
        (put(*CHASER, "start", "home"), 'field chasers[0].start = "home": must be {"station": N'),
        (put(*CHASER, "start", {"orbit": {}}), "field chasers[0].start.orbit.semi_major_axis_m: m"),
        (put(*CHASER, "end", "home"), 'field chasers[0].end = "home": must be "anywhere" or {'),
        (put(*CHASER, "end", 3), 'field chasers[0].end = 3: must be "anywhere" or {"station": N'),
        (put(*CHASER, "max_targets", -1), "field chasers[0].max_targets = -1: must be greater"),
        (put(*CHASER, "available_s", [5.0, 4.0]), "field chasers[0]: available_s = [5.0, 4.0] m"),
        (put(*CHASER, "colour", "red"), "field chasers[0].colour: unknown"),
        (put(*TARGET, "window_s", [5.0, 4.0]), "field targets[0]: window_s = [5.0, 4.0] must not"),
        (put(*TARGET, "window_s", [5.0]), "field targets[0].window_s[1]: missing"),
        (put(*TARGET, "window_s", [None, 5.0]), "field targets[0].window_s[0] = null: must be a n"),
        (put(*TARGET, "mass_kg", 0.0), "field targets[0].mass_kg = 0.0: must be greater than 0"),
        (put(*TARGET, "required", 1), "field targets[0].required = 1: must be a"),
        (put(*TARGET, "removal", "burn"), "field targets[0].removal = \"burn\": must be 'visit'"),
        (put("dynamics", "sgp4"), "field dynamics = \"sgp4\": must be 'two-body' or 'j2'"),
        (put("transfer", "max_drift_s", 1e6), "max_drift_s = 1000000.0: no plane drifts in two-b"),
        (put("transfer", "max_drift_s", -1.0), "field transfer.max_drift_s = -1.0: must be great"),
        (
            put("objective", "cost", "fame"),
            "field objective.cost = \"fame\": must be 'delta-v', 'duration' or",
        ),
    ],
)
def test_broken_instance_field(cli: Cli, tiny_file: Path, change: Change, named: str) -> None:
    """A broken field of an instance is named with its file, path, value and rule."""
    content = json.loads(tiny_file.read_text(encoding="utf-8"))
    change(content)
    tiny_file.write_text(json.dumps(content), encoding="utf-8")
    refused(cli("solve", tiny_file, "--method", "greedy", "--out", "p.json"), "tiny.json: ", named)
    assert not Path("p.json").exists()


@pytest.mark.parametrize(
    ("change", "named"),
    [(put(*TARGET, "removal", "tow"), 'targets[0].removal = "tow": the cost of a tow depends')],
)
def test_what_the_format_names_and_nothing_can_plan(
    cli: Cli, tiny_file: Path, change: Change, named: str
) -> None:
    """What only later versions can plan is refused when it is read, with what to write instead."""
    content = json.loads(tiny_file.read_text(encoding="utf-8"))
    change(content)
    tiny_file.write_text(json.dumps(content), encoding="utf-8")
    refused(cli("solve", tiny_file, "--method", "greedy", "--out", "p.json"), "tiny.json: ", named)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("{nope", "not JSON"),
        ("", "not JSON"),
        ("[" * 10_000, "not JSON"),
        ("[]", "the file must be a JSON object"),
        ('{"a": 1', "not JSON"),
    ],
)
@pytest.mark.parametrize("verb", ["solve", "check", "fly", "bound", "matrix", "export", "report"])
def test_file_that_is_no_instance(cli: Cli, text: str, named: str, verb: str) -> None:
    """Every verb that reads an instance says that a file is none."""
    Path("bad.json").write_text(text)
    more = {
        "solve": ["--method", "greedy"],
        "check": ["plan.json"],
        "fly": ["plan.json"],
        "bound": ["--method", "none"],
        "matrix": ["--at", "0", "--out", "c.npz"],
        "export": ["plan.json", "--out", "m.oem"],
        "report": ["plan.json", "--out", "m.html"],
    }
    outcome = cli(verb, "bad.json", *more[verb])
    if verb == "bound":  # there is none to be asked for, and that is said first
        refused(outcome, "'none'")
    else:
        refused(outcome, "bad.json: ", named)


def test_files_that_cannot_be_read(cli: Cli, tiny_file: Path) -> None:
    """A missing file, a folder and bytes that are no text are told apart."""
    Path("binary.json").write_bytes(b"\xff\xfe\x00")
    refused(cli("solve", "none.json", "--method", "greedy"), "none.json: no such file; check")
    refused(cli("solve", ".", "--method", "greedy"), ".: this is a folder")
    refused(cli("solve", "binary.json", "--method", "greedy"), "binary.json: not a text file")
    refused(cli("check", tiny_file, "none.json"), "none.json: no such file; check")
    refused(cli("solve", tiny_file, "--start", "none.json", "--method", "greedy"), "none.json: no")


def test_a_rule_between_fields_names_them() -> None:
    """Of a part of a file the sentence says the fields, not that the whole file is wrong."""
    zone = KeepOutZone(min_altitude_m=1.0, max_altitude_m=2.0, start_s=0.0, end_s=1.0)
    with pytest.raises(InputError, match=r"^max_altitude_m = 0\.0 must not be less than min_alt"):
        zone.replace(max_altitude_m=0.0)


def test_windows_of_another_mission(cli: Cli, tiny_file: Path) -> None:
    """A file with windows of an object that is no target is named."""
    Path("w.csv").write_text("target,opens_s,closes_s\nnobody,0,1\n")
    refused(cli("windows", tiny_file, "--within", "w.csv"), "w.csv: 'nobody' is not a target of")


def test_unknown_names(cli: Cli, tiny_file: Path) -> None:
    """An unknown method, bound, family or option is answered with those there are."""
    refused(cli("solve", tiny_file, "--method", "magic"), "'magic'", "greedy, greedy-guarded")
    refused(cli("bound", tiny_file, "--method", "magic"), "'magic'")
    refused(cli("solve", tiny_file, "--method", "greedy", "--bound", "magic"), "'magic'")
    refused(cli("generate", "gigantic"), "family 'gigantic' is unknown", "tiny, nominal")
    refused(
        cli("solve", tiny_file, "--method", "greedy", "--option", "gamma=1"),
        "'gamma'",
        "'greedy'",
        "alpha, beta",
    )


@pytest.mark.parametrize(
    ("assignment", "named"),
    [
        (["alpha"], "'alpha': give it as NAME=VALUE"),
        (["=1"], "'=1': give it as NAME=VALUE"),
        (["alpha=much"], "alpha = 'much' of method 'greedy': give a number"),
        (["alpha=nan"], "alpha = nan"),
        (["alpha=1", "alpha=2"], "alpha is given twice"),
        (["seed=1"], "'seed'"),
    ],
)
def test_bad_method_options(cli: Cli, tiny_file: Path, assignment: list[str], named: str) -> None:
    """A malformed, repeated or out-of-range --option is named."""
    given = [part for text in assignment for part in ("--option", text)]
    refused(cli("solve", tiny_file, "--method", "greedy", *given), named)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--time-limit", "0"),
        ("--time-limit", "-5"),
        ("--time-limit", "nan"),
        ("--seed", "-1"),
        ("--seed", str(2**64)),
        ("--iterations", "0"),
    ],
)
def test_numbers_out_of_range(cli: Cli, tiny_file: Path, option: str, value: str) -> None:
    """A limit or seed out of range is named with its value."""
    outcome = cli("solve", tiny_file, "--method", "greedy", "--out", "p.json", option, value)
    refused(outcome, f"{option[2:].replace('-', ' ')} = {value}: must be")
    assert not Path("p.json").exists()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--targets", "-1"], "targets = -1"),
        (["--zones", "-1"], "zones = -1"),
        (["--seed", "-1"], "seed = -1"),
    ],
)
def test_generate_numbers_out_of_range(cli: Cli, arguments: list[str], named: str) -> None:
    """The generator's numbers are checked, and no file is left behind."""
    refused(cli("generate", "tiny", "--out", "my.json", *arguments), named)
    assert not Path("my.json").exists()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (drop("routes", 0, "legs", 0, "arrival_s"), "field routes[0].legs[0].arrival_s: missing"),
        (
            put("routes", 0, "legs", 0, "arrival_s", math.nan),
            "field routes[0].legs[0].arrival_s = NaN",
        ),
        (
            put("routes", 0, "legs", 0, "burns", 0, "phase", "warp"),
            'field routes[0].legs[0].burns[0].phase = "warp"',
        ),
        (
            put("routes", 0, "legs", 0, "burns", 0, "delta_v_m_s", [1.0]),
            "field routes[0].legs[0].burns[0].delta_v_m_s",
        ),
        (
            put("routes", 0, "legs", 0, "burns", 0, "delta_v_m_s", [0.0, 1e160, 0.0]),
            "delta_v_m_s[1] = 1e+160",
        ),
        (
            put("routes", 0, "legs", 0, "burns", 0, "time_s", 1e308),
            "burns[0].time_s = 1e+308: must be less",
        ),
        (
            put("routes", 0, "legs", 0, "ready_s", -1e308),
            "field routes[0].legs[0].ready_s = -1e+308: must be greater",
        ),
        (put("routes", 0, "legs", 0, "colour", "red"), "field routes[0].legs[0].colour: unknown"),
        (put("routes", 0, "legs", 0, "kind", "magic"), "legs[0].kind = \"magic\": must be 'short'"),
        (drop("routes", 0, "chaser"), "field routes[0].chaser: missing"),
        (drop("cost"), "field cost: missing"),
        (put("legs", []), "field legs: unknown"),
        (put("status", "great"), 'field status = "great"'),
        (put("instance", "sha256", "abc"), 'field instance.sha256 = "abc"'),
        (put("instance", "sha256", "0" * 64), "belongs to the instance 'tiny-000' (sha256 0000"),
    ],
)
@pytest.mark.parametrize("verb", VERBS_OF_PLANS)
def test_broken_plan_field(
    cli: Cli, tiny_file: Path, change: Change, named: str, verb: str
) -> None:
    """A broken field of a plan is named with its file, path and value."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    content = json.loads(Path("plan.json").read_text(encoding="utf-8"))
    change(content)
    Path("plan.json").write_text(json.dumps(content), encoding="utf-8")
    refused(cli(verb, tiny_file, "plan.json", *VERBS_OF_PLANS[verb]), "plan.json: ", named)
    assert not any(Path(name).exists() for name in VERBS_OF_PLANS[verb])


def test_plan_of_another_instance(cli: Cli, tiny_file: Path) -> None:
    """A plan is refused by all but the instance that it was made for."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    cli("generate", "tiny", "--seed", "1", "--out", "other.json")
    for verb, more in VERBS_OF_PLANS.items():
        outcome = cli(verb, "other.json", "plan.json", *more)
        refused(outcome, "plan.json: ", "'tiny-000'", "'tiny-001'")
