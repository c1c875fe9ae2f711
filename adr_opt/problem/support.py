"""Refusal of instances that set rules or fields which their reader does not follow.

Closed by default: a follower names its rules beside its own function (:class:`.rules.Follower`;
methods in their :class:`~adr_opt.run.method_spec.MethodSpec`). A rule that it does not name, and a
field that the table (:mod:`.rules`) does not know, is refused wherever it is set in the file.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import lru_cache
from operator import attrgetter
from typing import Any, get_args

from ..common.errors import InputError
from ..common.records import Record
from .instance import AnyInstance, Instance, instance_of
from .rules import CHANCES, FACTS, RULES, Follower

KNOWN = FACTS.union(*(rule.fields for rule in RULES.values()))
"""Fields of known meaning, as paths."""


def binding(instance: Instance, words: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Those of some rules that bind an instance, with the place where they do, if known."""
    for word in words:
        binds = RULES[word].binds(instance)
        if binds:
            yield word, binds if isinstance(binds, str) else ""


def unknown_fields(record: Record, known: Collection[str] = KNOWN) -> Iterator[str]:
    """Fields that are set and that a table does not know, as paths; at every depth of a record."""
    for path, kind, records in _by_path([record], ""):
        for name, about in kind.model_fields.items():
            if path + name not in known:
                usual = about.get_default(call_default_factory=True)
                if any(getattr(each, name) != usual for each in records):
                    yield path + name


def follows_all(instance: Instance, follows: Collection[str]) -> bool:
    """Whether a set of followed rules covers all that an instance sets."""
    words = RULES.keys() - follows
    return not any(binding(instance, words)) and not any(unknown_fields(instance))


def refuse(instance: Instance, follower: Follower, able: Iterable[str] = ()) -> None:
    """Refuse an instance that sets what a follower does not follow.

    Parameters
    ----------
    instance : Instance
    follower : Follower
    able : iterable of str
        Readers that follow all of the instance, named in the sentence.

    Raises
    ------
    InputError
    """
    for path in unknown_fields(instance):
        raise InputError(
            f"{follower.name} does not know the field {path}, which {instance.name!r} sets, nor "
            "does any method; leave it out, or use a version that knows it"
        )
    for word, where in binding(instance, (word for word in RULES if word not in follower.follows)):
        rule, others = RULES[word], list(able)
        instead = f"use {'one of: ' * (len(others) > 1)}{', '.join(others)}, or " if others else ""
        raise InputError(
            f"{follower.name} does not follow {word} (field {rule.fields[0]}"
            f"{f': {where}' if where else ''}), which {instance.name!r} has; "
            f"{instead}{follower.instead or rule.cure}"
        )


def refuse_unknown(uncertainty: Record) -> None:
    """Refuse an uncertainty that sets a field of unknown meaning.

    Raises
    ------
    InputError
    """
    for path in unknown_fields(uncertainty, CHANCES):
        raise InputError(
            f"uncertainty: the field {path} is set but unknown to every method; leave it out, or "
            "use a version that knows it"
        )


def followed(given: AnyInstance, follower: Follower) -> Instance:
    """The instance that a caller passes, as an object, a path or a file's content.

    Raises
    ------
    InputError
        It is none of these, or sets what the follower does not follow.
    """
    instance = instance_of(given)
    refuse(instance, follower)
    return instance


def _by_path(
    records: Sequence[Record], path: str
) -> Iterator[tuple[str, type[Record], Sequence[Record]]]:
    """All records within some, those of one path and one class together."""
    kinds: dict[type[Record], None] = dict.fromkeys(map(type, records))
    for kind in kinds:
        alike = [each for each in records if type(each) is kind]
        yield path, kind, alike
        for name in _holders(kind):
            values = list(map(attrgetter(name), alike))
            inner = [each for each in values if isinstance(each, Record)]
            listed = [
                each
                for value in values
                if isinstance(value, (tuple, dict))
                for each in (value.values() if isinstance(value, dict) else value)
                if isinstance(each, Record)
            ]
            if inner:
                yield from _by_path(inner, f"{path}{name}.")
            if listed:
                yield from _by_path(listed, f"{path}{name}[].")


@lru_cache
def _holders(kind: type[Record]) -> tuple[str, ...]:
    """Fields of a record that hold others."""
    return tuple(
        name for name, about in kind.model_fields.items() if _holds_records(about.annotation)
    )


def _holds_records(annotation: Any) -> bool:
    if isinstance(annotation, type) and issubclass(annotation, Record):
        return True
    return any(map(_holds_records, get_args(annotation)))
