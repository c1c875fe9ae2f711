"""Words for people: counts with their nouns, names cut to fit, and what a status is said of."""

from __future__ import annotations

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
        mostly stands at the end. Where names would then be the same, what they begin with in common
        goes instead.
    """
    tail = 2 * (width - 1) // 3
    head = width - 1 - tail
    wanted = dict.fromkeys(names)
    short = {
        name: name if len(name) <= width else f"{name[:head]}…{name[len(name) - tail :]}"
        for name in wanted
    }
    alike: dict[str, list[str]] = {}
    for name, text in short.items():
        alike.setdefault(text, []).append(name)
    for group in alike.values():
        if len(group) > 1:
            short |= _without_beginning(group, width)
    return short


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
