"""Options of a method: a frozen dataclass that errors, command line and pages are made from.

For example ::

    @dataclass(frozen=True)
    class BeamOptions(Options, method="beam"):
        width: int = option(2000, "Partial plans kept on each level.", least=1, most=1_000_000)

An instance is valid, since ``BeamOptions(width=0)`` raises :class:`InputError`, and its values have
the types of the defaults.
"""

from __future__ import annotations

import math
import operator
import os
import sys
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from numbers import Real
from typing import Any, ClassVar, NamedTuple, TypeVar

from .errors import InputError

MOST_JOBS = 1024
"""Maximum number of threads of a method."""

LARGEST_WHOLE = 10**9
"""Largest value of an integer option, unless the option says otherwise."""

Value = TypeVar("Value")


class OptionRule(NamedTuple):
    """Meaning and allowed values of an option; see :func:`option`."""

    doc: str = ""
    unit: str = ""
    least: float | str | None = None
    above: float | None = None
    most: float | str | None = None
    choices: tuple[str, ...] = ()
    unset: str = ""


def option(
    default: Value,
    doc: str,
    *,
    unit: str = "",
    least: float | str | None = None,
    above: float | None = None,
    most: float | str | None = None,
    choices: tuple[str, ...] = (),
    unset: str = "",
) -> Value:
    """Declare an option as a field of a subclass of :class:`Options`.

    Parameters
    ----------
    default : bool, int, float or str
        Its type is that of the option.
    doc : str
        What it means.
    unit : str
    least, most : float or str, optional
        Limits that may be reached; a name stands for the value of an option declared before.
        Whole numbers are at most :data:`LARGEST_WHOLE` and others finite, unless ``most`` says
        otherwise.
    above : float, optional
        A lower limit that may not be reached.
    choices : tuple of str
        All that a text may say.
    unset : str
        What the default stands for, where it lies outside of the limits.
    """
    return field(
        default=default,
        metadata={"rule": OptionRule(doc, unit, least, above, most, choices, unset)},
    )


@dataclass(frozen=True)
class Options:
    """Base of the options of all methods, validated on construction.

    Raises
    ------
    InputError
        A value is not of its type or out of range.
    """

    _method: ClassVar[str] = ""

    def __init_subclass__(cls, method: str = "") -> None:
        cls._method = method or cls._method

    def __post_init__(self) -> None:
        for each in fields(self):
            object.__setattr__(self, each.name, _checked(self, each))


Chosen = TypeVar("Chosen", bound=Options)


def read(kind: type[Chosen], values: Mapping[str, Any]) -> Chosen:
    """The options of a method with the given values in place of defaults.

    Raises
    ------
    InputError
        There is no option of a name, or a value is not of its type or out of range.
    """
    for name in values:
        _known(kind, name)
    return kind(**values)


def parsed(kind: type[Options], name: str, text: str) -> Any:
    """The value of an option given as text, converted to the type of its default.

    Raises
    ------
    InputError
        No such option, or not a value of its type.
    """
    default = default_of(_known(kind, name))
    try:
        if isinstance(default, bool):
            return {"true": True, "false": False}[text.lower()]
        return type(default)(text) if isinstance(default, (int, float)) else text
    except (ValueError, KeyError):
        raise InputError(f"{_given(kind, name, text)}: give {_KINDS[type(default)]}") from None


def default_of(each: Field[Any]) -> Any:
    """The default of an option."""
    return each.default if each.default_factory is MISSING else each.default_factory()


def rule_of(each: Field[Any]) -> OptionRule:
    """The rule declared by :func:`option` for an option."""
    rule: OptionRule = each.metadata.get("rule", OptionRule())
    return rule


def listed(kind: type[Options]) -> list[dict[str, Any]]:
    """The options of a method as plain JSON, with infinities written as the text "inf"."""
    found = []
    for each in fields(kind):
        default, rule = default_of(each), rule_of(each)
        plain = isinstance(default, (bool, int, float, str, type(None)))
        if not plain or (isinstance(default, float) and not math.isfinite(default)):
            default = str(default)
        found.append(
            {
                "name": each.name,
                "type": type(default_of(each)).__name__,
                "default": default,
                "unit": rule.unit,
                "allowed": _allowed(each),
                "meaning": rule.doc,
            }
        )
    return found


_KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "a text"}


def _given(kind: type[Options], name: str, value: Any) -> str:
    return f"option {name} = {value!r} of method {kind._method!r}"


def _known(kind: type[Options], name: str) -> Field[Any]:
    known = {each.name: each for each in fields(kind)}
    if name not in known:
        named = ", ".join(known) or "it has none"
        raise InputError(
            f"option {name!r} of method {kind._method!r} is unknown; use one of: {named}"
        )
    return known[name]


def _typed(value: Any, kind: type) -> Any:
    """A value converted to its declared type: kernels compile by type, so 1 must become 1.0."""
    if kind is bool and value in (False, True):
        return bool(value)
    if kind is int:
        return operator.index(value)
    if kind is float and isinstance(value, Real):
        return float(value)
    if kind is str:
        return os.fspath(value)
    if kind in _KINDS:
        raise TypeError
    return value


def _checked(options: Options, each: Field[Any]) -> Any:
    """The value of an option, converted and checked against its range."""
    value, default, rule = getattr(options, each.name), default_of(each), rule_of(each)
    said = _given(type(options), each.name, value)
    try:
        value = _typed(value, type(default))
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{said}: give {_KINDS[type(default)]}") from None
    if rule.choices and value not in rule.choices:
        raise InputError(f"{said}: use {_allowed(each)}")
    free = value == default and (rule.unset or not each.metadata)
    if type(value) in (int, float) and not free:
        least, most = _limits(each, options)
        inside = least <= value <= most and (rule.above is None or value > rule.above)
        # Where there is no rule, what a number may be is for the method to say.
        if not inside and (each.metadata or isinstance(value, int)):
            raise InputError(f"{said}: must be {_allowed(each, options)}")
    return value


def _limits(each: Field[Any], options: Options) -> tuple[float, float]:
    """Least and greatest values of an option, given the values of other options."""
    rule = rule_of(each)
    largest = LARGEST_WHOLE if isinstance(default_of(each), int) else sys.float_info.max
    least = -largest if rule.least is None else rule.least
    most = largest if rule.most is None else rule.most
    return (
        getattr(options, least) if isinstance(least, str) else least,
        getattr(options, most) if isinstance(most, str) else most,
    )


def _allowed(each: Field[Any], options: Options | None = None) -> str:
    """The allowed values of an option, in words, given the values of other options."""
    rule, default = rule_of(each), default_of(each)
    if rule.choices:
        return f"one of {', '.join(rule.choices)}"
    if isinstance(default, bool):
        return _KINDS[bool]
    if type(default) not in (int, float) or not (each.metadata or isinstance(default, int)):
        return ""

    def limit(value: float | str) -> str:
        if isinstance(value, str):
            return value if options is None else f"{value} = {getattr(options, value)!r}"
        return f"{value:g}" if isinstance(value, float) else str(value)

    parts = []
    if rule.least is not None:
        parts.append(f"at least {limit(rule.least)}")
    if rule.above is not None:
        parts.append(f"more than {limit(rule.above)}")
    if rule.most is not None:
        parts.append(f"at most {limit(rule.most)}" if rule.most != math.inf else "")
    else:
        parts.append(f"at most {LARGEST_WHOLE}" if isinstance(default, int) else "finite")
    words = " and ".join(filter(None, parts))
    return f"{words}, or {limit(default)} for {rule.unset}" if rule.unset else words
