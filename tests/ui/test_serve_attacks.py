"""``serve``: attacks on what is dropped, asked for and exported."""

from __future__ import annotations

import gzip
import io
import json
import os
import shutil
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hand_made import hand_made
from serve_at import BYTES, At
from serve_catalogue import catalogue
from serve_desks import files_under

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.ui.serve.jobs import queue
from adr_opt.ui.serve.jobs.job import Job
from adr_opt.ui.serve.jobs.verbs import VERBS
from adr_opt.ui.serve.project.record import ResultRecord
from adr_opt.ui.serve.project.results import Results, now

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
pytest.importorskip("starlette.testclient")

from adr_opt.ui.serve import guard


def zipped(name: str, content: bytes) -> bytes:
    """A zip file with one file in it."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        made.writestr(name, content)
    return file.getvalue()


OMM = b'<?xml version="1.0"?>%s<ndm><omm id="CCSDS_OMM_VERS" version="2.0">&a;</omm></ndm>'
LAUGHS = b'<!DOCTYPE a [<!ENTITY a "ha">%s]>' % b"".join(
    b'<!ENTITY a%d "%s">' % (at, b"&a;" * 10) for at in range(10)
)
ELSEWHERE = b'<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (OMM % LAUGHS, "DOCTYPE"),
        (OMM % ELSEWHERE, "DOCTYPE"),
        (b'<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/passwd">]><oem>&a;</oem>', "DOCTYPE"),
        (gzip.compress(b"0" * 10**6), "compressed"),
        (zipped("../../a.tle", b"0" * 10**6), "compressed"),
        (b"[" * 10**6, "JSON"),
        (b'{"format": "adr-opt-instance/2", "a": ' + b"[" * 10**6, "JSON"),
        (b'{"format": "adr-opt-project/1"}', "of no use"),
        (b"", "empty"),
        (b"\x00" * 1000, "not a text file"),
        (b"\xff\xfe1\x00", "UTF-16"),
        (b"<html><title>Log in</title></html>", "web page"),
    ],
)
def test_what_cannot_be_used_is_one_sentence(at: At, content: bytes, named: str) -> None:
    """Bombs, compressed and foreign files are refused at once, and nothing of them is kept."""
    before = files_under(at.session.folder.path)
    began = time.process_time()
    error = at.drop("bomb.xml", content, 422)["error"]
    assert time.process_time() - began < 5.0
    assert named in error
    assert "\n" not in error
    assert "passwd" not in error
    assert str(at.session.folder.path) not in error
    assert files_under(at.session.folder.path) == before


def test_an_instance_with_files_of_others_is_refused(at: At) -> None:
    """A dropped instance names no file, be it beside it."""
    content = json.loads(hand_made().to_json())
    content["transfer"]["given"] = {"file": "a.parquet", "sha256": "0" * 64}
    error = at.drop("i.json", json.dumps(content).encode(), 422)["error"]
    assert "refers to other files" in error
    content["transfer"]["given"] = {"file": "../a.parquet", "sha256": "0" * 64}
    at.drop("i.json", json.dumps(content).encode(), 422)


@pytest.mark.parametrize(
    "name",
    [
        "../../up.tle",
        "/etc/passwd",
        "..\\..\\up.tle",
        "a\x00b",
        "-rf",
        "--out=x",
        ".",
        "..",
        "ü/…",
        "con",
        "n" * 200,
        "\u202egnp.exe",
        "results/0001-solve/plan.json",
        ".passing-1",
    ],
)
def test_a_name_is_only_shown(at: At, tmp_path: Path, name: str) -> None:
    """Whatever a file is called, it lies in the folder for it, under a name that is harmless."""
    at.drop(name, catalogue(3))
    (file,) = (at.session.folder.path / "files").iterdir()
    assert file.name.startswith("1-")
    assert file.name.isascii()
    assert {path.name for path in tmp_path.iterdir()} == {"project"}
    (shown,) = at.get("/state")["files"]
    assert shown["name"].isprintable()
    assert not {"/", "\\"} & set(shown["name"])


def test_an_upload_is_limited_before_it_is_read(at: At, monkeypatch: pytest.MonkeyPatch) -> None:
    """A gigabyte, said or streamed, other content types and names without end: nothing is kept."""
    send = at.client.post
    said = {**BYTES, "content-length": str(10**9)}
    assert send("/upload?name=a", content=b"", headers=said).status_code == 413
    for wrong in ("-1", "1e3", "²", "9" * 30):
        headers = {**BYTES, "content-length": wrong.encode()}
        assert send("/upload?name=a", content=b"", headers=headers).status_code == 413, wrong
    monkeypatch.setattr(guard, "MOST_UPLOADED_BYTES", 2**20)
    taken = []

    def without_end() -> Iterator[bytes]:
        for _ in range(1000):
            taken.append(1)
            yield b"0" * 2**16

    answer = send("/upload?name=a", content=without_end(), headers=BYTES)
    assert answer.status_code == 413
    for kind in ("application/json", "text/plain", "multipart/form-data", ""):
        headers = {"content-type": kind}
        assert send("/upload?name=a", content=b"1", headers=headers).status_code == 415, kind
    for path in ("/edit", "/jobs", "/choose", "/upload/", "//upload"):
        assert send(path, content=b"{}", headers=BYTES).status_code in (404, 415), path
    for name in ("", "n" * 201):
        assert (
            send("/upload", params={"name": name}, content=b"1", headers=BYTES).status_code == 422
        )
    assert list(files_under(at.session.folder.path)) == ["project.json"]


@pytest.mark.parametrize(
    ("verb", "options", "named"),
    [
        ("serve", {}, "not offered"),
        ("bound --out", {}, "not offered"),
        ("bound", {"method": "--certificate=/tmp/x"}, "must be one of"),
        ("bound", {"method": "exact\n--out"}, "must be one of"),
        ("bound", {"out": "/tmp/x"}, "unknown"),
        ("bound", {"--out": "/tmp/x"}, "unknown"),
        ("bound", {"seed": -1}, "must be 0 to"),
        ("bound", {"seed": 0.5}, "whole"),
        ("bound", {"seed": True}, "must be a number"),
        ("bound", {"seed": "--out"}, "must be a number"),
        ("bound", {"certificate": "/tmp/x"}, "true or false"),
        ("bound", {"time_limit_s": 1e9}, "must be"),
        ("tradeoff", {"vary": "--out=/tmp/x"}, "give a range"),
        ("tradeoff", {"vary": "delta-v=1;rm -rf"}, "give a range"),
        ("tradeoff", {"vary": "delta-v=" + "1," * 200}, "at most 200"),
        ("replan", {"lost": "a\x00b"}, "lost"),
        ("replan", {"at_s": None, "cost": "1=2"}, "unknown"),
        ("rehearse", {"policy": "/tmp/evil"}, "must be one of"),
        ("compare", {"results": [1]}, "unknown"),
        ("compare", {"all": [1]}, "true or false"),
        ("check", {}, "plan first"),
        ("worth", {}, "drop a TLE"),
    ],
)
def test_options_of_jobs_are_of_a_fixed_table(
    at: At, verb: str, options: dict[str, Any], named: str
) -> None:
    """No verb, option or value reaches a command line but those of the table, of their types."""
    at.drop("i", hand_made().to_json().encode())
    before = files_under(at.session.folder.path)
    error = at.post("/jobs", {"verb": verb, "options": options, "results": []}, 422)["error"]
    assert named in error
    assert at.get("/jobs") == []
    assert files_under(at.session.folder.path) == before


def test_a_value_never_begins_an_option() -> None:
    """Each word of an option begins with the sign of that option, whatever its value is."""
    for verb in VERBS.values():
        for option in verb.options:
            given: Any = {"number": 1, "flag": True, "choice": None}.get(option.kind, "x=1")
            if option.kind == "choice" and option.choices is not None:
                given = option.choices()[0]
            word = option.word(given)
            assert word is None or word.partition("=")[0] == option.sign
            assert option.sign.startswith("--") or not option.sign


def test_no_address_reads_another_file(at: At) -> None:
    """Pages of results are asked for by numbers, scripts by a fixed list; the rest is refused."""
    at.drop("i", hand_made().to_json().encode())
    client = at.client
    for number in ("", "0", "1", "-1", "1e0", "../1", "٣", "%2e%2e", "1" * 400, "0001-solve"):
        assert client.get("/results/page", params={"id": number}).status_code == 404, number
        asked = {"id": number, "name": "plan.json"}
        assert client.get("/results/file", params=asked).status_code == 404, number
    for path in (
        "/script/../app.py",
        "/script/%2e%2e/app.py",
        "/script/",
        "/script/nothing.js",
        "/files/1-i",
        "/project.json",
        "/results/0001-solve/plan.json",
    ):
        assert client.get(path).status_code == 404, path
    for wrong in ({"result": 1}, {"result": "1"}, {"result": "../x"}, {}):
        at.post("/show", wrong, 422)
    for wrong in ({"job": 1}, {"job": "1"}, {}):
        at.post("/jobs/stop", wrong, 422)
    for wrong in ({}, {"names": []}, {"names": ["x"] * 2001}, {"names": ["x"], "prizes": "all"}):
        at.post("/choose", wrong, 422)
    for wrong in ({"years": 0}, {"years": 1e9}, {"years": "50"}, {"out": "x"}):
        told = at.post("/jobs", {"verb": "worth", "options": wrong}, 422)["error"]
        assert told.startswith(("“Horizon”", "option 'out'")), told
    parts: tuple[Any, ...] = (
        {"path": "targets", "value": []},
        {"path": "name", "value": {}},
        {"path": "chasers", "value": []},
        {"path": "mission", "value": {"duration_s": "1"}},
        {"path": "transfer", "value": {"given": {"file": "/etc/passwd", "sha256": "0" * 64}}},
        {"path": "__class__", "value": {}},
    )
    for part in parts:
        at.post("/edit", {"part": part}, 422)
    plan = adr_opt.solve(hand_made(), "greedy").plan
    assert plan is not None
    made = at.session.results.keep_plan("solve", "a plan", hand_made(), plan)
    for name, status in (("plan.json", 200), ("result.json", 404), ("../../draft.json", 404)):
        asked = {"id": str(made.number), "name": name}
        assert client.get("/results/file", params=asked).status_code == status, name


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_a_folder_with_links_is_not_left(at: At, tmp_path: Path) -> None:
    """What links to other files is neither exported nor shown, nor written through."""
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "key").write_text("secret")
    folder = at.session.folder.path
    (folder / "link").symlink_to(secret / "key")
    (folder / "files").symlink_to(secret)
    answer = at.client.get("/export")
    assert b"secret" not in answer.content
    assert "a link" in at.drop("c", catalogue(3), 422)["error"]
    assert [path.name for path in secret.iterdir()] == ["key"]


def test_only_what_is_of_the_project_is_exported(at: At) -> None:
    """The archive holds what the project knows, whatever else lies in its folder."""
    at.drop("i", hand_made().to_json().encode())
    at.drop("c.tle", catalogue(3))
    folder = at.session.folder.path
    for name in (
        "diary",
        "files/2-mine",
        "history/mine/data",
        "results/mine/data",
        "results/0007-check/data",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("mine")
    os.utime(folder / "project.json", (0, 0))  # before zip files have times
    with zipfile.ZipFile(io.BytesIO(at.client.get("/export").content)) as made:
        names = sorted(name.removeprefix("project/") for name in made.namelist())
    (key,) = [path.name for path in (folder / "history").iterdir() if path.name != "mine"]
    assert names == ["draft.json", "files/1-c.tle", f"history/{key}/instance.json", "project.json"]


def test_no_part_of_an_archive_is_left(at: At, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the disk is full, an export is one sentence and leaves nothing."""

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    before = files_under(at.session.folder.path)
    monkeypatch.setattr(zipfile.ZipFile, "write", full)
    answer = at.client.get("/export")
    assert answer.status_code == 507
    assert "No space left on device" in answer.json()["error"]
    assert files_under(at.session.folder.path) == before


