"""What an editing session stores in its project folder."""

from __future__ import annotations

from .folder import Folder
from .history import History
from .kept_history import to_record
from .project.record import DroppedFile, ProjectRecord
from .shown_plan import ShownPlan


class ProjectKeeper:
    """Stores the file of the project, and the draft and the plan at hand.

    Parameters
    ----------
    folder : Folder
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self._at_hand: int | None = None

    def keep(
        self, history: History, shown: ShownPlan, files: tuple[DroppedFile, ...], worth: int | None
    ) -> None:
        """Store a state.

        Parameters
        ----------
        history : History
        shown : ShownPlan
        files : tuple of DroppedFile
        worth : int or None
            Result that rates the objects of the catalogue.

        Raises
        ------
        InputError, OSError
            It cannot be stored.
        """
        folder = self._folder
        draft = history.draft if history.has_mission else None
        steps = to_record(history, folder.drafts)
        folder.keep(
            ProjectRecord(steps=steps, at=history.at, shown=shown.result, files=files, worth=worth)
        )
        known = shown.known()
        if known is not None and known[0] != self._at_hand:
            folder.keep_plan(*known[1:])
            self._at_hand = known[0]
        if draft is None:
            folder.keep_draft(None, planned=False)
        else:
            planned = known is not None and known[2].instance.sha256 == draft.sha256
            folder.keep_draft(draft.instance, planned=planned)
