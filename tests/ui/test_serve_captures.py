"""``serve``: windows of light and contact, and what is asked of a plan before it is flown."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from serve_at import At
from serve_catalogue import catalogue

import adr_opt
from adr_opt.analysis.screening.position_errors import COLUMNS

for package in ("starlette", "uvicorn", "sgp4", "starlette.testclient"):
    pytest.importorskip(package)

ERRORS = ",".join(COLUMNS) + "\nchaser,3,100,20,400,0,0,100\n*,2,1e8,0,4e8,0,1e6,1e8\n"
STATIONS = "name,latitude_deg,longitude_deg,altitude_m\nhill,64.0,20.0,300\n"


@pytest.fixture
def at(tmp_path: Path) -> Iterator[At]:
    """A desk with a mission of six targets for two days."""
    desk = At(tmp_path / "project")
    letters = (f"20001{chr(65 + at // 26)}{chr(65 + at % 26)} ".encode() for at in range(60))
    desk.drop("all.tle", re.sub(rb"20001A  ", lambda _: next(letters), catalogue(60)))
    names = desk.get("/objects")["names"]
    options = {"max_targets": 6, "duration_days": 2.0}
    desk.post("/choose", {"names": names, "options": options})
    yield desk
    desk.close()


def worked(at: At, verb: str, *results: int, **options: object) -> dict[str, Any]:
    """The result of a verb that is pressed, with what its job says."""
    asked = {"verb": verb, "options": options, "results": list(results)}
    job = at.done(at.post("/jobs", asked)["job"])
    assert job["state"] == "done", job
    row = next(row for row in at.get("/results") if row["id"] == job["result"])
    return {**row, "answer": job["said"]}


def planned(at: At) -> adr_opt.Instance:
    """The instance at hand once the mission as edited is planned."""
    at.post("/plan", {"method": "greedy", "time_limit_s": 30.0})
    assert at.session._work.wait(60.0)
    assert at.get("/state")["plan"]["fits"]
    return adr_opt.load(at.session.folder.path / "instance.json")


def test_captures_wait_for_windows_that_are_found(at: At) -> None:
    """Found for all targets, taken up as an edit, replaced by others, lifted, and undone.

    Those of a mission that was edited meanwhile are not taken up.
    """
    free, first = at.session.instance(), at.session.instance().targets[0].name
    at.post("/edit", {"targets": {"names": [first], "excluded": True}})
    at.drop("s.csv", STATIONS.encode())
    asked = {"light": True, "contact": "hill, troll", "capture": 300.0}
    result = worked(at, "windows", **asked)
    assert result["answer"].endswith("% of the time")
    assert "windows.csv" in result["files"]
    state = at.get("/state")
    assert (state["captures"], state["undoes"]) == ("found", "captures in windows")
    at.post("/edit", {"targets": {"names": [first], "excluded": False}})
    lit = at.session.instance()
    assert {target.capture_s for target in lit.targets} == {300.0}
    assert all(len(lit.intervals_of(target)) > 3 for target in lit.targets)

    # Others are found within the windows that targets came with, not within these.
    worked(at, "windows", light=True, contact=None, margin=0.0)
    more = at.session.instance()
    longer = [more.intervals_of(target) for target in more.targets]
    assert all(
        (each[:, 1] - each[:, 0]).sum() > (old[:, 1] - old[:, 0]).sum()
        for each, old in zip(longer, map(lit.intervals_of, lit.targets), strict=True)
    )
    at.post("/lift")
    assert (at.session.instance(), at.get("/state")["captures"]) == (free, None)
    at.post("/undo")
    assert at.session.instance() == more
    at.post("/edit", {"duration_s": 86400.0})
    assert not at.session.take_windows(result["id"])


def test_a_plan_in_windows_is_kept_with_them(at: At, tmp_path: Path) -> None:
    """Without an excluded target as well; the archive has the files, and opens again."""
    worked(at, "windows", light=True, contact=None)
    last = at.session.instance().targets[-1].name
    at.post("/edit", {"targets": {"names": [last], "excluded": True}})
    instance = planned(at)
    assert last not in {target.name for target in instance.targets}
    at.post("/edit", {"targets": {"names": [instance.targets[0].name], "prize": 2.0}})
    with zipfile.ZipFile(io.BytesIO(at.client.get("/export").content)) as archive:
        archive.extractall(tmp_path / "archive")
    folder = tmp_path / "archive" / "project"
    assert adr_opt.load(folder / "instance.json") == instance
    assert adr_opt.load(folder / "draft.json").targets[0].prize == 2.0
    plan = adr_opt.load_plan(folder / "plan.json")
    assert adr_opt.check(adr_opt.load(folder / "instance.json"), plan) == ()


@pytest.mark.slow
def test_what_a_licence_asks_is_pressed(at: At) -> None:
    """A plan that keeps away from objects is screened and disposed of; files can be downloaded."""
    asked = {"verb": "screen", "options": {}, "results": []}
    assert at.post("/jobs", asked, 422)["error"] == "plan first"
    planned(at)
    assert at.post("/jobs", asked, 422)["error"] == "refine the plan first"
    at.drop("e.csv", ERRORS.encode())
    refined = worked(at, "refine")
    screened = worked(at, "screen", distance=1e6, messages=True)
    assert screened["inputs"] == [*refined["inputs"], refined["id"]]
    assert {"approaches.csv", "messages.zip", "screening.html"} <= set(screened["files"])
    assert "approach" in screened["answer"]
    page = at.client.get("/results/page", params={"id": screened["id"]}).text
    assert "Nearest approaches" in page
    asked_file = {"id": screened["id"], "name": "messages.zip"}
    packed = at.client.get("/results/file", params=asked_file).content
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert archive.read(archive.namelist()[0]).startswith(b"CCSDS_CDM_VERS")
    disposed = worked(at, "dispose", years=25.0)
    told = json.loads(
        at.client.get(
            "/results/file", params={"id": disposed["id"], "name": "disposal.json"}
        ).content
    )
    assert told["fates"]
    assert disposed["has_page"]
    held = worked(at, "solve", method="greedy", around=True, avoid=2e3)
    assert held["has_plan"]
    again = worked(at, "screen", held["id"])
    assert again["inputs"] == [held["id"]]