def test_a_running_job_is_listed_whatever_comes_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only jobs that are over drop off the list, the earliest first."""
    monkeypatch.setattr(queue, "MOST_LISTED", 3)
    jobs: list[Job] = []
    for number in range(1, 7):
        job = Job(number, "check", "Check", None, lambda: None)
        if number > 2:
            job.settle("done")
        jobs = queue._listed([*jobs, job])
    assert [job.number for job in jobs] == [1, 2, 6]


@pytest.mark.parametrize("digits", ["9" * 400, "-" + "9" * 400, "9" * 4000, str(2**63)])
def test_numbers_without_end_are_refused(at: At, digits: str) -> None:
    """A whole number of hundreds of digits is one short sentence wherever a number is asked for."""
    at.drop("i", hand_made().to_json().encode())
    for path, content in (
        ("/jobs", '{"verb": "bound", "options": {"seed": %s}}'),
        ("/jobs", '{"verb": "bound", "options": {"time_limit_s": %s}}'),
        ("/jobs", '{"verb": "check", "options": {}, "results": [%s]}'),
        ("/jobs/stop", '{"job": %s}'),
        ("/show", '{"result": %s}'),
    ):
        answer = at.client.post(
            path, content=content % digits, headers={"content-type": "application/json"}
        )
        assert answer.status_code == 422, path
        assert len(answer.json()["error"]) < 200, path


@pytest.mark.skipif(os.name != "posix", reason="needs links")
@pytest.mark.parametrize("file", ["instance.json", "plan.json"])
def test_kept_plans_are_of_the_project_alone(tmp_path: Path, file: str) -> None:
    """A plan or an instance of a result that is a link is not read."""
    plan = adr_opt.solve(hand_made(), "greedy-guarded").plan
    assert plan is not None
    Results(tmp_path / "results").keep_plan("solve", "by hand", hand_made(), plan)
    inside = tmp_path / "results/0001-solve" / file
    outside = inside.rename(tmp_path / file)
    again = Results(tmp_path / "results")
    again.read()
    inside.symlink_to(outside)
    with pytest.raises(InputError, match="a link"):
        again.plan(1)
    (inside.parent / "result.json").unlink()
    again = Results(tmp_path / "results")
    again.read()
    assert again.all() == []
    assert outside.exists()


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_points_are_of_the_project_alone(at: At, tmp_path: Path) -> None:
    """Plans of points that are links, or lie behind one, are not read; a spoilt answer is said."""
    at.drop("i", hand_made().to_json().encode())
    number, place = at.session.results.begin("tradeoff")
    point = {"delta_v_m_s": 1.0, "prize": 1.0, "upper_bound": float("inf")}
    answer = {"varied": {"delta-v": [1.0]}, "points": [point]}
    (place / "answer.json").write_text(json.dumps(answer))
    record = ResultRecord(number=number, verb="tradeoff", label="Trade off", made_at=now())
    at.session.results.done(record)
    secret = tmp_path / "secret"
    secret.mkdir()
    hand_made().save(secret / "point-1.instance.json")
    plan = adr_opt.solve(hand_made(), "greedy-guarded").plan
    assert plan is not None
    plan.save(secret / "point-1.plan.json")
    (place / "plans").symlink_to(secret)
    told = at.get(f"/results/points?id={number}")
    assert told["points"] == [
        {"point": 1, "values": [1.0], "prize": 1.0, "bound": None, "has_plan": False}
    ]
    assert "no plan" in at.post("/show", {"result": number, "point": 1}, 422)["error"]
    (place / "plans").unlink()
    (place / "plans").mkdir()
    for name in ("point-1.instance.json", "point-1.plan.json"):
        (place / "plans" / name).symlink_to(secret / name)
    assert "a link" in at.post("/show", {"result": number, "point": 1}, 422)["error"]
    for name in ("point-1.instance.json", "point-1.plan.json"):
        (place / "plans" / name).unlink()
        shutil.copy(secret / name, place / "plans")
    hand_made(periods=15.0).save(place / "plans/point-1.instance.json")
    assert (
        "belongs to the instance" in at.post("/show", {"result": number, "point": 1}, 422)["error"]
    )
    for spoilt in ("{", "[]", "{}", '{"varied": {"delta-v": []}, "points": [{}]}'):
        (place / "answer.json").write_text(spoilt)
        answer = at.client.get("/results/points", params={"id": str(number)})
        assert answer.status_code == 422
        assert "spoilt" in answer.text or "not JSON" in answer.text, spoilt
