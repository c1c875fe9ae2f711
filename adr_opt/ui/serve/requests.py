"""Content of the requests that the page sends, as strict records."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, ValidationError

from ...common.errors import InputError
from ...common.records import Record
from ...common.sentences import sentence
from .project.record import Number

MOST_CHOSEN = 2000
"""Maximum number of objects that become targets at once."""


class ChooseRequest(Record):
    """Objects of the dropped catalogue that become the targets of a mission, and its options."""

    names: Annotated[tuple[str, ...], Field(strict=False, min_length=1, max_length=MOST_CHOSEN)]
    prizes: Literal["one", "worth", "criticality"] = "one"
    options: Annotated[dict[str, Any], Field(default_factory=dict, max_length=50)]


class JobRequest(Record):
    """A verb to run, with its options by name and the results that it reads."""

    verb: str
    options: Annotated[dict[str, Any], Field(default_factory=dict, max_length=50)]
    results: Annotated[tuple[Number, ...], Field(strict=False, max_length=50)] = ()


class StopRequest(Record):
    """The job to stop, by its number."""

    job: Number


class RemoveRequest(Record):
    """The dropped file to remove, by its number."""

    file: Number


class ShowRequest(Record):
    """The result to show, by its number; of a trade-off, the point whose plan is shown."""

    result: Number
    point: Number | None = None


Asked = TypeVar("Asked", bound=Record)


def read_request(kind: type[Asked], text: str) -> Asked:
    """A request from JSON text.

    Raises
    ------
    InputError
        It is not one.
    """
    try:
        return kind.from_json(text)
    except ValidationError as error:
        raise InputError(sentence(error)) from None
