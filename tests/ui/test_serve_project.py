"""``serve``: a project from a catalogue on, by its addresses, and its folder."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from conftest import Cli
from hand_made import hand_made
from serve_at import At
from serve_catalogue import catalogue
from serve_desks import session_of

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.settings import TransferSettings
from adr_opt.ui.cli.entry import command
from adr_opt.ui.serve.drafts import read_edit
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.forms.fields import SELDOM, SHOWN, form_fields
from adr_opt.ui.serve.jobs.verbs import VERBS
from adr_opt.ui.serve.objects.import_options import OPTIONS
from adr_opt.ui.serve.project.record import KEPT_VERBS, ProjectRecord, ResultRecord

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
pytest.importorskip("sgp4")
pytest.importorskip("starlette.testclient")


def test_bad_rows_are_told_with_place_and_cause_and_files_removed(tmp_path: Path) -> None:
    """Of a catalogue each of the first bad rows is named, also when it is reopened, or is bad."""
    at = At(tmp_path / "project")
    lines = catalogue(9).decode().splitlines()
    rows = [row for row, line in enumerate(lines) if line.startswith("1 ")][:7]
    for row in rows:
        lines[row] = lines[row][:-1] + str((int(lines[row][-1]) + 1) % 10)
    broken = "\n".join(lines).encode()
    assert at.drop("few.tle", broken) == {"what": "catalogue", "count": 2, "skipped": 7}
    at.drop("whole.tle", catalogue(20))
    for opened in (at, At(tmp_path / "project")):
        file, whole = opened.get("/state")["files"]
        assert (file["skipped"], len(file["bad"]), whole["bad"]) == (7, 5, [])
        assert [each.partition(" (")[0] for each in file["bad"]] == [
            f"line {row + 1}" for row in rows[:5]
        ]
        assert all("checksum" in each for each in file["bad"]), file["bad"]
    refused = at.drop("none.tle", "\n".join(lines[: rows[1]]).encode(), 422)
    assert f"line {rows[0] + 1}" in refused["error"]
    assert "checksum" in refused["error"]
    at.post("/files/remove", {"file": file["id"]})
    assert [each["name"] for each in at.get("/state")["files"]] == ["whole.tle"]
    assert len(at.get("/objects")["names"]) == 20
    assert "no such file" in at.post("/files/remove", {"file": file["id"]}, 422)["error"]
    at.post("/files/remove", {"file": whole["id"]})
    assert at.get("/objects")["names"] == []
    assert at.get("/state")["stage"] == "empty"
    assert list((tmp_path / "project" / "files").iterdir()) == []


def test_from_a_catalogue_to_a_checked_plan_and_back(tmp_path: Path) -> None:
    """Objects are dropped, chosen, edited, planned, checked and exported; undo outlasts a call."""
    folder = tmp_path / "project"
    at = At(folder)
    assert at.get("/state")["stage"] == "empty"
    assert at.drop("../all\x00.tle", catalogue(200)) == {
        "what": "catalogue",
        "count": 200,
        "skipped": 0,
    }
    objects = at.get("/objects")
    assert {len(objects[name]) for name in ("names", "altitude_km", "raan_deg", "kind")} == {200}
    assert {"debris", "rocket body"} == set(objects["kind"])
    (file,) = at.get("/state")["files"]
    assert (file["name"], file["what"], file["count"]) == ("all?.tle", "catalogue", 200)

    chosen = [
        name
        for name, raan in zip(objects["names"], objects["raan_deg"], strict=True)
        if 100.0 < raan < 130.0
    ][:8]
    at.post("/choose", {"names": chosen})
    state = at.get("/state")
    assert (state["stage"], state["undoes"]) == ("mission", f"{len(chosen)} targets chosen")
    assert [objects["names"][row] for row in at.get("/objects")["chosen"]] == chosen
    # What `import` makes of the same objects.
    (tmp_path / "some.csv").write_text("object\n" + "".join(f"{name}\n" for name in chosen))
    (tmp_path / "all.tle").write_bytes(catalogue(200))
    by_import = adr_opt.sources.catalogue.to_instance(
        adr_opt.sources.catalogue.read(tmp_path / "all.tle"),
        demands=adr_opt.sources.catalogue.Demands(
            wishes=adr_opt.sources.catalogue.read_wishes(tmp_path / "some.csv"), only_wished=True
        ),
    ).instance
    assert at.session.instance().replace(name=by_import.name) == by_import

    chasers = state["instance"]["chasers"]
    chasers[0]["tank"] = {"dry_mass_kg": -1.0, "propellant_kg": 900.0, "isp_s": 300.0}
    refused = at.post("/edit", {"part": {"path": "chasers", "value": chasers}}, 422)
    assert refused["error"].startswith("“Dry mass” of chaser 1 = -1 kg must be")
    chasers[0]["tank"]["dry_mass_kg"] = 500.0
    at.post("/edit", {"part": {"path": "chasers", "value": chasers}})
    assert at.get("/state")["instance"]["chasers"][0]["tank"]["isp_s"] == 300.0

    at.post("/plan", {"method": "greedy", "time_limit_s": 30.0})
    at.post("/stop")
    assert at.session._work.wait(60.0)
    at.post("/plan", {"method": "greedy", "time_limit_s": 30.0})
    assert at.session._work.wait(60.0)
    plan = at.get("/state")["plan"]
    assert plan["fits"]
    job = at.done(at.post("/jobs", {"verb": "check", "options": {}, "results": []})["job"])
    assert (job["state"], job["said"]) == ("done", "no violations")
    rows = at.get("/results")
    assert [row["verb"] for row in rows][-2:] == ["solve", "check"]
    assert rows[-1]["id"] == job["result"]
    assert rows[-1]["exit_status"] == 0
    number = at.get("/state")["result"]

    answer = at.client.get("/export")
    assert answer.headers["content-type"] == "application/zip"
    assert "attachment" in answer.headers["content-disposition"]
    with zipfile.ZipFile(io.BytesIO(answer.content)) as made:
        names = made.namelist()
        assert all(name.startswith("project/") and ".." not in name for name in names)
        told = json.loads(made.read("project/project.json"))
        results = [json.loads(made.read(name)) for name in names if name.endswith("/result.json")]
    assert {"project/instance.json", "project/plan.json", "project/files/1-all-.tle"} <= set(names)
    jsonschema.validate(told, ProjectRecord.json_schema())
    assert len(results) == len(rows)
    for each in results:
        jsonschema.validate(each, ResultRecord.json_schema())
    at.post("/undo")
    assert at.get("/state")["redoes"] == "chasers changed"
    at.close()

    again = At(folder)
    state = again.get("/state")
    assert (state["undoes"], state["redoes"]) == (
        f"{len(chosen)} targets chosen",
        "chasers changed",
    )
    assert (state["result"], state["plan"]["fits"]) == (number, False)
    assert again.get("/results") == rows
    again.post("/redo")
    assert again.get("/state")["plan"]["fits"]
    again.post("/undo")
    again.post("/undo")
    assert again.get("/state")["stage"] == "objects"
    again.post("/edit", {"duration_s": 1.0}, 422)
    again.post("/show", {"result": number})
    state = again.get("/state")
    assert (state["stage"], state["plan"]["fits"]) == ("mission", True)
    assert state["undoes"] == f"result {number} shown"
    again.close()


def test_dropped_files_are_known_by_what_is_in_them(at: At, tmp_path: Path) -> None:
    """Instances, plans, prizes and uncertainty do what they are for, whatever they are called."""
    instance = hand_made()
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    lonely = at.drop("plan.json", plan.to_json().encode(), 422)
    assert "belongs to another instance" in lonely["error"]
    assert at.drop("x.tle", instance.to_json().encode())["what"] == "instance"
    assert at.get("/state")["undoes"] == "x.tle dropped"
    assert at.drop("y", plan.to_json().encode())["what"] == "plan"
    assert at.get("/state")["plan"]["fits"]
    uncertain = {"format": "adr-opt-uncertainty/1", "capture": {"success": 0.9, "tries": 1}}
    assert at.drop("u", json.dumps(uncertain).encode())["what"] == "uncertainty"
    at.drop("c.tle", catalogue(20))
    assert at.drop("p.csv", b"object,prize\n10003,7\nPIECE 4 DEB 10004,8\n")["what"] == "prizes"
    objects = at.get("/objects")
    assert objects["worth_unit"] == "prize"
    assert objects["worth"][3:6] == [7.0, 8.0, None]
    at.post("/choose", {"names": objects["names"][3:5], "prizes": "worth"})
    assert [target[1] for target in at.get("/state")["targets"]] == [7.0, 8.0]
    at.drop("c.tle", catalogue(20, seed=1))  # in place of the one of the same name
    assert len(at.get("/objects")["names"]) == 20
    strange = at.post("/choose", {"names": ["nobody"]}, 422)
    assert strange["error"] == "'nobody' is not an object of the catalogue"


def test_a_history_forgets_its_beginning_where_it_is_too_large(
    at: At, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond the limit on size the earliest steps go, and the folder keeps what is left."""
    at.drop("x", hand_made().to_json().encode())
    size = len(hand_made().to_json())
    monkeypatch.setattr("adr_opt.ui.serve.project_keeper.MOST_BYTES", 4 * size)
    for prize in range(2, 9):
        edit = {"targets": {"names": ["north"], "prize": float(prize)}}
        at.session.edit(read_edit(json.dumps(edit)))
    undone = 0
    while at.get("/state")["undoes"] is not None:
        at.post("/undo")
        undone += 1
    assert 2 <= undone <= 4
    folder = at.session.folder.path
    again = session_of(None, None, Folder(folder))
    assert again.state()["targets"][0][1] == 8.0 - undone
    assert len(list((folder / "history").iterdir())) == undone + 1


