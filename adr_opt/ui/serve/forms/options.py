"""Options of verbs: each by name, of a checked type, as one word of a command line."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from ....common.errors import InputError

Kind = Literal["number", "text", "choice", "flag", "vary"]

LONGEST_TEXT = 200
"""Maximum length of a text [characters]."""

GREATEST = 10**18
"""Largest absolute value of a whole number; larger ones are not exact as floats."""

Value = bool | int | float | str | None

EMPTY = re.compile(r"(?:empty for |empty: |by default )(?P<after>.+)|(?P<before>.+) by default")
ROOM = 16
"""Longest meaning of an empty field that it shows itself [characters]."""


def meaning_of_empty(help: str) -> tuple[str, dict[str, str]]:
    """A description, and what an empty field means, which short words in the field say instead."""
    kept, said = [], {}
    for part in help.split("; "):
        found = EMPTY.fullmatch(part)
        if found:
            said["absent"] = found["after"] or found["before"]
        if not found or len(said["absent"]) > ROOM:
            kept.append(part)
    return "; ".join(kept), said


@dataclass(frozen=True)
class JobOption:
    """An option of a verb.

    Attributes
    ----------
    name : str
        As the page knows it.
    sign : str
        As the command line knows it; empty if a file of the job stands for it.
    label, unit, help : str
    kind : str
    default : bool, int, float, str or None
        With None the option is left out, as with an empty text.
    least, most : float
        Of a number.
    whole : bool
        Whether the number is whole.
    suffix : str
        Put behind a number, such as the unit that the command line asks for.
    longest : int
        Maximum length of a text [characters].
    pattern : str
        That a text matches as a whole.
    choices : callable, optional
        Gives the values of a choice, or the names of what may be varied.
    words : mapping of str to str
        What the page calls some of these.
    """

    name: str
    sign: str
    label: str
    kind: Kind
    unit: str = ""
    default: Value = None
    least: float = -math.inf
    most: float = math.inf
    whole: bool = False
    suffix: str = ""
    longest: int = LONGEST_TEXT
    pattern: str = r"[^\x00-\x1f\x7f]*"
    choices: Callable[[], Sequence[str]] | None = None
    help: str = ""
    words: Mapping[str, str] = field(default_factory=dict)

    def word(self, value: Value) -> str | None:
        """The option with a value as one word of the command line; None to leave it out.

        Raises
        ------
        InputError
            The value is not one of this option.
        """
        if value is None or value == "" or (self.kind == "flag" and value is False):
            return None
        if self.kind == "flag":
            if value is not True:
                raise InputError(f"“{self.label}” must be true or false")
            return self.sign or None
        if self.kind == "number":
            word = f"{self.sign}={self._number(value)}{self.suffix}"
            return word if self.sign else None
        if not isinstance(value, str) or len(value) > self.longest:
            raise InputError(f"“{self.label}” must be a text of at most {self.longest} characters")
        known = self.choices() if self.choices is not None and self.kind == "choice" else None
        if known is not None and value not in known:
            raise InputError(f"“{self.label}” = {value[:40]!r}: must be one of {', '.join(known)}")
        if re.fullmatch(self.pattern, value) is None:
            raise InputError(f"“{self.label}” = {value[:40]!r}: {self.help or 'not a value'}")
        return f"{self.sign}={value}"

    def _number(self, value: Value) -> str:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"“{self.label}” must be a number")
        if isinstance(value, int) and abs(value) > GREATEST:
            raise InputError(f"“{self.label}” must be a number of at most 18 digits")
        if not (math.isfinite(value) and self.least <= value <= self.most):
            raise InputError(f"“{self.label}” = {value:g}: must be {self.least:g} to {self.most:g}")
        if not self.whole:
            return repr(float(value))
        if value != int(value):
            raise InputError(f"“{self.label}” = {value:g}: must be a whole number")
        return str(int(value))

    def to_dict(self) -> dict[str, Any]:
        """The option as JSON data, for a field of a form."""
        help, absent = meaning_of_empty(self.help)
        return {
            "name": self.name,
            "label": self.label,
            "unit": self.unit,
            "kind": self.kind,
            "default": self.default,
            "help": help,
            **absent,
            "words": dict(self.words),
            **({} if self.choices is None else {"choices": list(self.choices())}),
            **({} if math.isinf(self.least) else {"least": self.least}),
            **({} if math.isinf(self.most) else {"most": self.most}),
        }


def number(name: str, label: str, unit: str = "", help: str = "", **more: Any) -> JobOption:
    """An option with a number, whose flag is its name; ``more`` are other fields."""
    return JobOption(name, sign_of(name), label, "number", unit, help=help, **more)


def whole(name: str, label: str, default: int | None, least: float, most: float) -> JobOption:
    """An option with a whole number between two others."""
    return number(name, label, default=default, least=least, most=most, whole=True)


def text(name: str, label: str, unit: str = "", help: str = "", **more: Any) -> JobOption:
    """An option with a text, whose flag is its name."""
    return JobOption(name, sign_of(name), label, "text", unit, help=help, **more)


def flag(name: str, label: str, help: str = "") -> JobOption:
    """An option without a value, not set by default."""
    return JobOption(name, sign_of(name), label, "flag", default=False, help=help)


def choice(
    name: str,
    label: str,
    choices: Sequence[str] | Callable[[], Sequence[str]],
    default: str | None = None,
    help: str = "",
) -> JobOption:
    """An option with one of some values, or of those that a function returns."""
    given = choices if callable(choices) else lambda: choices
    return JobOption(
        name, sign_of(name), label, "choice", default=default, choices=given, help=help
    )


def sign_of(name: str) -> str:
    """An option on the command line by its name on the page."""
    return f"--{name.replace('_', '-')}"


def words_of(options: Sequence[JobOption], given: dict[str, Value]) -> list[str]:
    """All options as words of a command line; options not given have their defaults.

    Raises
    ------
    InputError
        There is no such option, or a value is not one of it.
    """
    strange = sorted(given.keys() - {option.name for option in options})
    if strange:
        raise InputError(f"option {strange[0][:40]!r} is unknown")
    words = [option.word(given.get(option.name, option.default)) for option in options]
    return [word for word in words if word is not None]
