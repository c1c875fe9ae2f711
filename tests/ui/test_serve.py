"""``serve``: the desk behind the page, and access to it."""

from __future__ import annotations

import asyncio
import html
import json
import math
import os
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused
from hand_made import hand_made
from serve_desks import at_hand, files_under, of, session_of, until, wait

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.ui.serve.drafts import read_edit
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.planning import PlannedRun, PlanningOrder
from adr_opt.ui.serve.session import EditingSession
from adr_opt.ui.serve.work import Work

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
testclient = pytest.importorskip("starlette.testclient")

from adr_opt.ui.serve import guard  # noqa: E402
from adr_opt.ui.serve.app import ShownReport, application, event_stream  # noqa: E402
from adr_opt.ui.serve.backend import Backend  # noqa: E402

TOKEN, PORT = "a-token", 8123
GREEDY = {"method": "greedy-guarded", "time_limit_s": 20.0}


@pytest.fixture
def world(tmp_path: Path) -> Path:
    """A folder with an instance and files of others, of which none may change."""
    hand_made().save(tmp_path / "my.json")
    (tmp_path / "plan.json").write_text("somebody's")
    (tmp_path / "draft.json").write_text("somebody's")
    return tmp_path


@pytest.fixture
def desk(world: Path) -> Iterator[EditingSession]:
    """A desk whose working folder is `work` in there; none of the other files may change."""
    before = files_under(world)
    made = session_of(hand_made(), None, Folder(world / "work", world / "my.json"))
    yield made
    assert made.close(60.0)
    after = files_under(world)
    assert {name: after[name] for name in before} == before
    assert {Path(name).parts[0] for name in after.keys() - before.keys()} <= {"work"}


def let_in(desk: EditingSession, **more: Any) -> Any:
    """A client that has the token."""
    app = application(Backend(desk), TOKEN, PORT, threading.Event())
    client = testclient.TestClient(app, base_url=f"http://127.0.0.1:{PORT}", **more)
    client.cookies.set(f"adr-opt-{PORT}", TOKEN)
    return client


CHANGES = "edit undo redo plan stop sample upload lift choose jobs/stop show files/remove"
POSTS = [f"/{name}" for name in CHANGES.split()]
"""Addresses that nothing is got from."""


def test_without_the_token_nothing_is_answered(desk: EditingSession) -> None:
    """Every address, with no token or a wrong one, in the query or in the cookie: 403."""
    client = let_in(desk)
    client.cookies.clear()
    gets = "choices state events report other objects forms jobs results results/page "
    gets += "results/file export"
    for wrong in ("", "?token=", "?token=A-token", "?token=é", "?tokens=a-token"):
        for path in map("/{}".format, ["", "page.css", "page.js", "results/points", *gets.split()]):
            assert client.get(path + wrong).status_code == 403, path + wrong
        for path in (*POSTS, "/jobs"):
            assert client.post(path + wrong, json={}).status_code == 403, path + wrong
    client.cookies.set(f"adr-opt-{PORT}", "a-toke")
    assert client.get("/state").status_code == 403
    client.cookies.set(f"adr-opt-{PORT + 1}", TOKEN)
    assert client.get("/state").status_code == 403
    assert desk.revision == 0


def test_the_token_opens_the_page_and_becomes_a_cookie(desk: EditingSession) -> None:
    """The address that is printed gives the page, under a strict law; its cookie does the rest."""
    client = let_in(desk)
    client.cookies.clear()
    page = client.get(f"/?token={TOKEN}")
    assert page.status_code == 200
    policy = page.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    cookie = page.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    for path in ("/page.css", "/page.js", "/state", "/report", "/"):
        answer = client.get(path)
        assert answer.status_code == 200, path
        assert answer.headers["cache-control"] == "no-store"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert not [name for name in answer.headers if name.startswith("access-control")]
    framed = client.get("/report").headers["content-security-policy"]
    assert framed == "sandbox allow-scripts allow-downloads allow-modals; frame-ancestors 'self'"
    assert not any(word in page.text for word in ("<style", "onclick", "style=", TOKEN))


