"""Costs that are functions of time (docs/model.md section 9): the file, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from timed_enumeration import arrival_of
from timed_fields import SPAN_S, drawn_function, timed_mission

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.kernels.legs.given import legs_of
from adr_opt.problem.given import among, of_rows, only
from adr_opt.problem.given_functions import of_breakpoints


def saved(seed: int = 1) -> dict:
    """The content of the files of a mission, which is saved as my.json."""
    drawn = map(timed_mission, range(seed, 99))
    next(each for each in drawn if not each.given.names).save("my.json")
    return json.loads(Path("f.json").read_text())


@pytest.mark.parametrize("seed", range(6))
def test_files_give_back_what_was_saved(tmp_path: Path, seed: int) -> None:
    """An instance, its functions and its connections, saved and loaded, are the same."""
    pytest.importorskip("pyarrow")
    instance = timed_mission(seed)
    instance.save(tmp_path / "my.json")
    again = adr_opt.load(tmp_path / "my.json")
    assert again == instance
    assert again.sha256 == instance.sha256
    assert again.given.functions.sha256 == instance.given.functions.sha256
    for pair in instance.given.functions.pairs:
        ours, theirs = (each.given.functions.of_pair(*pair) for each in (instance, again))
        assert all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))


def test_a_file_without_functions_does_not_name_them(tmp_path: Path) -> None:
    """Where only connections are given, neither the file nor its digest knows of functions."""
    pytest.importorskip("pyarrow")
    instance = timed_mission(0)
    columns = {
        "origin": ["s0"],
        "destination": ["t0"],
        "departure_s": [0.0],
        "arrival_s": [5.0],
        "delta_v_m_s": [0.0],
    }
    listed = instance.with_given(of_rows(columns, instance.names))
    content = json.loads(listed.to_json())["transfer"]["given"]
    assert sorted(content) == ["file", "sha256"]
    content = json.loads(instance.with_given(only(instance.given.functions)).to_json())
    assert sorted(content["transfer"]["given"]) == ["functions", "functions_sha256"]


@pytest.mark.parametrize("seed", range(40))
def test_the_earliest_leg_is_that_of_the_definition(seed: int) -> None:
    """No later departure arrives earlier, and none leaves before it is ready or overtakes."""
    rng = np.random.default_rng(seed)
    points = drawn_function(rng)
    ready = np.sort(np.concatenate([rng.random(40) * SPAN_S, points[:, 0], points[:, 0] + 1e-3]))
    leaves, lands = legs_of(points[:, 0].copy(), points[:, 1].copy(), ready)
    wanted = [arrival_of([tuple(point) for point in points.tolist()], time) for time in ready]
    assert lands == pytest.approx(wanted, abs=1e-9)
    assert (np.diff(lands[np.isfinite(lands)]) >= 0.0).all()
    assert (leaves >= ready - 1e-6).all()


WRONG = {
    "overtakes": (lambda row: row.update(breakpoints_s=[[0, 50], [10, 40]]), "before the earlier"),
    "order": (lambda row: row.update(breakpoints_s=[[10, 40], [0, 50]]), "in order"),
    "no time": (lambda row: row.update(breakpoints_s=[[10, 10]]), "must take"),
    "back in time": (lambda row: row.update(breakpoints_s=[[10, 5]]), "must take"),
    "three at once": (
        lambda row: row.update(breakpoints_s=[[1, 5], [1, 6], [1, 7]]),
        "a jump has two",
    ),
    "none": (lambda row: row.update(breakpoints_s=[]), "breakpoints_s"),
    "negative": (lambda row: row.update(breakpoints_s=[[-1, 5]]), "from 0 to"),
    "too late": (lambda row: row.update(breakpoints_s=[[1, 1e300]]), "from 0 to"),
    "one number": (lambda row: row.update(breakpoints_s=[[1]]), "breakpoints_s"),
    "text": (lambda row: row.update(breakpoints_s=[["1", 2]]), "breakpoints_s"),
    "unknown body": (lambda row: row.update(origin="nobody"), "'nobody' is not a body"),
    "itself": (lambda row: row.update(origin=row["destination"]), "ends where it begins"),
    "negative cost": (lambda row: row.update(delta_v_m_s=-1.0), "delta_v_m_s"),
    "unknown key": (lambda row: row.update(speed=1.0), "speed"),
    "no origin": (lambda row: row.pop("origin"), "origin"),
}


@pytest.mark.parametrize("what", WRONG)
def test_damaged_functions_are_refused(cli: Cli, tmp_path: Path, what: str) -> None:
    """Each kind of damage is one sentence with the file in it, and exit code 2."""
    content = saved()
    damage, said = WRONG[what]
    damage(content["functions"][0])
    Path("f.json").write_text(json.dumps(content))
    refused(cli("solve", "my.json"), "f.json", said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "JSON"),
        ("[]", "f.json"),
        ('{"format": "adr-opt-functions/2", "functions": []}', "format"),
        ('{"functions": []}', "format"),
        (None, "no such file"),
    ],
)
def test_other_files_are_refused(cli: Cli, tmp_path: Path, text: str | None, said: str) -> None:
    """What is no file of functions is refused in one sentence."""
    saved()
    Path("f.json").unlink() if text is None else Path("f.json").write_text(text)
    refused(cli("solve", "my.json"), said)


def test_functions_of_another_digest_are_refused(cli: Cli, tmp_path: Path) -> None:
    """Functions that were changed are others than the instance names."""
    content = saved()
    content["functions"][0]["breakpoints_s"][-1][1] += 1.0
    Path("f.json").write_text(json.dumps(content))
    refused(cli("solve", "my.json"), "f.json: not the functions", "functions_sha256")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "names no file"),
        ({"functions": "f.parquet"}, "functions"),
        ({"functions": "../f.json"}, "functions"),
        ({"functions": "f.json", "sha256": 64 * "0"}, "that of no file"),
        ({"file": "f.nc", "functions_sha256": 64 * "0"}, "that of no file"),
    ],
)
def test_references_that_make_no_sense_are_refused(
    cli: Cli, tmp_path: Path, given: dict, said: str
) -> None:
    """A reference names a file, and digests belong to files that are named."""
    saved()
    content = json.loads(Path("my.json").read_text())
    content["transfer"]["given"] = given
    Path("my.json").write_text(json.dumps(content))
    refused(cli("solve", "my.json"), said)


def test_a_pair_has_a_list_or_a_function() -> None:
    """A pair with both, a pair with two functions, and a file over the instance are refused."""
    instance = timed_mission(0)
    origin, destination = instance.given.functions.pairs[0]
    columns = {
        "origin": [origin],
        "destination": [destination],
        "departure_s": [0.0],
        "arrival_s": [5.0],
        "delta_v_m_s": [0.0],
    }
    with pytest.raises(InputError, match="give one of the two"):
        of_rows(columns, instance.names).with_functions(instance.given.functions)
    with pytest.raises(InputError, match="two functions"):
        of_breakpoints(2 * [(origin, destination, [[0.0, 1.0]], 0.0)], instance.names)
    alone = instance.with_given(only(instance.given.functions))
    with pytest.raises(InputError, match="same name"):
        alone.save("f.json")


def test_other_methods_and_listings_are_refused_in_a_sentence(cli: Cli, tmp_path: Path) -> None:
    """What needs lists of connections says so, and names the methods that do not."""
    saved()
    for method in ("greedy", "beam", "mip", "local-search", "mcts", "ortools"):
        said = "does not follow functions of time", "use one of: auto, exact"
        refused(cli("solve", "my.json", "--method", method), *said)
    refused(cli("bound", "my.json", "--method", "lagrangian"), "functions of time")
    refused(cli("matrix", "my.json", "--at", 0, "--out", "m.npz"), "function of time")


def test_a_part_of_the_bodies_keeps_its_functions() -> None:
    """Functions of bodies that go are gone, and a start takes over those of the body it is at."""
    instance = timed_mission(3)
    functions = instance.given.functions
    kept = among(instance.given, ("s0", "t0"), {"t1": "van"}).functions
    wanted = {pair for pair in functions.pairs if set(pair) <= {"s0", "t0"}}
    for here, there in functions.pairs:
        if here == "t1" and there in ("s0", "t0"):
            wanted.add(("van", there))
    assert set(kept.pairs) == wanted
