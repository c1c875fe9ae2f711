"""The record of a result: what was done, from what, and what came of it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field

from ....common.files import to_text
from ....common.records import Name, Record
from .record import FileName, Number

FORMAT: Literal["adr-opt-result/1"] = "adr-opt-result/1"

KEPT_VERBS = frozenset(
    {
        "bound",
        "check",
        "compare",
        "fly",
        "refine",
        "rehearse",
        "replan",
        "report",
        "solve",
        "tradeoff",
        "verify",
        "worth",
    }
)
"""Verbs whose results are kept; any other folder among the results is not the project's."""


class ResultRecord(Record):
    """What a verb has made, as the file ``result.json`` of its folder says.

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
    """

    format: Literal["adr-opt-result/1"] = FORMAT
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
    status: str | None = None

    @property
    def has_plan(self) -> bool:
        """Whether it holds a plan with its instance."""
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
        }


def json_schema() -> dict[str, Any]:
    """The JSON Schema of the record of a result."""
    schema = ResultRecord.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
