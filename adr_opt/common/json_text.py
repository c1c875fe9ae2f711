"""The only parser of JSON texts, so that repeated keys are refused everywhere.

Parsers keep the last value of a key that stands twice in an object, and say nothing of the others.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import Any, LiteralString, NoReturn, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from .errors import InputError

T = TypeVar("T")
M = TypeVar("M", bound=BaseModel)

REPEATED = "repeated_key"
"""Type of the validation error for a repeated key."""

LONGEST_KEY = 60
"""Length beyond which keys are cut in error messages."""


class _RepeatedKeyError(InputError):
    """A key stands twice in one object."""


def loaded(text: str | bytes) -> Any:
    """The data of a JSON text.

    Raises
    ------
    InputError
        A key stands twice in one object.
    json.JSONDecodeError, UnicodeDecodeError, RecursionError
        It is not JSON, or nested too deeply.
    """
    return json.loads(text, object_pairs_hook=_object)


def parse_json(text: str | bytes, where: str, otherwise: str = "") -> Any:
    """The data of a user's JSON text.

    Parameters
    ----------
    text : str or bytes
    where : str
        Begins messages: the file, and the line in it if there are several texts.
    otherwise : str, optional
        What to say of a text that is not JSON, in place of what is wrong with it.

    Raises
    ------
    InputError
        It is not JSON, or a key stands twice in one object.
    """
    try:
        return loaded(text)
    except _RepeatedKeyError as error:
        raise InputError(f"{where}: {error}") from None
    except (ValueError, RecursionError) as error:
        said = otherwise or f"not JSON: {_why(error)}; give a JSON file"
        raise InputError(f"{where}: {said}") from None


def _why(error: ValueError | RecursionError) -> str:
    if isinstance(error, json.JSONDecodeError):
        return error.msg
    if isinstance(error, UnicodeDecodeError):
        return "not text in UTF-8"
    return "nested too deeply" if isinstance(error, RecursionError) else "a number is too long"


def validated(kind: TypeAdapter[T], text: str | bytes) -> T:
    """The value of a type in a JSON text.

    Raises
    ------
    pydantic.ValidationError
        It is not JSON, is of another type, or a key stands twice in one object.
    """
    _check_keys(text, "JSON")
    return kind.validate_json(text)


def model_of(kind: type[M], text: str | bytes) -> M:
    """The record in a JSON text; raises as :func:`validated` does."""
    _check_keys(text, kind.__name__)
    return kind.model_validate_json(text)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        _refuse(pairs)
    return made


def _only_keys(pairs: list[tuple[str, Any]]) -> None:
    """Check the keys of an object, and keep nothing of it."""
    if len(dict(pairs)) < len(pairs):
        _refuse(pairs)


def _refuse(pairs: list[tuple[str, Any]]) -> NoReturn:
    keys = Counter(key for key, _ in pairs)
    shown = json.dumps(keys.most_common(1)[0][0])
    if len(shown) > LONGEST_KEY:
        shown = shown[: LONGEST_KEY - 1] + "…"
    raise _RepeatedKeyError(f"field {shown} occurs twice in one object; keep one")


def refused(title: str, said: str, kind: LiteralString = REPEATED) -> ValidationError:
    """The validation error of a whole file, as one sentence."""
    told = PydanticCustomError(kind, "{said}", {"said": said})
    details = InitErrorDetails(type=told, loc=(), input=None)
    return ValidationError.from_exception_data(title, [details], input_type="json")


def _nothing(number: str) -> None:
    """Placeholder for a number where only keys are checked."""


def _check_keys(text: str | bytes, title: str) -> None:
    try:
        json.loads(
            text,
            object_pairs_hook=_only_keys,
            parse_float=_nothing,
            parse_int=_nothing,
            parse_constant=_nothing,
        )
    except _RepeatedKeyError as error:
        raise refused(title, str(error)) from None
    except (ValueError, RecursionError):
        pass  # not JSON: validation says why
