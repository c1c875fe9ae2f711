"""Problems of variants of an instance, on an existing timetable.

The cost of a transfer does not depend on prizes, on requirements or on other bodies; and, where
connections are not listed for a tank (``ConnectionFinder.depends_on_tank``),
not on tanks. So a change of those needs no other timetable: that of fewer
targets is a part of that of more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..common.records import Record
from ..legs.connection_finder import ConnectionFinder
from ..mission.mission import Mission
from ..mission.problem import Problem, problem_of
from ..problem.instance import Instance


def serves(known: Instance, wanted: Instance) -> bool:
    """Whether the timetable of one instance contains that of another.

    It does where that one has other prizes, other required targets, fewer targets, and, where
    connections do not depend on them, other tanks; and where nothing else makes a difference.
    """
    same = known.mission == wanted.mission
    chosen_alike = known.time_value_m_s_per_h == wanted.time_value_m_s_per_h
    return same and chosen_alike and _alike(known, wanted)


def _alike(known: Instance, wanted: Instance) -> bool:
    """Whether connections are equal up to the end of the shorter mission."""
    fields = set(Instance.model_fields) - {"name", "targets", "chasers", "mission"}
    if any(getattr(known, name) != getattr(wanted, name) for name in fields):
        return False
    listed = ConnectionFinder(known).depends_on_tank or bool(known.spent_m_s or wanted.spent_m_s)
    changed = () if listed else ("tank",)
    if _but_for(known.chasers, *changed) != _but_for(wanted.chasers, *changed):
        return False
    there = iter(_but_for(known.targets, "prize", "required"))
    return all(
        any(target == each for each in there)  # which goes on from the one found before
        for target in _but_for(wanted.targets, "prize", "required")
    )


def _but_for(records: Sequence[Record], *fields: str) -> list[tuple[Any, ...]]:
    """Contents of records, some fields excluded."""
    return [
        tuple(getattr(each, name) for name in type(each).model_fields if name not in fields)
        for each in records
    ]


class Reused:
    """Problems of one instance after another, each reusing earlier timetables.

    The timetable that was built last is kept: fields of fewer targets are a part of it, and those
    of more are built anew. Where connections are listed, those of the longest mission are kept
    besides, for all that are shorter.
    """

    def __init__(self) -> None:
        self._built: Problem | None = None
        self._longest: Problem | None = None

    def problem(self, instance: Instance) -> Problem:
        """The problem of an instance, with an earlier timetable if one fits."""
        for known in (self._built, self._longest):
            whole = known is not None and known.has_timetable and known.is_whole
            if known is not None and whole and serves(known.instance, instance):
                return _on_what_is_there(known, instance)
        longest = self._longest
        if longest is not None and longest.connecting.is_listed and _is_part(longest, instance):
            self._built = Problem(instance, connecting=longest.connecting.shortened(instance))
        else:
            self._built = self._longest = problem_of(instance)
        return self._built


def _is_part(known: Problem, wanted: Instance) -> bool:
    """Whether all connections of a mission are among those of another."""
    before, after = known.instance.mission, wanted.mission
    shorter = after.duration_s <= before.duration_s
    same = before.replace(duration_s=after.duration_s) == after
    return shorter and same and _alike(known.instance, wanted)


def _on_what_is_there(known: Problem, instance: Instance) -> Problem:
    """A problem on the timetable of another instance that has at least the same targets."""
    connecting = known.connecting.shortened(instance)
    timetables = [mission.timetable.of_variant(instance, connecting) for mission in known.missions]
    # Other choices of connections are shared, too, as far as they are of the same bodies.
    if len(known.missions) == 1 and known.names == instance.names:
        return Problem.of(Mission(instance, timetables[0], twin=known.missions[0]))
    return Problem(instance, timetables=timetables)
