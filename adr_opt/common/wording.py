"""Wording of messages: counts with nouns, names made safe to print, and statuses."""

from __future__ import annotations

import re
from collections.abc import Iterable

LONGEST_NAME = 60
"""Length beyond which names, keys and values are cut in error messages [characters]."""

UNSAID = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
"""Characters in names that move the cursor, clear the screen or reverse text direction."""

QUOTED = re.compile(rf"(?<!\w)(['\"])(?:(?!\1).){{{LONGEST_NAME + 1},}}\1(?!\w)")
"""Quoted text of a message that is too long, such as a name from a file."""


def harmless(text: str) -> str:
    """Text without control characters other than newlines and tabs; JSON keeps its meaning."""
    return UNSAID.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def in_one_line(message: str) -> str:
    """A message without anything that breaks or hides its line, and its quoted names cut."""
    text = harmless(message).replace("\n", "\\n").replace("\t", "\\t")
    return QUOTED.sub(lambda found: f"{found[1]}{cut(found[0][1:-1])}{found[1]}", text)


def cut(text: str, most: int = LONGEST_NAME) -> str:
    """The beginning of a text, with an ellipsis if there is more."""
    return text if len(text) <= most else text[: most - 1] + "…"


def printable(text: str) -> str:
    """Text in the form that messages of other programs allow: printable ASCII on one line."""
    return "".join(sign if " " <= sign <= "~" else "?" for sign in text)


def counted(number: int, noun: str, plural: str | None = None) -> str:
    """A number with its noun: "1 leg", "2 legs"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def status_words(status: str) -> str:
    """The status of a plan in words; a proof holds for the model, not for real objects."""
    return "optimal (of the model)" if status == "optimal" else status


def proof_words(status: str, cost_status: str | None) -> str:
    """What is proven of a plan, in words: its prize, and its cost at that prize."""
    if status != "optimal":
        return status
    what = "prize and cost" if cost_status == "optimal" else "prize"
    return f"optimal {what} (of the model)"


def shortened(names: Iterable[str], width: int) -> dict[str, str]:
    """Names of at most ``width`` characters that stay distinguishable.

    Parameters
    ----------
    names : iterable of str
    width : int
        At least 2.

    Returns
    -------
    dict of str to str
        Names that fit are kept. Others lose their middle, as objects of one cloud mostly differ at
        the end: a catalogue number there is kept whole if it fits with a letter before it. Names
        that would then coincide lose their common beginning instead.
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
"""A catalogue number at the end of a name, with a counter if several objects share the name."""


def _without_middle(name: str, width: int) -> str:
    if len(name) <= width:
        return name
    tail = 2 * (width - 1) // 3
    number = CATALOGUE_NUMBER.search(name)
    if number is not None and len(number[0]) <= width - 2:
        tail = max(tail, len(number[0]))
    return f"{name[: width - 1 - tail]}…{name[len(name) - tail :]}"


def _without_beginning(names: list[str], width: int) -> dict[str, str]:
    """Different names with a common beginning, each cut to where the first of them differ."""
    letters = enumerate(zip(*names, strict=False))
    common = next((at for at, each in letters if len(set(each)) > 1), min(map(len, names)))
    by_next: dict[str, list[str]] = {}
    for name in names:
        by_next.setdefault(name[common : common + width - 1], []).append(name)
    found: dict[str, str] = {}
    for part, group in by_next.items():
        found |= {group[0]: f"…{part}"} if len(group) == 1 else _without_beginning(group, width)
    return found
