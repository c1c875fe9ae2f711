"""The report of the plan that is shown, made once."""

from __future__ import annotations

from ..report import page
from .session import EditingSession


class ShownReport:
    """Report of the plan that a session shows.

    Parameters
    ----------
    session : EditingSession
    """

    def __init__(self, session: EditingSession) -> None:
        self._session = session
        self._made: tuple[int, str] | None = None

    def text(self) -> str | None:
        """The page; None without a plan.

        Raises
        ------
        InputError
            There can be none, as where plotly is not installed.
        """
        shown = self._session.shown()
        if shown is None:
            return None
        number, instance, plan = shown
        made = self._made
        if made is None or made[0] != number:
            made = self._made = number, page(instance, plan)
        return made[1]
