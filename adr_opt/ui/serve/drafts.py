"""Drafts: what is wanted of a field, edit by edit, with what can be undone."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field, ValidationError

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.records import Record
from ...common.sentences import sentence
from ...common.wording import counted
from ...problem.chasers import Chaser, TankByMass
from ...problem.given import among
from ...problem.instance import Instance

MOST_STEPS = 500
"""So many edits can be undone."""


class TargetsEdit(Record):
    """What is changed of some targets; what is null stays."""

    names: Annotated[tuple[str, ...], Field(strict=False, min_length=1)]
    prize: float | None = None
    required: bool | None = None
    excluded: bool | None = None


class BudgetEdit(Record):
    """What a chaser has: ΔV [m/s], or propellant where its tank is counted by mass [kg]."""

    chaser: str
    amount: float


class Edit(Record):
    """One edit, as the page sends it: one of its fields is stated."""

    targets: TargetsEdit | None = None
    duration_s: float | None = None
    budget: BudgetEdit | None = None


def read_edit(text: str) -> Edit:
    """The edit that a JSON text holds.

    Raises
    ------
    InputError
        It holds none, or several.
    """
    try:
        edit = Edit.from_json(text)
    except ValidationError as error:
        raise InputError(sentence(error)) from None
    stated = [name for name in Edit.model_fields if getattr(edit, name) is not None]
    if len(stated) != 1:
        raise InputError(f"an edit changes one of: {', '.join(Edit.model_fields)}")
    return edit


@dataclass(frozen=True)
class Draft:
    """What is wanted of a field.

    Attributes
    ----------
    field : Instance
        All targets, with prizes, what is required, and limits as they are wanted.
    excluded : frozenset of str
        Targets that are left out.
    """

    field: Instance
    excluded: frozenset[str] = frozenset()

    @cached_property
    def instance(self) -> Instance:
        """The instance that is planned: without what is excluded."""
        if not self.excluded:
            return self.field
        kept = tuple(each for each in self.field.targets if each.name not in self.excluded)
        field, given = self.field, self.field.given
        if given is not None:
            left = [name for name in field.names if name not in self.excluded]
            field = field.with_given(among(given, left))
        return field.replace(targets=kept)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the instance that is planned."""
        return self.instance.sha256

    def edited(self, edit: Edit) -> Draft:
        """The draft after an edit.

        Raises
        ------
        InputError
            No such target or chaser, or a value that is not valid.
        """
        if edit.targets is not None:
            return self._with_targets(edit.targets)
        if edit.budget is not None:
            return self._with_budget(edit.budget)
        return replace(self, field=self.field.with_limits(duration_s=edit.duration_s))

    def _with_targets(self, edit: TargetsEdit) -> Draft:
        """What is required is not excluded, and what is excluded not required: the last one said.

        Raises
        ------
        InputError
            Both are asked for at once.
        """
        if edit.required and edit.excluded:
            raise InputError("a target cannot be required and excluded; ask for one of the two")
        wanted = set(edit.names)
        _refuse_strangers(wanted, (target.name for target in self.field.targets), "target")
        changes: dict[str, Any] = {}
        if edit.prize is not None:
            changes["prize"] = edit.prize
        if edit.required is not None or edit.excluded:
            changes["required"] = bool(edit.required)
        excluded = self.excluded
        if edit.excluded or edit.required:
            excluded = excluded | wanted if edit.excluded else excluded - wanted
        elif edit.excluded is False:
            excluded = excluded - wanted
        targets = tuple(
            target.replace(**changes) if changes and target.name in wanted else target
            for target in self.field.targets
        )
        return Draft(self.field.replace(targets=targets), excluded)

    def _with_budget(self, edit: BudgetEdit) -> Draft:
        _refuse_strangers({edit.chaser}, (each.name for each in self.field.chasers), "chaser")
        chasers = tuple(
            _with_amount(chaser, edit.amount) if chaser.name == edit.chaser else chaser
            for chaser in self.field.chasers
        )
        return replace(self, field=self.field.replace(chasers=chasers))


def _refuse_strangers(wanted: Iterable[str], known: Iterable[str], what: str) -> None:
    strange = sorted(set(wanted) - set(known))
    if strange:
        raise InputError(f"{strange[0]!r} is no {what} of this field")


def amount_of(chaser: Chaser) -> float:
    """What a chaser has when its tank is full: propellant [kg], or ΔV [m/s]."""
    tank = chaser.tank
    return tank.propellant_kg if isinstance(tank, TankByMass) else tank.delta_v_m_s


def _with_amount(chaser: Chaser, amount: float) -> Chaser:
    """A chaser whose full tank holds so much; at the start it holds no more than that."""
    field = "propellant_kg" if isinstance(chaser.tank, TankByMass) else "delta_v_m_s"
    changes = {field: amount}
    initial = getattr(chaser.tank, f"initial_{field}")
    if initial is not None:
        changes[f"initial_{field}"] = min(initial, amount)
    return chaser.replace(tank=chaser.tank.replace(**changes))


def told(edit: Edit) -> str:
    """An edit in words, for what can be undone."""
    if edit.duration_s is not None:
        return f"duration {edit.duration_s / DAY_S:.6g} d"
    if edit.budget is not None:
        return f"budget of {edit.budget.chaser} {edit.budget.amount:.6g}"
    assert edit.targets is not None
    names = edit.targets.names
    whose = names[0] if len(names) == 1 else counted(len(names), "target")
    if edit.targets.prize is not None:
        return f"prize of {whose} {edit.targets.prize:.6g}"
    if edit.targets.excluded is not None:
        return f"{whose} {'excluded' if edit.targets.excluded else 'not excluded'}"
    return f"{whose} {'required' if edit.targets.required else 'not required'}"


class History:
    """Drafts one after the other, and which of them is looked at.

    Parameters
    ----------
    first : Draft
    """

    def __init__(self, first: Draft) -> None:
        self._drafts = [first]
        self._words = [""]
        self._at = 0

    @property
    def draft(self) -> Draft:
        """The one that is looked at."""
        return self._drafts[self._at]

    @property
    def undoes(self) -> str | None:
        """What would be undone, in words; None for nothing."""
        return self._words[self._at] if self._at else None

    @property
    def redoes(self) -> str | None:
        """What would be done again, in words; None for nothing."""
        return self._words[self._at + 1] if self._at + 1 < len(self._drafts) else None

    def edit(self, edit: Edit) -> bool:
        """Go on from here; what was undone is forgotten. Whether anything changes.

        Raises
        ------
        InputError
            The edit is not valid; nothing changes.
        """
        made = self.draft.edited(edit)
        if made == self.draft:
            return False
        del self._drafts[self._at + 1 :], self._words[self._at + 1 :]
        self._drafts.append(made)
        self._words.append(told(edit))
        if len(self._drafts) > MOST_STEPS + 1:
            del self._drafts[0], self._words[0]
        self._at = len(self._drafts) - 1
        return True

    def undo(self) -> bool:
        """Go back by an edit; whether there was one."""
        moved = self._at > 0
        self._at -= moved
        return moved

    def redo(self) -> bool:
        """Go forward again; whether something had been undone."""
        moved = self._at + 1 < len(self._drafts)
        self._at += moved
        return moved