def test_forms_have_all_fields_and_words_for_them() -> None:
    """Each number of a chaser, station, mission, transfer and objective has label and limits."""
    fields = {(field["part"], field["path"]): field for field in form_fields()}
    assert fields["chasers", "tank.isp_s"]["unit"] == "s"
    assert fields["chasers", "tank.isp_s"]["of"] == ["tank", "mass"]
    assert fields["chasers", "start"]["choices"] == ["anywhere", "station", "orbit", "launch"]
    disposal = fields["mission", "disposal"]
    assert (disposal["choices"], disposal["optional"]) == (["circle_m", "perigee_m"], True)
    assert fields["mission", "disposal.circle_m"]["of"] == ["disposal", "circle_m"]
    assert fields["mission", "duration_s"]["most"] == 100 * 365.25 * 86400.0
    assert fields["objective", "cost"]["choices"] == ["delta-v", "duration", "expense"]
    assert all(field["label"] for field in fields.values())
    assert (fields["mission", "duration_s"]["unit"], fields["mission", "duration_s"]["by"]) == (
        "d",
        86400.0,
    )
    names = {path.rpartition(".")[2] for _, path in fields}
    assert names >= SELDOM | SHOWN.keys()
    known = {path.rpartition(".")[2] for part, path in fields if part == "transfer"}
    assert known == set(TransferSettings.model_fields) - {"given"}


