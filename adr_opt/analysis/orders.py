"""Orders of bodies as text: names or catalogue numbers, for one chaser or several."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

from ..common.errors import InputError
from ..common.files import parse_model, read_text
from ..plan.plan import Plan
from ..plan.routes import routes_of
from ..problem.instance import Instance

Orders = Mapping[str, tuple[str, ...]]
"""Names of bodies in order, by name of the chaser."""


class BodyNames:
    """Finds the bodies of an instance by name or by the catalogue number in it.

    Parameters
    ----------
    instance : Instance
    """

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        self._names = set(instance.names)
        self._by_number: dict[str, list[str]] = {}
        for name in instance.names:
            number = name.rpartition(" ")[2]
            if number.isdigit() and number != name:
                self._by_number.setdefault(number, []).append(name)

    def one(self, said: str, where: str = "") -> str:
        """The name of the body that a text denotes.

        Raises
        ------
        InputError
            There is none, or more than one.
        """
        if said in self._names:
            return said
        found = self._by_number.get(said, [])
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(f"{where}{said!r} is the number of {len(found)} bodies; give a name")
        raise InputError(
            f"{where}{said!r} is not a body of {self._instance.name!r}; give a name or a "
            "catalogue number"
        )


def orders_of(
    instance: Instance, words: Iterable[str], where: str = ""
) -> dict[str, tuple[str, ...]]:
    """Orders given as words: names of bodies, with several chasers after ``CHASER:``.

    Parameters
    ----------
    instance : Instance
    words : iterable of str
        Each the name or the catalogue number of a body. ``chaser-2:`` says that those that follow
        are for the chaser of that name, and ``chaser-2:NAME`` that NAME is the first of them.
    where : str
        Where the words are from, for sentences.

    Raises
    ------
    InputError
        A word is no body, a chaser has two orders, or there are several and none is named.
    """
    known, chasers = BodyNames(instance), {chaser.name for chaser in instance.chasers}
    found: dict[str, list[str]] = {}
    chaser = instance.chasers[0].name if len(instance.chasers) == 1 else None
    for word in words:
        said, sign, rest = word.partition(":")
        if sign and said in chasers and word not in instance.names:
            if said in found:
                raise InputError(f"{where}{said!r} already has an order; give only one")
            chaser, word = said, rest.strip()
            found[said] = []
            if not word:
                continue
        if chaser is None:
            listed = ", ".join(sorted(chasers))
            raise InputError(
                f"{where}there are several chasers; begin with one and a colon: {listed}"
            )
        found.setdefault(chaser, []).append(known.one(word, where))
    return {name: tuple(order) for name, order in found.items()}


def read_orders(instance: Instance, path: str | os.PathLike[str]) -> dict[str, tuple[str, ...]]:
    """Orders from a file: a plan, or text with one body per line.

    Of several chasers a line ``CHASER:`` begins the order of each. What follows ``#`` is no part of
    the order, nor are empty lines.

    Raises
    ------
    InputError
        The file cannot be read, or as for :func:`orders_of`; the sentence says the line.
    """
    text, known = read_text(path), BodyNames(instance)
    if text.lstrip().startswith("{"):
        plan = parse_model(text, Plan, str(path))
        return {
            flown.chaser.name: tuple(
                known.one(name, f"{path}: {flown.chaser.name}: ") for name, _ in flown.spent
            )
            for flown in routes_of(instance, plan)
        }
    words, chasers = [], {chaser.name for chaser in instance.chasers}
    for number, line in enumerate(text.splitlines(), start=1):
        word = line.partition("#")[0].strip()
        if not word:
            continue
        said, sign, rest = word.partition(":")
        if not (sign and said in chasers):
            known.one(word, f"{path}: line {number}: ")
        elif rest.strip():
            known.one(rest.strip(), f"{path}: line {number}: ")
        words.append(word)
    return orders_of(instance, words, f"{path}: ")
