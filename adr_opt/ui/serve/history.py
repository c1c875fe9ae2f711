"""The history of drafts: undo and redo, in this call and in later ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ...common.errors import InputError
from ...problem.instance import Instance
from .drafts import Draft, Edit, told
from .project.record import StepRecord

MOST_STEPS = 500
"""Maximum number of edits that can be undone."""


class Step:
    """A step of the history.

    Parameters
    ----------
    draft : Draft or None
        None before there is a mission, or if it is yet to be read.
    words : str
        The edit that led here.
    base : bool
        Whether the instance came as a whole, and sliders count from it.
    record : StepRecord, optional
        The step as the project file has it; None until it is kept.
    load : callable, optional
        Reads the draft when it is asked for.
    """

    def __init__(
        self,
        draft: Draft | None,
        words: str = "",
        *,
        base: bool = False,
        record: StepRecord | None = None,
        load: Callable[[], Draft] | None = None,
    ) -> None:
        self._draft, self._load = draft, load
        self.words, self.base, self.record = words, base, record

    @property
    def draft(self) -> Draft | None:
        """The draft; None before there is a mission."""
        if self._load is not None:
            self._draft, self._load = self._load(), None
        return self._draft


class History:
    """A sequence of drafts, and the current one.

    Parameters
    ----------
    first : Draft or None
        None where there is no mission yet.
    """

    def __init__(self, first: Draft | None) -> None:
        self._steps = [Step(first, base=True)]
        self._at = 0

    @classmethod
    def of(cls, steps: Sequence[Step], at: int) -> History:
        """A history restored from its steps."""
        made = cls(None)
        made._steps, made._at = list(steps), at
        return made

    @property
    def steps(self) -> Sequence[Step]:
        """All steps, the earliest first."""
        return self._steps

    @property
    def at(self) -> int:
        """Position of the current step."""
        return self._at

    @property
    def has_mission(self) -> bool:
        """Whether the current step has a draft."""
        return self._steps[self._at].draft is not None

    @property
    def draft(self) -> Draft:
        """The current draft.

        Raises
        ------
        InputError
            There is no mission yet.
        """
        draft = self._steps[self._at].draft
        if draft is None:
            raise InputError("there is no mission yet; choose targets, or drop an instance")
        return draft

    @property
    def base(self) -> Draft:
        """The latest draft that was loaded as a whole."""
        return next(
            (
                step.draft
                for step in reversed(self._steps[: self._at + 1])
                if step.base and step.draft is not None
            ),
            self.draft,
        )

    @property
    def undoes(self) -> str | None:
        """The edit that undo would revert, in words; None if there is none."""
        return self._steps[self._at].words if self._at else None

    @property
    def redoes(self) -> str | None:
        """The edit that redo would repeat, in words; None if there is none."""
        return self._steps[self._at + 1].words if self._at + 1 < len(self._steps) else None

    def edit(self, edit: Edit) -> bool:
        """Apply an edit, discarding undone ones; returns whether anything changed.

        Raises
        ------
        InputError
            The edit is not valid; nothing changes.
        """
        made = self.draft.edited(edit)
        return made != self.draft and self._go_on(made, told(edit), base=False)

    def begin_anew(self, draft: Draft, words: str) -> bool:
        """Continue with another instance; returns whether it differs."""
        known = self._steps[self._at].draft
        alike = known is not None and known.excluded == draft.excluded
        if alike and known is not None and known.field.sha256 == draft.field.sha256:
            return False
        return self._go_on(draft, words, base=True)

    def go_on(self, field: Instance, words: str) -> bool:
        """Continue with another version of the mission; returns whether it differs."""
        made = replace(self.draft, field=field)
        return made != self.draft and self._go_on(made, words, base=False)

    def _go_on(self, draft: Draft, words: str, *, base: bool) -> bool:
        del self._steps[self._at + 1 :]
        self._steps.append(Step(draft, words, base=base))
        if len(self._steps) > MOST_STEPS + 1:
            self.drop_first()
        self._at = len(self._steps) - 1
        return True

    def drop_first(self) -> None:
        """Forget the earliest step; sliders then count from the one after it."""
        del self._steps[0]
        self._at = max(self._at - 1, 0)
        self._steps[0].base = True

    def undo(self) -> bool:
        """Undo an edit; returns whether there was one."""
        return self._move(-1)

    def redo(self) -> bool:
        """Redo an edit; returns whether there was one."""
        return self._move(1)

    def _move(self, by: int) -> bool:
        to = self._at + by
        if not 0 <= to < len(self._steps):
            return False
        _ = self._steps[to].draft  # which may have to be read, and be spoilt
        self._at = to
        return True