def test_every_option_of_a_job_is_one_of_its_verb() -> None:
    """The signs of the table are options of the command line."""
    for name, verb in VERBS.items():
        there = command.get_command(None, name)  # type: ignore[arg-type]
        assert there is not None
        known = {sign for each in there.params for sign in each.opts}
        signs = {option.sign for option in verb.options if option.sign}
        assert signs | {output.sign for output in verb.outputs} | {"--json"} <= known, name


def test_what_is_not_the_projects_stays(tmp_path: Path) -> None:
    """A project removes its own unfinished results and unused drafts, and nothing else."""
    assert VERBS.keys() | {"solve"} == KEPT_VERBS
    folder = tmp_path / "p"
    session_of(None, None, Folder(folder))
    for name in (
        "results/2024-run",
        "results/0007-check",
        "results/mine",
        "history/mine",
        "history/0123456789abcdef",
    ):
        (folder / name).mkdir(parents=True)
        (folder / name / "data").write_text("mine")
    session_of(None, None, Folder(folder))
    left = sorted(str(path.relative_to(folder)) for path in folder.glob("*/*"))
    assert left == ["history/mine", "results/2024-run", "results/mine"]


@pytest.mark.parametrize("name", ["results", "history", "files"])
@pytest.mark.parametrize("going_on", [None, "x.json"])
def test_a_folder_of_somebody_else_is_refused(
    tmp_path: Path, name: str, going_on: str | None
) -> None:
    """A folder with one of the names of a project, but without its file, is left as it is."""
    (tmp_path / name / "0001-solve").mkdir(parents=True)
    with pytest.raises(InputError, match=f"holds {name}, but no project.json"):
        Folder(tmp_path, going_on)
    assert (tmp_path / name / "0001-solve").is_dir()


def test_a_spoilt_project_is_one_sentence(tmp_path: Path) -> None:
    """What is no project file, or has a step too few, is refused and left as it is."""
    session_of(hand_made(), None, Folder(tmp_path / "p", "x.json"))
    path = tmp_path / "p/project.json"
    good = json.loads(path.read_text())
    for spoilt, named in (
        ("{", "not JSON"),
        (json.dumps(good | {"at": 7}), "field at = 7"),
        (json.dumps(good | {"format": "adr-opt-project/9"}), "format"),
        (json.dumps(good | {"steps": [{"draft": "../../etc"}]}), "draft"),
    ):
        path.write_text(spoilt)
        with pytest.raises(InputError, match=named):
            session_of(None, None, Folder(tmp_path / "p"))
        assert path.read_text() == spoilt