@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example"},
        {"host": f"evil.example:{PORT}"},
        {"host": "127.0.0.1"},
        {"host": f"127.0.0.1:{PORT + 1}"},
        {"host": f"127.0.0.1.evil.example:{PORT}"},
        {"host": ""},
        {"origin": "http://evil.example"},
        {"origin": f"http://127.0.0.1:{PORT + 1}"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_other_hosts_and_other_pages_are_refused(
    desk: EditingSession, headers: dict[str, str]
) -> None:
    """Names that lead here (DNS rebinding), and pages elsewhere, get 403 with a valid cookie."""
    client = let_in(desk)
    assert client.get("/state", headers=headers).status_code == 403
    answer = client.post("/edit", json=of("north", prize=3.0), headers=headers)
    assert answer.status_code == 403
    assert desk.state()["undoes"] is None


def test_a_page_of_an_earlier_server_changes_nothing(desk: EditingSession) -> None:
    """A page says which server it is of, and another one at the same port refuses it."""
    client = let_in(desk)
    mine = client.get("/").text.partition('data-server="')[2].partition('"')[0]
    for said, status in ((mine, 200), (mine[::-1] + "0", 409), ("SERVER", 409)):
        headers = {"adr-opt-server": said}
        assert client.get("/choices", headers=headers).status_code == status
        answer = client.post("/edit", json=of("north", prize=3.0), headers=headers)
        assert answer.status_code == status
    assert desk.revision == 1


def test_what_changes_something_is_a_post_of_json_of_sensible_size(desk: EditingSession) -> None:
    """Other methods, other types and too large requests are refused, and change nothing."""
    client = let_in(desk)
    for path in POSTS:
        assert client.get(path).status_code == 405
    for method in ("PUT", "DELETE", "PATCH", "OPTIONS"):
        assert client.request(method, "/edit", json={}).status_code == 405
    text = json.dumps(of("north", prize=3.0))
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        assert client.post("/edit", content=text, headers={"content-type": kind}).status_code == 415
    is_json = {"content-type": "application/json"}
    large = text + " " * guard.MOST_BYTES
    assert client.post("/edit", content=large, headers=is_json).status_code == 413

    def unsaid() -> Iterator[bytes]:
        yield text.encode()
        for _ in range(17):
            yield b" " * 2**16

    assert client.post("/edit", content=unsaid(), headers=is_json).status_code == 413
    for wrong in (b"", b"{", b"\xff", b"[]", b'{"duration_s": NaN}', b'{"duration_s": 1e999}'):
        answer = client.post("/edit", content=wrong, headers=is_json)
        assert answer.status_code == 422, wrong
        assert list(answer.json()) == ["error"]
    for path in ("/../my.json", "/%2e%2e/my.json", "/work/draft.json", "/draft.json"):
        assert client.get(path).status_code == 404
    assert desk.revision == 0


def test_a_day_at_the_desk(desk: EditingSession, world: Path) -> None:
    """Edit, plan, edit, undo: the page hears of it, and the folder holds a plan that is legal."""
    pytest.importorskip("plotly")
    client = let_in(desk)
    assert "No plan yet" in client.get("/report").text
    folder = world / "work"
    assert at_hand(folder) == ["draft.json"]
    assert client.post("/edit", json=of("far", excluded=True)).status_code == 200
    assert client.post("/edit", json=of("north", prize=5.0)).status_code == 200
    wrong = client.post("/edit", json=of("north", prize=-5.0))
    assert wrong.status_code == 422
    assert wrong.json()["error"].startswith("“Prize” = -5 must be")
    assert adr_opt.load(folder / "draft.json") == desk._history.draft.instance

    assert client.post("/plan", json=GREEDY).status_code == 200
    assert wait(desk).phase == "done"
    state = client.get("/state").json()
    assert state["plan"]["fits"]
    assert state["plan"]["targets"] == 3
    assert at_hand(folder) == ["instance.json", "plan.json"]
    planned = adr_opt.load(folder / "instance.json")
    plan = adr_opt.load_plan(folder / "plan.json")
    assert [each.prize for each in planned.targets] == [5.0, 1.0, 1.0]
    assert adr_opt.check(planned, plan) == ()
    assert state["plan"]["objective"] == plan.objective >= 6.0
    assert "1 January" in client.get("/report").text

    # Edited on: the plan stays with its own instance, and the draft is kept beside it.
    client.post("/edit", json={"duration_s": 60_000.0})
    state = client.get("/state").json()
    assert not state["plan"]["fits"]
    assert at_hand(folder) == ["draft.json", "instance.json", "plan.json"]
    assert adr_opt.load(folder / "instance.json") == planned
    client.post("/plan", json=GREEDY)
    assert wait(desk).phase == "done"
    other = adr_opt.load_plan(folder / "plan.json")
    assert other.instance.sha256 != plan.instance.sha256

    # Undone: the former plan is there again, and that it was undone can be undone.
    client.post("/undo", json={})
    state = client.get("/state").json()
    assert (state["plan"]["fits"], state["redoes"]) == (True, "duration 0.694444 d")
    assert adr_opt.load_plan(folder / "plan.json") == plan
    assert adr_opt.load(folder / "instance.json") == planned
    client.post("/redo", json={})
    assert adr_opt.load_plan(folder / "plan.json") == other


def test_each_change_answers_with_the_state_that_it_leaves(desk: EditingSession) -> None:
    """What is asked after an answer can be asked of the state in it."""
    client = let_in(desk)
    for path, content in (
        ("/edit", {"duration_s": 60_000.0}),
        ("/undo", {}),
        ("/redo", {}),
        ("/lift", {}),
        ("/stop", {}),
    ):
        state = client.post(path, json=content).json()["state"]
        assert state == client.get("/state").json()
        assert state["revision"] == desk.revision


def test_what_cannot_be_planned_is_said_on_the_page(desk: EditingSession) -> None:
    """Unknown methods and limits are refused; a mission without a plan says why."""
    client = let_in(desk)
    for wrong, named in (
        ({**GREEDY, "method": "nobody"}, "nobody"),
        ({**GREEDY, "time_limit_s": 0.0}, "time limit"),
        ({**GREEDY, "time_limit_s": 1e9}, "time limit"),
        ({**GREEDY, "bound": "nobody"}, "nobody"),
        ({**GREEDY, "folder": "/"}, "folder"),
        ({"method": "greedy-guarded"}, "time_limit_s"),
    ):
        answer = client.post("/plan", json=wrong)
        assert answer.status_code == 422
        assert named in answer.json()["error"]
    assert desk.progress().phase == "idle"
    client.post("/plan", json=GREEDY)
    assert wait(desk).phase == "done"
    assert client.get("/state").json()["plan"] is not None
    client.post("/edit", json=of("far", required=True))
    client.post("/plan", json=GREEDY)
    look = wait(desk)
    assert look.phase == "done"
    assert look.said.startswith("no plan: ")
    assert client.get("/state").json()["plan"] is None
    assert look.said in html.unescape(client.get("/report").text)


def heard(desk: EditingSession, until: str, seconds: float = 60.0) -> list[tuple[str, Any]]:
    """Server-sent events, up to the one of a run in that phase."""

    async def listen() -> list[tuple[str, Any]]:
        found, end = [], time.monotonic() + seconds
        async for text in event_stream(Backend(desk), threading.Event()):
            event, data = text.removesuffix("\n\n").split("\n")
            found.append((event.removeprefix("event: "), json.loads(data.removeprefix("data: "))))
            assert time.monotonic() < end
            if event == "event: work" and found[-1][1]["phase"] == until:
                return found
        return found

    return asyncio.run(listen())


def test_incumbent_and_bound_are_told_as_they_come(desk: EditingSession) -> None:
    """Events tell the state, then the run, in numbers that JSON knows, and the plan at the end."""
    desk.plan(PlanningOrder(method="exact", time_limit_s=60.0))
    events = heard(desk, "done")
    assert events[0][0] == "state"
    last = events[-1][1]
    assert (last["incumbent"], last["bound"], last["gap"]) == (3.0, 3.0, 0.0)
    assert last["points"][-1][1:] == [3.0, 3.0]
    assert last["said"].startswith("3 targets visited, optimal prize")
    assert desk.state()["plan"]["objective"] == 3.0
    # One timetable for all that differ in prizes, targets and tanks.
    known = desk._work._reused._built
    desk.edit(read_edit(json.dumps(of("south", excluded=True))))
    desk.plan(PlanningOrder(method="exact", time_limit_s=60.0))
    assert wait(desk).incumbent == 2.0
    desk.edit(read_edit(json.dumps({"budget": {"chaser": "chaser", "amount": 1000.0}})))
    desk.plan(PlanningOrder(method="exact", time_limit_s=60.0))
    assert wait(desk).phase == "done"
    assert desk._work._reused._built is known


def test_the_run_ends_with_what_its_plan_states(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On part of a timetable nothing is proven but what is trivial: in the end no bound is told."""
    monkeypatch.setattr(front, "TABLE_BYTES", 1e-4 * 2.0**30)
    field = adr_opt.generate("nominal", 0, targets=30)
    field.save(tmp_path / "my.json")
    made = session_of(field, None, Folder(tmp_path / "work", tmp_path / "my.json"))
    made.plan(PlanningOrder(method="auto", time_limit_s=3.0))
    look, plan = wait(made), made.state()["plan"]
    assert any("nothing is proven" in note for note in plan["notes"])
    assert plan["upper_bound"] is None
    told = look.to_dict()
    assert (told["incumbent"], told["bound"]) == (plan["objective"], None)
    assert told["gap"] is None
    assert list(told["points"][-1][1:]) == [plan["objective"], None]
    assert "none given" in str(ShownReport(made).text())


def test_the_run_ends_with_what_the_result_states(desk: EditingSession) -> None:
    """What was told on the way gives way to the result, which the plan and its report have."""
    instance = hand_made()
    result = adr_opt.solve(instance, "beam")

    def told_more(*args: Any, progress: Any, **more: Any) -> Result:
        progress(1.0, 2.5)
        return result

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(front, "run", told_more)
        desk.plan(PlanningOrder(method="beam", time_limit_s=3.0))
        look = wait(desk)
    known = [
        value if math.isfinite(value) else None for value in (result.objective, result.upper_bound)
    ]
    assert [look.to_dict()[name] for name in ("incumbent", "bound")] == known
    plan = desk.state()["plan"]
    assert [plan[name] for name in ("objective", "upper_bound")] == known


@pytest.mark.usefixtures("methods")
def test_stop_ends_a_run_and_a_second_press_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run that would take an hour ends when it is told to; a second one waits for the first."""
    monkeypatch.chdir(tmp_path)
    results: list[tuple[str, float]] = []

    def done(instance: Instance, result: PlannedRun) -> str:
        assert result.plan is not None
        results.append((instance.name, result.plan.objective))
        return "well"

    made, field = Work(done), adr_opt.generate("tiny", 0)

    made.begin(field, PlanningOrder(method="patient", time_limit_s=3600.0), None)
    until(lambda: made.progress().incumbent == 1.0)
    look = made.progress()
    assert (look.phase, look.bound, look.runs, look.stopping) == ("planning", 4.0, True, False)
    made.begin(
        field.replace(name="second"), PlanningOrder(method="patient", time_limit_s=3600.0), None
    )
    until(lambda: made.progress().incumbent == 1.0)
    assert made.progress().number == 2
    assert results == [("tiny-000", 3.0)]  # what every method falls back on
    made.stop()
    assert made.wait(60.0)
    look = made.progress()
    assert (look.number, look.phase, look.said, look.stopping) == (2, "done", "well", True)
    assert [name for name, _ in results] == ["tiny-000", "second"]
    made.begin(field, PlanningOrder(method="patient", time_limit_s=3600.0), None)
    made.begin(field, PlanningOrder(method="patient", time_limit_s=3600.0), None)
    made.stop()
    assert made.wait(60.0)
    assert made.progress().number == 4


@pytest.mark.parametrize(
    ("place", "error", "said"),
    [
        (
            "adr_opt.run.front.run",
            ZeroDivisionError("by nothing"),
            "greedy-guarded failed: ZeroDivisionError: by nothing",
        ),
        (
            "adr_opt.ui.serve.project.results.Results.keep_plan",
            InputError("the disk is full"),
            "the disk is full",
        ),
    ],
)
def test_a_planner_that_fails_leaves_its_reason_alone(
    desk: EditingSession, monkeypatch: pytest.MonkeyPatch, place: str, error: Exception, said: str
) -> None:
    """Whatever goes wrong in a run is said, without figures of another one; the next one begins."""
    client = let_in(desk)
    desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=10.0))
    assert wait(desk).phase == "done"
    assert (desk.state()["result"], desk.state()["of_last_run"]) == (1, True)

    def broken(*given: Any, **more: Any) -> Result:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(place, broken)
        desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=10.0))
        look = wait(desk)
    assert (look.phase, look.said) == ("failed", said)
    state = client.get("/state").json()
    assert (state["plan"], state["result"], state["of_last_run"]) == (None, None, True)
    assert not any(visited for *_, visited, _, _, _ in state["targets"])
    report = client.get("/report").text
    assert said in report
    assert "Planning failed" in report
    # What is shown afterwards is not of the run that has failed.
    desk.show(1)
    assert (desk.state()["result"], desk.state()["of_last_run"]) == (1, False)
    desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=10.0))
    assert wait(desk).phase == "done"
    assert desk.state()["of_last_run"]


