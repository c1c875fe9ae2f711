"""Refused edits are told in the words of the forms that they were typed into."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

import adr_opt
from adr_opt import InputError, Instance
from adr_opt.ui.serve.drafts import Draft, read_edit
from adr_opt.ui.serve.forms.fields import form_fields
from adr_opt.ui.serve.forms.refusals import in_labels
from adr_opt.ui.serve.jobs.verbs import VERBS
from adr_opt.ui.serve.objects.import_options import NAMED

TOLD = {
    "field chasers[0].tank.delta_v_m_s = -1.0: must be greater than or equal to 0 (and 1 more)": (
        "“ΔV of a full tank” of chaser 1 = -1 m/s must be at least 0 m/s"
    ),
    "field mission.duration_s = 1e+300: must be less than or equal to 3155760000": (
        "“Duration” = 1.15741e+295 d must be at most 36525 d"
    ),
    "field keep_out_zones[0]: end_s = 86400.0 must not be before start_s = 172800.0": (
        "“Closed until” of keep-out zone 1 = 1 d must not be before “Closed from” = 2 d"
    ),
    "field mission: must give service_revolutions or service_s, but gives both; write exactly "
    "one of the two": (
        "must give “Time at a target [revolutions]” or “Time at a target [min]”, but gives both; "
        "give one of the two"
    ),
    "field mission.duration_s = null: must be a number": "“Duration [d]” must be given",
    "the file window_s = [5.0, 2.0] must not close before it opens": (
        "“Window” = 5.78704e-05 to 2.31481e-05 d must not close before it opens"
    ),
    "there is no catalogue; drop a TLE or OMM file first": (
        "there is no catalogue; drop a TLE or OMM file first"
    ),
}


def refused(field: Instance, part: str, path: str, value: Any) -> str:
    """Why a form's value is refused; empty if it is taken, or belongs to what is not there."""
    content = field.model_dump(mode="json")[part]
    element = content[0] if isinstance(content, list) and content else content
    names, at = path.split("."), element
    for name in names[:-1]:
        at = at.get(name) if isinstance(at, dict) else None
    if not isinstance(at, dict):
        return ""
    at[names[-1]] = value
    try:
        Draft(field).edited(read_edit(json.dumps({"part": {"path": part, "value": content}})))
    except InputError as error:
        return in_labels(str(error))
    return ""


@pytest.mark.parametrize("sentence", TOLD, ids=lambda sentence: sentence[:40])
def test_fields_have_their_labels_and_units(sentence: str) -> None:
    """A field has its label, a value and its limit are in the unit of the form."""
    assert in_labels(sentence) == TOLD[sentence]


@pytest.mark.parametrize("family", ["nominal", "removal", "electric"])
def test_no_refusal_has_names_of_fields(family: str) -> None:
    """Whatever number is refused, the sentence has a label, and no name that a file has."""
    field = adr_opt.generate(family, 0, targets=3)
    count = 0
    for form in form_fields():
        if form["kind"] != "number" or form["part"] == "targets":
            continue
        for value in (-1.0, 1e300, None):
            said = refused(field, form["part"], form["path"], value)
            if said:
                count += 1
                assert "“" in said, said
                assert not re.search(r"[a-z]_[a-z]|^field |\[\d", said), said
    assert count > 20


def test_options_have_their_labels() -> None:
    """Options of the command line have the labels of the forms of imports and of jobs."""
    assert in_labels("--launch-every = -1: must be 0 or more", NAMED) == (
        "“Interval between launches” = -1 must be 0 or more"
    )
    options = VERBS["windows"].options
    assert in_labels("--mask = 100: must be below 90", options).startswith("“Least elevation”")


def test_empty_fields_say_what_they_mean() -> None:
    """A short meaning stands in the field itself, a long one beside it as well."""
    forms = {form["path"]: form for form in form_fields()}
    assert forms["max_targets"]["absent"] == "no limit"
    assert forms["kits"]["help"] == "the most"
    options = {option.name: option.to_dict() for option in NAMED}
    assert (options["delta_v"]["absent"], options["delta_v"]["help"]) == ("3000", "")
    assert options["station"]["help"].endswith("empty for the densest plane")
