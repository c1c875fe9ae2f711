"""``serve``: edits make the instance that is planned, and are undone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hand_made import hand_made
from serve_desks import at_hand, of, session_of, wait

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.chasers import InOrbit, Tank, TankByMass
from adr_opt.ui.serve import drafts
from adr_opt.ui.serve import history as steps
from adr_opt.ui.serve.drafts import Draft, read_edit, told
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.history import History
from adr_opt.ui.serve.planning import PlanningOrder

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
testclient = pytest.importorskip("starlette.testclient")


def edited(draft: Draft, **edit: Any) -> Draft:
    """A draft after an edit as the page sends it."""
    return draft.edited(read_edit(json.dumps(edit)))


def test_edits_make_the_instance_that_is_planned() -> None:
    """Prizes, requirements, exclusions and limits end up in it, and nothing else changes."""
    first = Draft(hand_made())
    assert first.instance is first.field
    made = edited(first, **of("north", "far", prize=2.5))
    made = edited(made, **of("beyond", required=True))
    made = edited(made, **of("far", excluded=True))
    made = edited(made, duration_s=50_000.0)
    made = edited(made, budget={"chaser": "chaser", "amount": 450.0})
    assert [(each.name, each.prize, each.required) for each in made.instance.targets] == [
        ("north", 2.5, False),
        ("beyond", 1.0, True),
        ("south", 1.0, False),
    ]
    assert made.instance.mission.duration_s == 50_000.0
    assert made.instance.chasers[0].tank == Tank(delta_v_m_s=450.0)
    assert (
        made.instance.replace(
            targets=first.field.targets, mission=first.field.mission, chasers=first.field.chasers
        )
        == hand_made()
    )
    again = edited(made, **of("far", excluded=False))
    assert [each.prize for each in again.instance.targets] == [2.5, 1.0, 1.0, 2.5]


def test_the_last_word_counts_on_required_and_excluded() -> None:
    """Requiring a target includes it, and excluding one ends its requirement."""
    made = edited(Draft(hand_made()), **of("north", excluded=True))
    made = edited(made, **of("north", required=True))
    assert made.excluded == frozenset()
    made = edited(made, **of("north", excluded=True))
    assert not made.field.targets[0].required
    assert [each.name for each in made.instance.targets] == ["beyond", "south", "far"]


def test_a_tank_by_mass_is_changed_by_its_propellant() -> None:
    """Its budget is kilograms; a tank that is not full at the start holds no more than it can."""
    tank = TankByMass(
        dry_mass_kg=500.0, propellant_kg=80.0, isp_s=300.0, initial_propellant_kg=60.0
    )
    instance = hand_made()
    start = InOrbit(orbit=instance.stations[0].orbit)
    chaser = instance.chasers[0].replace(tank=tank, start=start)
    draft = Draft(instance.replace(chasers=(chaser,)))
    assert drafts.amount_of(draft.field.chasers[0]) == 80.0
    made = edited(draft, budget={"chaser": "chaser", "amount": 50.0})
    assert made.field.chasers[0].tank == tank.replace(
        propellant_kg=50.0, initial_propellant_kg=50.0
    )


def test_excluded_targets_take_their_given_connections_along(tmp_path: Path) -> None:
    """Where connections are given, those of excluded targets go; what is left can be read again."""
    instance = hand_made()
    ends = [(0, 1), (1, 2), (0, 3), (3, 1), (2, 4), (1, 0)]
    columns = {
        "origin": [i for i, _ in ends],
        "destination": [j for _, j in ends],
        "departure_s": [100.0] * 6,
        "arrival_s": [5000.0] * 6,
        "delta_v_m_s": [10.0] * 6,
    }
    given = adr_opt.Timetable.from_connections(instance, columns).instance
    made = edited(Draft(given), **of("beyond", excluded=True)).instance
    assert made.given is not None
    assert made.given.names == ("north", "south", "station")
    assert made.given.departure.size == 4
    assert [each.name for each in made.targets] == ["north", "south", "far"]
    # The draft has connections of its own, beside those of the plan.
    pytest.importorskip("pyarrow")
    given.save(tmp_path / "my.json")
    desk = session_of(given, None, Folder(tmp_path / "work", tmp_path / "my.json"))
    desk.plan(PlanningOrder(method="greedy-guarded", time_limit_s=20.0))
    assert wait(desk).phase == "done"
    desk.edit(read_edit(json.dumps(of("beyond", excluded=True))))
    assert adr_opt.load(tmp_path / "work/instance.json").given.sha256 == given.given.sha256
    assert adr_opt.load(tmp_path / "work/draft.json").given.sha256 == made.given.sha256
    desk.undo()
    assert at_hand(tmp_path / "work") == ["connections.parquet", "instance.json", "plan.json"]


@pytest.mark.parametrize(
    ("edit", "named"),
    [
        (of("nobody", prize=1.0), "'nobody' is not a target"),
        (of("north", prize=-1.0), "prize"),
        (of("north", prize=1e-13), "prize"),
        (of("north", required=True, excluded=True), "required and excluded"),
        (of(prize=1.0), "names"),
        ({"targets": {"names": ["north"], "prize": "1"}}, "prize"),
        ({"duration_s": -1.0}, "duration_s"),
        ({"budget": {"chaser": "nobody", "amount": 1.0}}, "'nobody' is not a chaser"),
        ({"budget": {"chaser": "chaser", "amount": -1.0}}, "delta_v_m_s"),
        ({}, "an edit changes one of"),
        ({"duration_s": 1.0, "budget": {"chaser": "chaser", "amount": 1.0}}, "changes one of"),
        ({"path": "/etc/passwd"}, "path"),
        ([1], "object"),
    ],
)
def test_a_wrong_edit_is_one_sentence_and_changes_nothing(edit: Any, named: str) -> None:
    """What is no edit, or no valid value, is refused; the draft stays as it is."""
    history = History(Draft(hand_made()))
    with pytest.raises(InputError, match=named.replace("[", r"\[")) as told:
        history.edit(read_edit(json.dumps(edit)))
    assert "\n" not in str(told.value)
    assert history.undoes is None
    assert history.draft == Draft(hand_made())


def test_edits_are_undone_and_done_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Undo goes back edit by edit, redo forth; a new edit forgets what was undone."""
    history = History(Draft(hand_made()))
    assert not history.undo()
    for prize in (2.0, 3.0, 3.0):
        history.edit(read_edit(json.dumps(of("north", prize=prize))))
    assert history.undoes == "prize of north 3"
    assert history.undo()
    assert (history.undoes, history.redoes) == ("prize of north 2", "prize of north 3")
    assert history.draft.field.targets[0].prize == 2.0
    assert history.undo()
    assert not history.undo()
    assert history.draft.field == hand_made()
    assert history.redo()
    history.edit(read_edit(json.dumps(of("north", "far", excluded=True))))
    assert history.redoes is None
    assert not history.redo()
    assert history.undoes == "2 targets excluded"
    monkeypatch.setattr(steps, "MOST_STEPS", 2)
    for days in (1.0, 2.0, 3.0):
        history.edit(read_edit(json.dumps({"duration_s": 86400.0 * days})))
    assert [history.undo() for _ in range(3)] == [True, True, False]