def test_a_plan_begins_from_the_one_before(
    desk: EditingSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rest of the last plan is the start of the next one, unless refused."""
    starts: list[Any] = []
    run = front.run

    def noting(*given: Any, **more: Any) -> Result:
        starts.append(given[3].start)
        return run(*given, **more)

    monkeypatch.setattr(front, "run", noting)
    desk.plan(PlanningOrder(method="exact", time_limit_s=60.0))
    wait(desk)
    desk.edit(read_edit(json.dumps(of("north", excluded=True))))
    for order in (
        PlanningOrder(method="exact", time_limit_s=60.0),
        PlanningOrder(method="exact", time_limit_s=60.0, goes_on=False),
        PlanningOrder(method="greedy", time_limit_s=20.0),
    ):
        desk.plan(order)
        assert wait(desk).phase == "done"
    assert starts == [None, ("south", "station", "beyond"), None, None]


def test_several_chasers_have_budgets_of_their_own(tmp_path: Path) -> None:
    """Of a campaign each tank is changed by itself, and what comes out is a legal campaign."""
    instance = adr_opt.generate("campaign", 0, targets=5)
    desk = session_of(instance, None, Folder(tmp_path / "work", tmp_path / "my.json"))
    second = instance.chasers[1].name
    desk.edit(read_edit(json.dumps({"budget": {"chaser": second, "amount": 0.0}})))
    desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=20.0))
    assert wait(desk).phase == "done"
    planned = adr_opt.load(tmp_path / "work/instance.json")
    plan = adr_opt.load_plan(tmp_path / "work/plan.json")
    assert [each.tank.delta_v_m_s for each in planned.chasers] == [1000.0, 0.0, 1000.0]
    assert adr_opt.check(planned, plan) == ()
    assert plan.legs
    assert not plan.routes[1].legs
    assert [each["amount"] for each in desk.state()["chasers"]] == [1000.0, 0.0, 1000.0]


def test_work_of_an_earlier_call_is_not_overwritten(world: Path, cli: Cli) -> None:
    """A folder with work in it is used only to continue it; links are not followed."""
    plan = adr_opt.solve(hand_made(), "exact").plan
    assert plan is not None
    session_of(hand_made(), plan, Folder(world / "work", world / "my.json"))
    with pytest.raises(InputError, match=r"holds instance\.json of an earlier call"):
        Folder(world / "work", world / "my.json")
    folder = Folder(world / "work", world / "work/instance.json")
    with pytest.raises(InputError, match="belongs to the instance"):
        session_of(hand_made(periods=15.0), plan, folder)
    again = session_of(adr_opt.load(world / "work/instance.json"), plan, folder)
    assert again.state()["plan"]["fits"]
    assert at_hand(world / "work") == ["instance.json", "plan.json"]
    (world / "work/draft.json").symlink_to(world / "my.json")
    before = files_under(world)
    again.edit(read_edit(json.dumps(of("north", prize=2.0))))
    assert "a link" in again.state()["trouble"]
    after = files_under(world)
    # The edit itself is in the project, and nothing else is touched.
    assert {name for name in after if after[name] != before.get(name)} == {
        "work/project.json",
        f"work/history/{again.instance().sha256[:16]}/instance.json",
    }
    assert before.keys() <= after.keys()


def test_wrong_calls_are_one_sentence_and_make_nothing(world: Path, cli: Cli) -> None:
    """A missing file, a taken port or folder, a plan of another instance: exit 2, no folder."""
    hand_made(periods=15.0).save(world / "other.json")
    plan = adr_opt.solve(hand_made(periods=15.0), "greedy-guarded").plan
    assert plan is not None
    plan.save(world / "of-other.json")
    before = sorted(path.name for path in world.iterdir())
    for arguments, named in (
        (["nobody.json"], "nobody.json: no such file"),
        (["my.json", "nobody.json"], "nobody.json: no such file"),
        (["my.json", "of-other.json"], "belongs to the instance"),
        (["my.json", "--port", "70000"], "--port 70000"),
        (["my.json", "--folder", "my.json"], "my.json: not a folder"),
        (["my.json", "--folder", "no/where"], "no/where: the folder"),
        (["my.json", "--folder", "."], "holds plan.json of an earlier call"),
    ):
        if named.startswith("holds"):
            (world / "sub").mkdir()
            (world / "sub/plan.json").touch()
            arguments = ["my.json", "--folder", "sub"]
            before.append("sub")
        refused(cli("serve", *arguments, "--no-open"), named)
        assert sorted(path.name for path in world.iterdir()) == sorted(before)


def test_without_its_packages_the_verb_says_how_to_get_them(
    world: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where Starlette or uvicorn is missing: one sentence with the extra, exit 2."""
    for package in ("uvicorn", "starlette"):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, package, None)
            for name in list(sys.modules):
                if name.startswith(
                    ("adr_opt.ui.serve.server", "adr_opt.ui.serve.app", f"{package}.")
                ):
                    patch.delitem(sys.modules, name)
            refused(cli("serve", "my.json", "--no-open"), package, "[serve]")
    assert not os.path.lexists(world / "my-served")


def test_numbers_that_are_not_finite_are_null(
    desk: EditingSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """NaN and infinities, wherever they come from, end neither an answer nor the events."""
    known = desk.state

    def spoilt() -> dict[str, Any]:
        return known() | {"duration_s": math.nan, "chasers": [{"amount": math.inf}, (-math.inf,)]}

    monkeypatch.setattr(desk, "state", spoilt)
    state = let_in(desk).get("/state").json()
    assert (state["duration_s"], state["chasers"]) == (None, [{"amount": None}, [None]])
    desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=20.0))
    events = heard(desk, "done")
    assert [event["duration_s"] for name, event in events if name == "state"][:1] == [None]