def test_a_point_of_a_trade_off_opens_its_plan(at: At) -> None:
    """Each point with a plan shows it as a result, with its instance as one step; others do not."""
    at.drop("i", hand_made().to_json().encode())
    options = {"vary": "delta-v=1,600,1200", "method": "greedy-guarded", "time_limit_s": 5.0}
    job = at.post("/jobs", {"verb": "tradeoff", "options": options, "results": []})["job"]
    row = at.done(job)
    assert row["state"] == "done", row
    told = at.get(f"/results/points?id={row['result']}")
    assert (told["titles"], told["across"], told["prize"]) == (
        ["ΔV of a full tank [m/s]"],
        0,
        "prize",
    )
    points = told["points"]
    assert [point["values"] for point in points] == [[1.0], [600.0], [1200.0]]
    prizes = [point["prize"] for point in points]
    assert prizes == sorted(prizes)
    assert prizes[-1] > 0.0
    for point in points[1:]:
        assert point["has_plan"]
        for _ in range(2):  # the second time it is the result of the first
            at.post("/show", {"result": row["result"], "point": point["point"]})
            state = at.get("/state")
            assert state["plan"]["fits"]
            assert state["plan"]["objective"] == point["prize"]
            assert state["chasers"][0]["amount"] == point["values"][0]
    assert state["undoes"] == f"result {state['result']} shown"
    at.post("/undo")
    assert at.get("/state")["chasers"][0]["amount"] == 600.0
    made = at.get("/results")
    assert [result["inputs"] for result in made[1:]] == [[row["result"]]] * 2
    assert made[-1]["label"] == f"point 3 of result {row['result']}"
    for wrong, named in (
        ({"result": row["result"], "point": 9}, "point 9 has no plan"),
        ({"result": made[-1]["id"], "point": 1}, "point 1 has no plan"),
        ({"result": row["result"], "point": 0}, "point"),
        ({"result": row["result"], "point": "../1"}, "point"),
    ):
        assert named in at.post("/show", wrong, 422)["error"]
    for wrong_id in (str(made[-1]["id"]), "0", "../1", ""):
        assert at.client.get("/results/points", params={"id": wrong_id}).status_code == 422


def test_a_trade_off_begins_with_the_plans_there_are(at: At) -> None:
    """Legal plans of the mission are points of its trade-off, at its own budget; others are not."""
    instance = hand_made()
    at.drop("i", instance.to_json().encode())
    best = adr_opt.solve(instance, "exact", time_limit=60.0).plan
    assert best is not None
    illegal = best.replace(objective=best.objective + 1.0)
    for plan, of in ((illegal, instance), (best, instance)):
        at.session.results.keep_plan("solve", "kept", of, plan)
    own = at.get("/state")["chasers"][0]["amount"]
    options = {"vary": f"delta-v={own - 200.0}", "method": "greedy", "time_limit_s": 5.0}
    job = at.post("/jobs", {"verb": "tradeoff", "options": options, "results": []})["job"]
    row = at.done(job)
    assert row["state"] == "done", row
    assert at.get("/results")[-1]["inputs"] == [2]
    last = at.get(f"/results/points?id={row['result']}")["points"][-1]
    assert (last["values"], last["prize"]) == ([own], best.objective)


def test_options_of_an_import_make_the_mission(at: At, cli: Cli, tmp_path: Path) -> None:
    """What `import` makes of the same objects with the same options, prizes by criticality too."""
    at.drop("all.tle", catalogue(60))
    (tmp_path / "all.tle").write_bytes(catalogue(60))
    names = at.get("/objects")["names"]
    options = {
        "epoch": "2026-01-02T00:00:00",
        "duration_days": 200.0,
        "altitude": "700:820",
        "max_targets": 9,
        "station": "750,98.1,100",
        "dry_mass": 800,
        "propellant": 400.0,
        "isp": 1500.0,
        "thrust": 0.2,
        "duty_cycle": 0.5,
        "launches": 2,
        "launch_every": 60,
        "service_days": 1,
        "exclude": "10001,10002",
        "deadline": "10004 = 150; ",
        "require": "10004",
        "max_drift_days": 100,
        "resolution": None,
        "name": "",
    }
    answer = at.post("/choose", {"names": names, "prizes": "criticality", "options": options})
    asked = [f"--{name.replace('_', '-')}={value}" for name, value in options.items() if value]
    asked = [each.replace(" = ", "=").replace("; ", "") for each in asked]
    assert (
        cli("import", "all.tle", "--out", "i.json", *asked, "--criticality", "--quiet").status == 0
    )
    made, by_import = at.session.instance(), adr_opt.load(tmp_path / "i.json")
    assert made == by_import
    assert answer["targets"] == len(made.targets) <= 9
    assert answer["left_out"]["exclude"] == 2
    assert any("criticality" in warning for warning in answer["warnings"])
    assert at.get("/state")["instance"]["dynamics"] == "j2"


