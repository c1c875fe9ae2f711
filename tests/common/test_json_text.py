"""A key that stands twice in an object is refused by its name, in every file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.json_text import loaded, parse_json
from adr_opt.common.records import Record
from adr_opt.plan.certificate import load_certificate
from adr_opt.plan.refined_plan import load_refined
from adr_opt.problem.instance_file import InstanceFile
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.sources.catalogue.reading import read
from adr_opt.sources.ephemerides.elements_file import read_elements
from adr_opt.sources.uncertainty.table import read_table
from adr_opt.study import Study
from adr_opt.study.file import head_of, line_of, rows_of
from adr_opt.study.file import read as read_study
from adr_opt.ui.cli.replan import read_zones
from adr_opt.ui.serve.drafts import read_edit
from adr_opt.ui.serve.objects.recognise import recognised
from adr_opt.ui.serve.project.record import ProjectRecord, ResultRecord

TWICE = '{"format": "%s", "key": {"a": 1, "b": [{"a": 2, "a": 3}]}}'
"""A text with a key twice in an object within it, whatever else it lacks."""

STUDY: Study[int, int] = Study("any", 1, print)
HEAD = line_of(head_of(STUDY))

DOORS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    "instance": ("adr-opt-instance/2", adr_opt.load),
    "newer": ("adr-opt-instance/3", adr_opt.load),
    "plan": ("adr-opt-plan/2", adr_opt.load_plan),
    "refined": ("adr-opt-refined/1", load_refined),
    "certificate": ("adr-opt-certificate/1", load_certificate),
    "uncertainty": ("adr-opt-uncertainty/1", Uncertainty.load),
    "errors": ("adr-opt-target-errors/1", lambda path: read_table(path, ())),
    "elements": ("adr-opt-elements/1", lambda path: read_elements(path.read_bytes(), str(path))),
    "zones": ("", lambda path: read_zones(str(path))),
    "dropped": ("adr-opt-instance/2", lambda path: recognised(path, str(path))),
    "study": ("adr-opt-study/1", lambda path: read_study(path, STUDY)),
    "row": ("", lambda path: rows_of(path, HEAD + path.read_bytes(), STUDY)),
    "edit": ("", lambda path: read_edit(path.read_text())),
    "project": ("", lambda path: adr_opt.common.files.read_model(path, ProjectRecord)),
    "result": ("", lambda path: adr_opt.common.files.read_model(path, ResultRecord)),
}


@pytest.mark.parametrize("door", DOORS)
def test_no_key_stands_twice_in_a_file(door: str, tmp_path: Path) -> None:
    """Every reader names the key, before anything else that is wrong with the file."""
    said, read_it = DOORS[door]
    path = tmp_path / "file.json"
    path.write_text(TWICE % said + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=r'field "a" occurs twice in one object; keep one') as told:
        read_it(path)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    "door", ["instance", "plan", "refined", "certificate", "uncertainty", "project", "result"]
)
def test_a_file_of_another_kind_is_called_so(door: str, tmp_path: Path) -> None:
    """All that another kind of file lacks follows from its format, which alone is named."""
    path = tmp_path / "file.json"
    path.write_text('{"format": "adr-opt-library/1", "name": "x"}', encoding="utf-8")
    with pytest.raises(InputError, match=r"; this is a file of another kind$") as told:
        DOORS[door][1](path)
    assert 'format = "adr-opt-library/1"' in str(told.value)


@pytest.mark.parametrize("key", ["NORAD_CAT_ID", "norad_cat_id", "OWN_FIELD"])
def test_no_key_stands_twice_in_a_catalogue(key: str, tmp_path: Path) -> None:
    """Keywords of OMM in any spelling, and every other key as it is spelt."""
    path = tmp_path / "catalogue.json"
    path.write_text(f'[{{"NORAD_CAT_ID": 5, "OWN_FIELD": 1, "{key}": 7}}]', encoding="utf-8")
    with pytest.raises(InputError, match=f"field {key.upper()} is given twice in one object"):
        read([path])


def test_what_no_key_stands_twice_in_is_read() -> None:
    """Keys may stand once in each of several objects, and texts keep all that they say."""
    content = {"a": {"a": [{"a": 1}, {"a": 2.5}]}, "b": None, "c": "a"}
    assert loaded(json.dumps(content)) == content
    assert parse_json(json.dumps(content).encode(), "x.json") == content


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"{", "not JSON: "),
        (b"\xff", "not JSON: not text in UTF-8"),
        (b"[" * 10**5, "not JSON: nested too deeply"),
        (b"[" + b"9" * 5000 + b"]", "not JSON: a number is too long"),
        (('{"' + "k" * 100 + '": 1, "' + "k" * 100 + '": 1}').encode(), 'field "' + "k" * 58 + "…"),
    ],
)
def test_what_is_no_json_is_one_sentence(text: bytes, said: str) -> None:
    """A text that cannot be parsed is refused with its reason, and long keys are cut."""
    with pytest.raises(InputError) as told:
        parse_json(text, "x.json")
    assert str(told.value).startswith(f"x.json: {said}")
    assert len(str(told.value)) < 200


def test_no_record_has_a_door_of_its_own() -> None:
    """All records are read from JSON by the one function that looks at their keys."""

    def below(kind: type[Record]) -> list[type[Record]]:
        return [each for one in kind.__subclasses__() for each in (one, *below(one))]

    own = {each for each in below(Record) if "from_json" in vars(each)}
    assert own == {InstanceFile}, "files of /2 are read in other words: format_2.read"
