"""The files of a project, ``adr-opt-project/1``, and of its results, ``adr-opt-result/1``."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ....common.files import to_text
from ....common.records import Name, Record

FORMAT: Literal["adr-opt-project/1"] = "adr-opt-project/1"

KEY = "^[0-9a-f]{16}$"
"""Pattern of the names of folders in ``history``."""

Key = Annotated[str, Field(pattern=KEY)]
"""Name of a folder in ``history``: the beginning of the SHA-256 of the instance in it."""

FileName = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]
"""Name of a file in ``files``, without path separators."""

Number = Annotated[int, Field(ge=1, le=999_999)]
"""Number of a result or a job."""

Content = Literal[
    "catalogue",
    "ephemerides",
    "errors",
    "ground stations",
    "instance",
    "plan",
    "prizes",
    "satcat",
    "uncertainty",
]
"""Content of a dropped file."""


class StepRecord(Record):
    """A step of the history.

    Attributes
    ----------
    draft : str or None
        The folder of its instance; None before there is a mission.
    excluded : tuple of str
        Targets that are left out.
    words : str
        The edit that led here.
    base : bool
        Whether the instance came as a whole, and sliders count from it.
    """

    draft: Key | None
    excluded: Annotated[tuple[str, ...], Field(strict=False)] = ()
    words: str = ""
    base: bool = False


class DroppedFile(Record):
    """A file that was dropped.

    Attributes
    ----------
    file : str
        Its name in the folder ``files``.
    name : str
        Its name where it came from, for display alone.
    what : str
    count, skipped : int
        Of the rows in it, those that are good and bad.
    bad : tuple of str
        The first bad rows, with place and reason.
    """

    file: FileName
    name: Name
    what: Content
    count: Annotated[int, Field(ge=0)] = 0
    skipped: Annotated[int, Field(ge=0)] = 0
    bad: Annotated[tuple[str, ...], Field(strict=False)] = ()

    @property
    def number(self) -> int:
        """The number at the beginning of the file's name in the folder."""
        return int(self.file.partition("-")[0])


class ProjectRecord(Record):
    """The file of a project.

    Attributes
    ----------
    steps : tuple of StepRecord
        The history, the earliest first; never empty.
    at : int
        Position of the current step.
    shown : int or None
        Result whose plan is shown.
    files : tuple of DroppedFile
    worth : int or None
        Result that rates the objects of the catalogue.
    """

    format: Literal["adr-opt-project/1"] = FORMAT
    steps: Annotated[tuple[StepRecord, ...], Field(strict=False, min_length=1)]
    at: Annotated[int, Field(ge=0)]
    shown: Number | None = None
    files: Annotated[tuple[DroppedFile, ...], Field(strict=False)] = ()
    worth: Number | None = None

    @model_validator(mode="after")
    def _is_at_a_step(self) -> Self:
        if self.at >= len(self.steps):
            raise ValueError(f"field at = {self.at}: there are {len(self.steps)} steps")
        return self

    def to_json(self) -> str:
        """The file as text."""
        return to_text(self.model_dump(mode="json"))


RESULT_FORMAT: Literal["adr-opt-result/1"] = "adr-opt-result/1"

_KEPT = (
    "bound check compare dispose export fly refine rehearse replan report screen solve tradeoff "
    "verify windows worth"
)
KEPT_VERBS = frozenset(_KEPT.split())
"""Verbs whose results are kept; other folders among the results are not the project's."""


class ResultRecord(Record):
    """The result of a verb, stored as ``result.json`` in its folder.

    Attributes
    ----------
    number : int
    verb : str
    label : str
    made_at : datetime
    inputs : tuple of int
        Results that it was made from.
    command : tuple of str
        The command line, to be given in the project folder; empty for what the page did itself.
    exit_status : int
    said : str
        Messages of the verb.
    instance_sha256, plan_sha256 : str or None
        Of the instance, and of the legs of the plan.
    page : str or None
        Name of its page.
    files : tuple of str
        Names of all files beside this one.
    objective, bound, gap, delta_v_m_s, targets, status
        Figures, as far as there are any.
    visited : tuple of str
        Targets of the plan.
    """

    format: Literal["adr-opt-result/1"] = RESULT_FORMAT
    number: Number
    verb: Name
    label: str
    made_at: datetime
    inputs: Annotated[tuple[Number, ...], Field(strict=False)] = ()
    command: Annotated[tuple[str, ...], Field(strict=False)] = ()
    exit_status: int = 0
    said: str = ""
    instance_sha256: str | None = None
    plan_sha256: str | None = None
    page: FileName | None = None
    files: Annotated[tuple[str, ...], Field(strict=False)] = ()
    objective: float | None = None
    bound: float | None = None
    gap: float | None = None
    delta_v_m_s: float | None = None
    targets: int | None = None
    visited: Annotated[tuple[str, ...], Field(strict=False)] = ()
    status: str | None = None

    @property
    def has_plan(self) -> bool:
        """Whether the result holds a plan with its instance."""
        return "plan.json" in self.files and "instance.json" in self.files

    def to_json(self) -> str:
        """The file as text."""
        return to_text(self.model_dump(mode="json"))

    def row(self) -> dict[str, Any]:
        """The result as the page lists it, as JSON data."""
        content = self.model_dump(mode="json")
        left_out = ("format", "number", "command", "instance_sha256", "plan_sha256", "page")
        row = {name: value for name, value in content.items() if name not in left_out}
        return {
            "id": self.number,
            **row,
            "has_page": self.page is not None,
            "has_plan": self.has_plan,
            "mission": (self.instance_sha256 or "")[:12],
        }
