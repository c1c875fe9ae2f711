"""What an editing session stores in its project folder."""

from __future__ import annotations

from collections.abc import Callable

from .drafts import Draft
from .folder import Folder
from .history import History, Step
from .project.drafts_kept import DraftsKept
from .project.record import DroppedFile, ProjectRecord, StepRecord
from .shown_plan import ShownPlan

MOST_BYTES = 2**28
"""Maximum size of all instances of a history; beyond it the earliest are forgotten [bytes]."""


def restored(record: ProjectRecord, kept: DraftsKept) -> History:
    """The history of a project; drafts are read when they are asked for."""

    def loading(key: str, excluded: frozenset[str]) -> Callable[[], Draft]:
        return lambda: Draft(kept.load(key), excluded)

    steps = [
        Step(
            None,
            step.words,
            base=step.base,
            record=step,
            load=None if step.draft is None else loading(step.draft, frozenset(step.excluded)),
        )
        for step in record.steps
    ]
    return History.of(steps, record.at)


def to_record(history: History, kept: DraftsKept) -> tuple[StepRecord, ...]:
    """The steps for the file of the project; their instances are kept by then.

    Parameters
    ----------
    history : History
        Forgets its earliest steps where all are too large.
    kept : DraftsKept
    """
    before: str | None = None
    changed = False
    for step in history.steps:
        record = step.record
        if record is None:
            draft = step.draft
            key = None if draft is None else kept.keep(draft.field, before)
            excluded = () if draft is None else tuple(sorted(draft.excluded))
            record = StepRecord(draft=key, excluded=excluded, words=step.words, base=step.base)
            changed = True
        elif record.base != step.base:
            record = record.replace(base=step.base)
        step.record, before = record, record.draft
    if changed:
        _shorten(history, kept)
    return tuple(step.record for step in history.steps if step.record is not None)


def forget_unused(history: History, kept: DraftsKept) -> None:
    """Remove the instances that no step has; none may be in work."""
    kept.forget({str(step.record.draft) for step in history.steps if step.record is not None})


def _shorten(history: History, kept: DraftsKept) -> None:
    """Forget the earliest steps where all instances together are too large."""

    def sizes() -> dict[str, int]:
        keys = {step.record.draft for step in history.steps if step.record is not None}
        return {key: kept.size(key) for key in keys if key is not None}

    while history.at > 1 and sum(sizes().values()) > MOST_BYTES:
        history.drop_first()


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
