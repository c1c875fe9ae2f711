"""Requirements on single objects of a catalogue: whether they are targets, and their values."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.wording import counted
from ...problem.bodies import Target
from ...problem.orbit import Orbit
from .crew import Crew
from .criticality import criticality
from .finding import Finder
from .records import Dropped, ElementSet
from .wishes import Wish

TARGET = "one that is a target"


class ObjectChoice(NamedTuple):
    """Objects selected or excluded regardless of filters.

    Attributes
    ----------
    musts : mapping of int to str
        Those that have to be targets: the identity of each record, and what the call names it.
    excluded : mapping of int to str
        Those that must not be targets: the identity of each record, and the option that says so.
    """

    musts: Mapping[int, str] = {}
    excluded: Mapping[int, str] = {}


class TargetDemands(NamedTuple):
    """Requirements on the targets.

    Attributes
    ----------
    fields : mapping of int to mapping
        Fields of targets by their numbers, as the instance has them.
    left_out : int
        Rows of tables about objects of the catalogue that are no targets.
    """

    fields: Mapping[int, Mapping[str, Any]]
    left_out: int


@dataclass(frozen=True)
class Demands:
    """Requirements on single objects, given by number, name or designator.

    Attributes
    ----------
    deadlines_s : mapping of str to float
        When the service of an object has to be over, if it is serviced [s after the epoch].
    required : collection of str
        Objects that a plan has to service; each has to be a target.
    musts, excluded : collection of str
        Objects that become required targets regardless of filters; and objects that are not
        targets. Each may name several, separated by commas.
    wishes : collection of Wish
        Of a table, see :func:`.wishes.read_wishes`.
    only_wished : bool
        Whether objects without a row in a table, and not among the musts, are excluded.
    by_criticality : bool
        Whether prizes are those of :func:`.criticality.criticality`, but where a table says
        others; else all are 1.
    """

    deadlines_s: Mapping[str, float] = field(default_factory=dict)
    required: Collection[str] = ()
    musts: Collection[str] = ()
    excluded: Collection[str] = ()
    wishes: Collection[Wish] = ()
    by_criticality: bool = False
    only_wished: bool = False

    def __post_init__(self) -> None:
        for said, deadline_s in self.deadlines_s.items():
            if not 0.0 < deadline_s < math.inf:
                raise InputError(f"--deadline {said}={deadline_s / DAY_S:g}: must be after day 0")

    def choice(self, records: Sequence[ElementSet], host: ElementSet | None) -> ObjectChoice:
        """Objects of a catalogue that are targets, or excluded, regardless of filters.

        Raises
        ------
        InputError
            An object is not among the records or not the only one of its name; or it is the
            station, or both wanted and not.
        """
        if not (self.musts or self.excluded or self.only_wished):
            return ObjectChoice()
        finder = Finder(records)
        musts = finder.listed(self.musts, "--must")
        excluded = finder.listed(self.excluded, "--exclude")
        for at, said in musts.items():
            if at in excluded:
                raise InputError(f"--must {said}: --exclude leaves it out; remove one of the two")
            if records[at] is host:
                raise InputError(f"--must {said}: it is the station, which cannot be a target")
        left_out = {id(records[at]): "exclude" for at in excluded}
        if self.only_wished:
            rows = {finder.one(wish.said, f"{wish.source}: object") for wish in self.wishes}
            for at in set(range(len(records))) - rows - set(musts):
                left_out.setdefault(id(records[at]), "only-prized")
        return ObjectChoice({id(records[at]): said for at, said in musts.items()}, left_out)

    def of(
        self, targets: Sequence[ElementSet], catalogue: Sequence[ElementSet], musts: ObjectChoice
    ) -> TargetDemands:
        """The requirements on given targets.

        Parameters
        ----------
        targets : sequence of ElementSet
        catalogue : sequence of ElementSet
            All objects: a table may speak of any of them.
        musts : ObjectChoice

        Raises
        ------
        InputError
            An object is not there or not the only one of its name, or one thing is asked of it
            twice; or it is required, but not a target.
        """
        finder = Finder(targets)
        number_of = {id(record): number for number, record in enumerate(targets)}
        fields: dict[int, dict[str, Any]] = {
            number_of[place]: {"required": True} for place in musts.musts if place in number_of
        }
        left_out = self._add_wishes(fields, catalogue, number_of)
        for said, deadline_s in self.deadlines_s.items():
            number = finder.one(said, "--deadline", TARGET)
            its = fields.setdefault(number, {})
            if "window_s" in its:
                raise InputError(f"--deadline {said}: {targets[number].label} already has one")
            its["window_s"] = (0.0, deadline_s)
        for said in self.required:
            fields.setdefault(finder.one(said, "--require", TARGET), {})["required"] = True
        return TargetDemands(fields, left_out)

    def _add_wishes(
        self,
        fields: dict[int, dict[str, Any]],
        catalogue: Sequence[ElementSet],
        number_of: Mapping[int, int],
    ) -> int:
        """Add the rows of tables to fields; returns the number of rows about other objects."""
        if not self.wishes:
            return 0
        finder, rows, left_out = Finder(catalogue), dict[int, Wish](), 0
        for wish in self.wishes:
            at = finder.one(wish.said, f"{wish.source}: object")
            label = catalogue[at].label
            if at in rows:
                raise InputError(
                    f"{wish.source}: {label} already has a row, {rows[at].source}; keep one"
                )
            rows[at] = wish
            number = number_of.get(id(catalogue[at]))
            if number is None:
                if wish.fields.get("required"):
                    raise InputError(
                        f"{wish.source}: {label} is required, but is not a target; widen the "
                        "filters, or name it with --must"
                    )
                left_out += 1
                continue
            its = fields.setdefault(number, {})
            if its.get("required") and wish.fields.get("required") is False:
                raise InputError(f"{wish.source}: {label} is not required, but named by --must")
            its |= wish.fields
        return left_out


def check_musts(
    choice: ObjectChoice,
    targets: Iterable[ElementSet],
    records: Iterable[ElementSet],
    dropped: Iterable[Dropped],
) -> None:
    """Raise :class:`InputError` if an object that must be a target is not."""
    there = {id(record) for record in targets}
    for record in records:
        if id(record) in choice.musts and id(record) not in there:
            why = [drop.detail for drop in dropped if drop.object == record.label][:1]
            raise InputError(
                ": ".join((f"--must {choice.musts[id(record)]}", "it cannot be a target", *why))
            )


def filled(
    demands: TargetDemands,
    targets: Sequence[ElementSet],
    catalogue: Sequence[ElementSet],
    crew: Crew,
    *,
    by_criticality: bool,
) -> dict[int, dict[str, Any]]:
    """Requirements completed by masses and designators of the catalogue, and prizes by criticality.

    What a table asks for goes before either, and the mass that all are towed with before the
    catalogue's.
    """
    fields = {number: dict(its) for number, its in demands.fields.items()}
    for number, record in enumerate(targets):
        if record.mass_kg is not None and crew.towed_kg is None:
            fields.setdefault(number, {}).setdefault("mass_kg", record.mass_kg)
        if record.designator is not None:
            fields.setdefault(number, {})["object_id"] = record.designator
    if by_criticality:
        known = {number: its["mass_kg"] for number, its in fields.items() if "mass_kg" in its}
        for number, prize in enumerate(criticality(targets, catalogue, known)):
            fields.setdefault(number, {}).setdefault("prize", float(prize))
    return fields


def told_masses(targets: Sequence[ElementSet], fields: Mapping[int, Mapping[str, Any]]) -> str:
    """A sentence on the basis of prizes by criticality."""
    known = [number for number, its in fields.items() if "mass_kg" in its]
    by_size = sum(bool(record.size) for number, record in enumerate(targets) if number not in known)
    return (
        "prizes are by criticality, a ranking, not a probability: mass (known of "
        f"{len(known)} of {len(targets)} targets, guessed from the size of {by_size}), altitude, "
        "and crowding among the objects read"
    )


def told_left_out(count: int) -> str:
    """A warning about table rows for objects that are not targets."""
    return f"{counted(count, 'row')} of --prizes: their objects are not among the targets"


def targets_of(
    names: Sequence[str],
    orbits: Iterable[Orbit],
    crew: Crew,
    fields: Mapping[int, Mapping[str, Any]],
) -> tuple[Target, ...]:
    """The targets with their names, orbits and requirements."""
    return tuple(
        Target(
            **{
                "name": name,
                "orbit": orbit,
                "removal": crew.removal,
                "mass_kg": crew.towed_kg,
                **fields.get(number, {}),
            }
        )
        for number, (name, orbit) in enumerate(zip(names, orbits, strict=True))
    )
