"""Words for people: counts with their nouns, names cut to fit, and what a status is said of."""

from __future__ import annotations

import re
from collections.abc import Iterable


def counted(number: int, noun: str, plural: str | None = None) -> str:
    """A number with its noun: "1 leg", "2 legs"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def status_words(status: str) -> str:
    """The status of a plan; a proof is one of the model, not of the motion of real objects."""
    return "optimal (of the model)" if status == "optimal" else status


def shortened(names: Iterable[str], width: int) -> dict[str, str]:
    """Names of at most ``width`` characters that can still be told apart.

    Parameters
    ----------
    names : iterable of str
    width : int
        At least 2.

    Returns
    -------
    dict of str to str
        Names that fit stay. Of the others the middle goes, and what tells objects of a cloud apart
        mostly stands at the end: a catalogue number there stays whole, if there is room for it and
        a letter before it. Where names would then be the same, what they begin with in common goes
        instead.
    """
    short = {name: _without_middle(name, width) for name in dict.fromkeys(names)}
    alike: dict[str, list[str]] = {}
    for name, text in short.items():
        alike.setdefault(text, []).append(name)
    for group in alike.values():
        if len(group) > 1:
            short |= _without_beginning(group, width)
    return short


CATALOGUE_NUMBER = re.compile(r"\d{4,9}(?: \(\d+\))?$")
"""At the end of a name, with the count of those that have the same."""


def _without_middle(name: str, width: int) -> str:
    if len(name) <= width:
        return name
    tail = 2 * (width - 1) // 3
    number = CATALOGUE_NUMBER.search(name)
    if number is not None and len(number[0]) <= width - 2:
        tail = max(tail, len(number[0]))
    return f"{name[: width - 1 - tail]}…{name[len(name) - tail :]}"


def _without_beginning(names: list[str], width: int) -> dict[str, str]:
    """Different names that begin alike, from the character on in which the first of them differ."""
    letters = enumerate(zip(*names, strict=False))
    common = next((at for at, each in letters if len(set(each)) > 1), min(map(len, names)))
    by_next: dict[str, list[str]] = {}
    for name in names:
        by_next.setdefault(name[common : common + width - 1], []).append(name)
    found: dict[str, str] = {}
    for part, group in by_next.items():
        found |= {group[0]: f"…{part}"} if len(group) == 1 else _without_beginning(group, width)
    return found
