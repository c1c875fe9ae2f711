"""Drafts: the edits of a field, with undo."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.records import Record
from ...common.sentences import sentence
from ...common.wording import counted
from ...problem.bodies import Removal
from ...problem.chasers import Chaser, TankByMass
from ...problem.given import among
from ...problem.instance import Instance

Dynamics = Literal["two-body", "j2"]
"""Dynamics of bodies."""

Part = Literal["chasers", "stations", "mission", "transfer", "objective", "keep_out_zones"]
"""Parts of an instance that forms edit."""


class TargetsEdit(Record):
    """Changes to some targets; null leaves a field unchanged, but removes a mass."""

    names: Annotated[tuple[str, ...], Field(strict=False, min_length=1)]
    prize: float | None = None
    required: bool | None = None
    excluded: bool | None = None
    window_s: Annotated[tuple[float, float | None], Field(strict=False)] | None = None
    removal: Removal | None = None
    mass_kg: float | None = None


class BudgetEdit(Record):
    """Content of a chaser's tank: ΔV [m/s], or propellant [kg] for a tank by mass."""

    chaser: str
    amount: float


class PartEdit(Record):
    """A new version of a part of the instance, as in its file."""

    path: Part
    value: dict[str, Any] | list[dict[str, Any]]


class Edit(Record):
    """One edit, as sent by the page, with exactly one field."""

    targets: TargetsEdit | None = None
    duration_s: float | None = None
    budget: BudgetEdit | None = None
    part: PartEdit | None = None
    dynamics: Dynamics | None = None


def read_edit(text: str) -> Edit:
    """The edit in a JSON text.

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
    """The edited state of a field.

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
        """The instance to plan, without excluded targets."""
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
        """SHA-256 of the instance to plan."""
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
        if edit.part is not None:
            return self._with(edit.part.path, edit.part.value)
        if edit.dynamics is not None:
            return self._with("dynamics", edit.dynamics)
        return replace(self, field=self.field.with_limits(duration_s=edit.duration_s))

    def _with_targets(self, edit: TargetsEdit) -> Draft:
        """Keep required and excluded targets disjoint; the latest edit wins.

        Raises
        ------
        InputError
            Both are asked for at once.
        """
        if edit.required and edit.excluded:
            raise InputError("a target cannot be both required and excluded; choose one of the two")
        wanted = set(edit.names)
        _refuse_strangers(wanted, (target.name for target in self.field.targets), "target")
        changes: dict[str, Any] = {}
        if edit.prize is not None:
            changes |= {"prize": edit.prize, "prize_until": None}
        if edit.required is not None or edit.excluded:
            changes["required"] = bool(edit.required)
        for name in ("window_s", "removal"):
            if getattr(edit, name) is not None:
                changes[name] = getattr(edit, name)
        if "mass_kg" in edit.model_fields_set:
            changes["mass_kg"] = edit.mass_kg
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

    def _with(self, path: str, value: Any) -> Draft:
        """Read a part within the whole file, so that errors name its fields as for a file."""
        content = self.field.model_dump(mode="json") | {path: value}
        try:
            made = Instance.from_json(json.dumps(content))
        except ValidationError as error:
            raise InputError(sentence(error)) from None
        return replace(self, field=self.field.replace(**{path: getattr(made, path)}))


def _refuse_strangers(wanted: Iterable[str], known: Iterable[str], what: str) -> None:
    strange = sorted(set(wanted) - set(known))
    if strange:
        raise InputError(f"{strange[0]!r} is not a {what} of this field")


def amount_of(chaser: Chaser) -> float:
    """Content of a chaser's full tank: propellant [kg], or ΔV [m/s]."""
    tank = chaser.tank
    return tank.propellant_kg if isinstance(tank, TankByMass) else tank.delta_v_m_s


def unit_of(chaser: Chaser) -> str:
    """Unit of :func:`amount_of`."""
    return "kg" if isinstance(chaser.tank, TankByMass) else "m/s"


def _with_amount(chaser: Chaser, amount: float) -> Chaser:
    """A chaser with a full tank of this content, which also limits it at the start."""
    field = "propellant_kg" if isinstance(chaser.tank, TankByMass) else "delta_v_m_s"
    changes = {field: amount}
    initial = getattr(chaser.tank, f"initial_{field}")
    if initial is not None:
        changes[f"initial_{field}"] = min(initial, amount)
    return chaser.replace(tank=chaser.tank.replace(**changes))


def told(edit: Edit) -> str:
    """An edit in words, for the undo list."""
    if edit.duration_s is not None:
        return f"duration {edit.duration_s / DAY_S:.6g} d"
    if edit.budget is not None:
        return f"budget of {edit.budget.chaser} {edit.budget.amount:.6g}"
    if edit.part is not None:
        return f"{edit.part.path.replace('keep_out_', 'keep-out ')} changed"
    if edit.dynamics is not None:
        return f"dynamics {edit.dynamics}"
    assert edit.targets is not None
    names = edit.targets.names
    whose = names[0] if len(names) == 1 else counted(len(names), "target")
    if edit.targets.prize is not None:
        return f"prize of {whose} {edit.targets.prize:.6g}"
    if edit.targets.window_s is not None:
        return f"window of {whose}"
    if edit.targets.removal is not None:
        return f"service of {whose}: {edit.targets.removal}"
    if edit.targets.mass_kg is not None:
        return f"mass of {whose} {edit.targets.mass_kg:.6g} kg"
    if "mass_kg" in edit.targets.model_fields_set:
        return f"no mass of {whose}"
    if edit.targets.excluded is not None:
        return f"{whose} {'excluded' if edit.targets.excluded else 'not excluded'}"
    return f"{whose} {'required' if edit.targets.required else 'not required'}"
