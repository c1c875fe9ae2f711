"""The card of connections that somebody gives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.card import Card
from ...common.wording import counted

if TYPE_CHECKING:
    from ...problem.given import Given


def of_given(given: Given) -> Card:
    """The card of connections that somebody gives."""
    facts = (
        counted(int(given.departure.size), "connection"),
        counted(len(given.names), "body", "bodies"),
        f"sha256 {given.sha256[:12]}…",
    )  # fmt: skip
    return Card("Given", "", facts)
