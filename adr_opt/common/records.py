"""Base of all data in file formats: strict fields, variants, bounded numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
)

from .constants import DAY_S
from .errors import InputError
from .json_text import model_of
from .sentences import sentence

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:  # where it lies is no part of pydantic's interface
    ModelMetaclass = type(BaseModel)

# A name ends up in formats of other programs, which end texts at a NUL.
Name = Annotated[str, Field(min_length=1, pattern=r"^[^\x00]*$")]
NonNegative = Annotated[float, Field(ge=0.0)]
Positive = Annotated[float, Field(gt=0.0)]

# Far beyond any use, and near enough for arithmetic to hold: two-body motion about the Earth ends
# some 1.5 million km out, angles of many turns have lost their digits, and solvers count ΔV in
# whole steps. Squares and sums stay finite.
LARGEST_LENGTH_M = 1e9
LARGEST_ANGLE_DEG = 1e6
LARGEST_DELTA_V_M_S = 1e9
LARGEST_MASS_KG = 1e9
LARGEST_EXPENSE = 1e12
LARGEST_THRUST_N = 1e6
LARGEST_TIME_S = 1e12
LARGEST_COUNT = 2**31 - 1
LARGEST_DURATION_S = 100 * 365.25 * DAY_S

Count = Annotated[int, Field(ge=0, le=LARGEST_COUNT)]
Length = Annotated[float, Field(gt=0.0, le=LARGEST_LENGTH_M)]
Angle = Annotated[float, Field(ge=-LARGEST_ANGLE_DEG, le=LARGEST_ANGLE_DEG)]
Time = Annotated[float, Field(ge=-LARGEST_TIME_S, le=LARGEST_TIME_S)]
DeltaV = Annotated[float, Field(ge=-LARGEST_DELTA_V_M_S, le=LARGEST_DELTA_V_M_S)]


MACHINERY = frozenset(dir(BaseModel)) - frozenset(dir(object))
"""Names that records inherit from pydantic, deprecated ones among them."""


class _Listed(ModelMetaclass):
    """Metaclass of records: completion at a prompt lists their own names, without pydantic's."""

    def __dir__(cls) -> list[str]:
        return sorted(set(super().__dir__()) - MACHINERY)


JSON_SCHEMA = "https://json-schema.org/draft/2020-12/schema"
"""The dialect of the schemas."""


class Record(BaseModel, metaclass=_Listed):
    """Base of all data: frozen, strict about types, no unknown keys, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    def __dir__(self) -> list[str]:
        return sorted(set(super().__dir__()) - MACHINERY)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read the record from a JSON text.

        Raises
        ------
        pydantic.ValidationError
            Not JSON, a key stands twice in one object, or it breaks the format.
        """
        return model_of(cls, text)

    @classmethod
    def json_schema(cls) -> dict[str, Any]:
        """The JSON Schema of a file that holds such a record."""
        schema = cls.model_json_schema()
        for each in (schema, *schema.get("$defs", {}).values()):
            if "description" in each:
                each["description"] = each["description"].partition("\n\n")[0]
        return {"$schema": JSON_SCHEMA, **schema}

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed.

        Raises
        ------
        InputError
            A change is not valid.
        """
        values = {name: getattr(self, name) for name in type(self).model_fields}
        try:
            return type(self)(**(values | changes))
        except ValidationError as error:
            raise InputError(sentence(error)) from None


class Omitting(Record):
    """A record without its unset fields in files, so that older files stay as they are.

    Attributes
    ----------
    OMITTED : tuple of str
        Fields that are left out where they are null.
    """

    OMITTED: ClassVar[tuple[str, ...]] = ()

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without(write(self), *self.OMITTED)


def without(content: dict[str, Any], *unset: str) -> dict[str, Any]:
    """The written form of a record without fields left unset, so that older files stay as they are.

    Parameters
    ----------
    content : dict
        All fields.
    unset : str
        Those that are left out where they are null.
    """
    return {
        name: value for name, value in content.items() if value is not None or name not in unset
    }


def without_usual(record: Record, content: dict[str, Any], *names: str) -> dict[str, Any]:
    """The written form of a record without some fields where they have their defaults."""
    usual = {name: type(record).model_fields[name].default for name in names}
    return {
        name: value
        for name, value in content.items()
        if name not in usual or getattr(record, name) != usual[name]
    }


Window = Annotated[tuple[Time, Time | None], Field(strict=False)]
"""Opening and closing times since the epoch [s]; null: never."""


def check_window(field: str, window: tuple[float, float | None]) -> None:
    """Raise ``ValueError`` for a window that closes before it opens."""
    opens, closes = window
    if closes is not None and closes < opens:
        raise ValueError(
            f"{field} = [{opens!r}, {closes!r}] must not close before it opens; give the earlier "
            "time first"
        )
