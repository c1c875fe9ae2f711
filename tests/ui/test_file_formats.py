"""File formats: what verbs write, what is read again, and what is refused."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from conftest import Cli
from pages import ROOT, read, tables
from timed_fields import timed_mission

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.files import read_model
from adr_opt.common.stability import PROVISIONAL_FORMATS, STABLE_FORMATS, stability
from adr_opt.problem.given_functions import FunctionsFile
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.sources.ephemerides.elements_file import read_elements, to_text
from adr_opt.sources.library import load_library
from adr_opt.sources.uncertainty.table import TargetErrorsFile
from adr_opt.sources.worth.worth_file import WorthFile
from adr_opt.study.file import HEADS_BEFORE
from adr_opt.ui.cli.entry import main
from adr_opt.ui.cli.schema import SCHEMAS
from adr_opt.ui.serve.project.record import ProjectRecord, ResultRecord, StepRecord

CATALOGUE = ROOT / "examples/catalogue/cloud.tle"

CALLS = (
    "generate tiny --out instance.json",
    "solve instance.json --method exact --out plan.json --certificate certificate.json",
    "refine instance.json plan.json --gravity two-body --burns planned --out refined.json",
    f"import {CATALOGUE} --ephemerides --dynamics j2 --max-targets 2 --duration-days 1 "
    "--out imported.json",
    f"worth {CATALOGUE} --candidates 3 --pairs worth.json --out prizes.csv",
)
"""Verbs that write files."""

WRITTEN_BY_HAND = {
    "uncertainty": {"gone": 0.25, "capture": {"success": 0.5, "tries": 3}},
    "target-errors": {"targets": [{"target": "debris-005", "sigma_along_m": 300.0}]},
}
"""Content of formats that no verb writes."""


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _without_nulls(data: Any) -> Any:
    """The same without fields that say nothing, which a file may leave out."""
    if isinstance(data, dict):
        return {name: _without_nulls(each) for name, each in data.items() if each is not None}
    return [_without_nulls(each) for each in data] if isinstance(data, list) else data


def _of(kind: Any) -> Callable[[Path], Any]:
    """A reader that gives what was read as JSON data."""
    return lambda path: read_model(path, kind).model_dump(mode="json")


def _elements(path: Path) -> Any:
    return json.loads(to_text(read_elements(path.read_bytes(), str(path))))


READERS: dict[str, Callable[[Path], Any]] = {
    "instance": lambda path: json.loads(adr_opt.load(path).to_json()),
    "plan": lambda path: json.loads(adr_opt.load_plan(path).to_json()),
    "refined": lambda path: json.loads(adr_opt.load_refined(path).to_json()),
    "certificate": lambda path: json.loads(adr_opt.load_certificate(path).to_json()),
    "uncertainty": lambda path: json.loads(Uncertainty.load(path).to_json()),
    "target-errors": _of(TargetErrorsFile),
    "elements": _elements,
    "functions": _of(FunctionsFile),
    "worth": _of(WorthFile),
    "library": lambda path: json.loads(load_library(path).to_json()),
    "project": _of(ProjectRecord),
    "project-result": _of(ResultRecord),
}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A file of each format, from a verb where one writes it."""
    pytest.importorskip("sgp4")
    folder = tmp_path_factory.mktemp("formats")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for call in CALLS:
            assert main([*call.split(), "--quiet"]) == 0, call
        # Not one with connections beside the functions: those take pyarrow.
        next(each for each in map(timed_mission, range(1, 99)) if not each.given.names).save("t")
        (reference,) = re.findall(r'"functions": "([^"]*)"', Path("t").read_text(encoding="utf-8"))
    imported = _json(folder / "imported.json")["ephemerides"]
    (folder / imported["file"]).rename(folder / "elements.json")
    (folder / reference).rename(folder / "functions.json")
    texts = {
        name: json.dumps({"format": f"adr-opt-{name}/1"} | content)
        for name, content in WRITTEN_BY_HAND.items()
    }
    texts["library"] = read("instances/library.json")
    texts["project"] = ProjectRecord(steps=(StepRecord(draft=None),), at=0).to_json()
    texts["project-result"] = ResultRecord.from_json(
        '{"number": 1, "verb": "check", "label": "plan 1", "made_at": "2026-11-27T00:00:00Z"}'
    ).to_json()
    for name, text in texts.items():
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    return {name: folder / f"{name}.json" for name in SCHEMAS}


@pytest.mark.parametrize("name", SCHEMAS)
def test_files_are_of_their_schema_and_read_without_loss(
    cli: Cli, written: dict[str, Path], name: str
) -> None:
    """A file is valid by the printed schema, and what is read of it has all that it says."""
    content = _json(written[name])
    schema = json.loads(cli("schema", name).out)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(content, schema)
    found = READERS[name](written[name])
    assert _without_nulls(found) == _without_nulls(content)
    again = written[name].with_name("again.json")
    again.write_text(json.dumps(found), encoding="utf-8")
    assert READERS[name](again) == found


@pytest.mark.parametrize("name", SCHEMAS)
def test_other_numbers_are_refused(
    cli: Cli, written: dict[str, Path], name: str, tmp_path: Path
) -> None:
    """Neither the reader nor the schema takes a file of another number, or of none."""
    content = _json(written[name])
    schema = json.loads(cli("schema", name).out)
    kind = content["format"].rpartition("/")[0]
    wrong = [content | {"format": f"{kind}/9"}, content | {"format": "other/1"}]
    for at, each in enumerate(wrong):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(each, schema)
        path = tmp_path / f"other-{at}.json"
        path.write_text(json.dumps(each), encoding="utf-8")
        with pytest.raises(InputError, match="format") as refusal:
            READERS[name](path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_every_format_has_a_promise() -> None:
    """Code, docs/files.md and the changelog know the same formats, and the same of each."""
    found = {
        name
        for package in ("adr_opt", "solvers")
        for file in (ROOT / package).rglob("*.py")
        for name in re.findall(r"adr-opt-[a-z-]+/[0-9]+", file.read_text(encoding="utf-8"))
    } - HEADS_BEFORE
    assert found == {*STABLE_FORMATS, *PROVISIONAL_FORMATS}
    page = read("docs/files.md")
    (rows,) = [rows for _, rows in tables(page) if rows[0] == ["format", "promise"]]
    listed = [(re.findall(r"`(adr-opt[^`]*)`", row[0]), row[1]) for row in rows[2:]]
    stated = {name: promise.partition(":")[0] for names, promise in listed for name in names}
    assert stated == {name: stability(name) for name in found}
    assert found <= set(re.findall(r"`(adr-opt-[^`]*)`", read("CHANGELOG.md")))
    first, others = re.findall(r"adr_opt schema (\w+)\n\nor ([^.]*)\.", page)[0]
    assert [first, *re.findall(r"`([^`]*)`", others)] == list(SCHEMAS)