def test_windows_and_services_are_set_of_several_targets() -> None:
    """Window, service and mass of targets are edits in words, refused as in the file."""
    draft = Draft(hand_made())
    for changes, said in (
        ({"window_s": [100.0, None]}, "window of 2 targets"),
        ({"mass_kg": 800.0}, "mass of 2 targets 800 kg"),
        ({"removal": "visit"}, "service of 2 targets: visit"),
    ):
        edit = read_edit(json.dumps(of("north", "south", **changes)))
        assert told(edit) == said
        draft = draft.edited(edit)
    changed = {each.name: (each.window_s, each.mass_kg) for each in draft.field.targets}
    assert changed["north"] == changed["south"] == ((100.0, None), 800.0)
    assert changed["far"] == ((0.0, None), None)
    edit = read_edit(json.dumps(of("north", mass_kg=None)))
    assert told(edit) == "no mass of north"
    masses = {each.name: each.mass_kg for each in draft.edited(edit).field.targets}
    assert (masses["north"], masses["south"]) == (None, 800.0)
    for wrong, named in (
        ({"window_s": [5.0, 1.0]}, "window_s"),
        ({"mass_kg": -1.0}, "mass_kg"),
        ({"removal": "tow"}, "tow"),
        ({"removal": "eat"}, "removal"),
    ):
        with pytest.raises(InputError, match=named):
            draft.edited(read_edit(json.dumps(of("north", **wrong))))