def test_a_mission_with_ephemerides_leaves_nothing_beside_the_project(at: At) -> None:
    """The folder in which orbits are fitted goes once they are, also where they cannot be."""
    at.drop("all.tle", catalogue(60))
    names, folder = at.get("/objects")["names"], at.session.folder.path
    options = {"ephemerides": True, "max_targets": 2, "duration_days": 2.0}
    at.post("/choose", {"names": names, "options": options})
    assert at.session.instance().ephemerides is not None
    assert list(folder.glob(".*passing*")) == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"duty_cycle": 0.5},
            "“Duty cycle”: there is no thrust; give “Low thrust”, or leave it out",
        ),
        ({"thrust": 0.2}, "“Low thrust”: the tank is given in ΔV"),
        ({"altitude": "high"}, "“Altitudes kept” = 'high': give two numbers"),
        ({"altitude": "10:20"}, "no object is left of 60"),
        ({"epoch": "today"}, "“Epoch” 'today': give a time"),
        ({"dynamics": "two-body", "max_drift_days": 3}, "“Longest drift” = 3: no plane drifts"),
        ({"dynamics": "three-body"}, "“Dynamics” = 'three-body' must be one of j2, two-body"),
        ({"max_targets": 2.5}, "“Most targets” = 2.5 must be a whole number"),
        ({"station": "nobody"}, "Station"),
        ({"kit_mass": 5}, "“Mass of a kit”: there are no kits"),
        ({"duration_days": -1}, "“Mission duration” = -1 must be a positive number"),
        ({"require": "nobody"}, "Required objects"),
        ({"prizes": "/etc/passwd"}, "'prizes' is not an option of an import"),
        ({"out": "/tmp/x"}, "'out' is not an option of an import"),
        ({"station": "a\nb"}, "Station"),
        ({"name": " "}, "Names kept"),
        ({"max_targets": 0}, "“Most targets” = 0 must be a positive number"),
        ({"exclude": "x" * 20_001}, "at most 20000 characters"),
        ({"exclude": "nobody," * 100}, "no object"),
    ],
)
def test_options_of_an_import_are_refused_by_their_labels(
    at: At, options: dict[str, Any], said: str
) -> None:
    """A value that `import` refuses is one sentence that names the field, and makes nothing."""
    at.drop("all.tle", catalogue(60))
    names = at.get("/objects")["names"]
    error = at.post("/choose", {"names": names, "options": options}, 422)["error"]
    assert said in error
    assert "--" not in error
    assert at.get("/state")["stage"] == "objects"


def test_options_of_an_import_are_those_of_the_verb() -> None:
    """Each field is an option of `import`; those without one are files, filled in or always on."""
    there = command.get_command(None, "import")  # type: ignore[arg-type]
    assert there is not None
    known = {each.opts[0] for each in there.params if each.opts[0].startswith("--")}
    beside = {
        "--out",
        "--prizes",
        "--oem",
        "--skip-bad",
        "--json",
        "--quiet",
        "--help",
        "--criticality",
        "--only-prized",
        "--must",
        "--debug",
    }
    assert {option.sign for option in OPTIONS} == known - beside
    assert len({option.label for option in OPTIONS}) == len(OPTIONS)


def test_dynamics_are_edited_as_one_step(at: At) -> None:
    """The motion of planes is an edit like any other, refused where the instance cannot have it."""
    at.drop("i", adr_opt.generate("electric", 0, targets=4, chasers=1).to_json().encode())
    error = at.post("/edit", {"dynamics": "two-body"}, 422)["error"]
    assert "low thrust" in error or "dynamics" in error
    at.post("/edit", {"dynamics": "moon"}, 422)
    at.drop("i", hand_made().to_json().encode())
    assert at.get("/state")["instance"]["dynamics"] == "two-body"
    at.post("/edit", {"dynamics": "j2"})
    state = at.get("/state")
    assert (state["instance"]["dynamics"], state["undoes"]) == ("j2", "dynamics j2")
    at.post("/undo")
    assert at.get("/state")["instance"]["dynamics"] == "two-body"
