"""Kinds of legs: the facts that files, flights and pages need.

How legs of a kind are found and flown is for its family to say (:mod:`adr_opt.legs.families`),
which adds a kind when it is registered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from ..common.errors import InputError

ENTRY_POINTS = "adr_opt.leg_families"
"""Entry-point group of functions of installed packages that register families of legs."""


@dataclass(frozen=True)
class LegKind:
    """A kind of leg, without computations.

    Attributes
    ----------
    name : str
        What plan files call it.
    noun, adjective : str
        What sentences call a leg of it, and transfers.
    has_burns : bool
        Whether plans state its burns, the last of them those of the approach.
    from_nowhere : bool
        Whether the chaser is nowhere before it.
    counts_laps : bool
        Whether its phasing revolutions mean something.
    on_time_grid : bool
        Whether it is planned between times of a grid, at the ΔV of a closed form: then it may
        leave later and arrive earlier, and costs what its burns add up to.
    has_arcs : bool
        Whether plans state arcs of low thrust in place of burns.
    """

    name: str
    noun: str
    adjective: str
    has_burns: bool = True
    from_nowhere: bool = False
    counts_laps: bool = False
    on_time_grid: bool = False
    has_arcs: bool = False


SHORT = LegKind("short", "short leg", "short", counts_laps=True)
DRIFT = LegKind("drift", "drift", "drifting", on_time_grid=True)
LAUNCH = LegKind("launch", "launch", "launched", has_burns=False, from_nowhere=True)
GIVEN = LegKind("given", "given leg", "given", has_burns=False)

LOW_THRUST = LegKind(
    "low-thrust", "low-thrust leg", "low-thrust", has_burns=False, on_time_grid=True, has_arcs=True
)

_known = {kind.name: kind for kind in (SHORT, DRIFT, LAUNCH, GIVEN, LOW_THRUST)}

_installed = [entry_points]
"""Pending lookup of installed families, done once: emptied before they are loaded, as
loading may ask for kinds."""


def _load_installed() -> None:
    """Let installed packages register their families, on the first call."""
    while _installed:
        for entry in _installed.pop()(group=ENTRY_POINTS):
            try:
                entry.load()()
            except Exception as error:
                raise InputError(
                    f"the legs {entry.name!r} of an installed package cannot be registered "
                    f"({error}); update or uninstall {entry.value.partition(':')[0]!r}"
                ) from error


def leg_kinds() -> tuple[LegKind, ...]:
    """All kinds, each at the number of its family."""
    _load_installed()
    return tuple(_known.values())


def leg_kind(name: str) -> LegKind:
    """The kind with a name."""
    _load_installed()
    return _known[name]


def add_leg_kind(kind: LegKind) -> None:
    """Register a kind, which legs in files may then have.

    Raises
    ------
    ValueError
        Its name is taken.
    """
    if kind.name in _known:
        raise ValueError(f"a kind of legs {kind.name!r} is registered already")
    _known[kind.name] = kind


def drop_leg_kind(kind: LegKind) -> None:
    """Remove a registered kind."""
    del _known[kind.name]


class OneOf:
    """Annotation of a text in a file that must be one of an extensible set of words.

    Parameters
    ----------
    words : callable
        Gives them.
    """

    def __init__(self, words: Callable[[], Iterable[str]]) -> None:
        self._words = words

    def _checked(self, word: str) -> str:
        known = list(self._words())
        if word not in known:
            *others, last = map(repr, known)
            raise PydanticCustomError(
                "literal_error",
                "Input should be {expected}",
                {"expected": f"{', '.join(others)} or {last}"},
            )
        return word

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "enum": list(self._words())}


def kind_names() -> tuple[str, ...]:
    """Names of all kinds."""
    return tuple(kind.name for kind in leg_kinds())


def flown_kind_names() -> tuple[str, ...]:
    """Names of the kinds whose legs have burns."""
    return tuple(kind.name for kind in leg_kinds() if kind.has_burns)


def refined_kind_names() -> tuple[str, ...]:
    """Names of the kinds whose legs are refined: those with burns or arcs."""
    return tuple(kind.name for kind in leg_kinds() if kind.has_burns or kind.has_arcs)


KindName = Annotated[str, OneOf(kind_names)]
RefinedKindName = Annotated[str, OneOf(refined_kind_names)]
