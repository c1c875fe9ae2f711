"""Content of a catalogue: element sets, and rejected rows or objects."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from datetime import datetime
from typing import Any

LONGEST_NAME = 80
"""Length beyond which names of objects are cut."""


NO_DESIGNATOR = ("", "UNKNOWN", "TBA", "TBD", "NONE")
"""Placeholders for a missing international designator."""


@dataclass(frozen=True, slots=True)
class ElementSet:
    """An element set: mean elements of SGP4 in TEME at their epoch.

    Two records are equal if they say the same, wherever they were read.

    Attributes
    ----------
    name : str
        Empty where the file has none.
    object_id : str
        International designator as OMM writes it, ``1997-051C``.
    number : int or None
        Catalogue number; Alpha-5 is decoded.
    epoch : datetime
        UTC, to the microsecond.
    mean_motion_rev_day : float
        Kozai mean motion, as TLE and OMM give it.
    eccentricity, inclination_deg, raan_deg, argument_of_perigee_deg, mean_anomaly_deg : float
    bstar : float
        Drag term [1/Earth radii].
    mean_motion_dot_rev_day2, mean_motion_ddot_rev_day3 : float
        Half the first and a sixth of the second derivative, as the formats give them.
    classification : str
    ephemeris_type, element_set, revolution : int
    not_sgp4 : str
        Why SGP4 cannot propagate these elements; empty if it can.
    mass_kg : float or None
        Where the file says it.
    size : str
        Class of the radar cross-section, ``SMALL``, ``MEDIUM`` or ``LARGE``; empty if none is said.
    decays : datetime or None
        When the object came or comes down, if the file says so; a date is its first moment.
    source : str
        The file.
    line : int
        Where in the file the record begins.
    ordinal : int or None
        Which record of the file, where lines do not tell.
    """

    name: str
    object_id: str
    number: int | None
    epoch: datetime
    mean_motion_rev_day: float
    eccentricity: float
    inclination_deg: float
    raan_deg: float
    argument_of_perigee_deg: float
    mean_anomaly_deg: float
    bstar: float = 0.0
    mean_motion_dot_rev_day2: float = 0.0
    mean_motion_ddot_rev_day3: float = 0.0
    classification: str = "U"
    ephemeris_type: int = 0
    element_set: int = 0
    revolution: int = 0
    not_sgp4: str = ""
    # Of the object and not of its orbit: most spellings have no place for them.
    mass_kg: float | None = field(default=None, compare=False)
    size: str = field(default="", compare=False)
    decays: datetime | None = field(default=None, compare=False)
    source: str = field(default="", compare=False)
    line: int = field(default=0, compare=False)
    ordinal: int | None = field(default=None, compare=False)

    @property
    def key(self) -> tuple[Any, ...]:
        """Identity of the object: its number, else the designator with the name.

        Number 0 and the designator UNKNOWN are of objects that are not catalogued yet. Without
        either, only a record that says the same is the same.
        """
        if self.number:
            return (self.number,)
        if self.object_id.upper() not in NO_DESIGNATOR:
            return (self.object_id, self.name)
        return (self,)

    def is_down(self, time: datetime) -> bool:
        """Whether the object has decayed by a time, according to the file."""
        return self.decays is not None and self.decays <= time

    @property
    def designator(self) -> str | None:
        """The international designator in printable form; None if there is none."""
        known = self.object_id.upper() not in NO_DESIGNATOR and self.object_id.isascii()
        return self.object_id if known else None

    @property
    def label(self) -> str:
        """Name of the object in an instance, with a number or designator to distinguish it."""
        identity = str(self.number) if self.number else self.object_id
        return " ".join(part for part in (self.name or "object", identity) if part)


@dataclass(frozen=True, slots=True)
class Dropped:
    """A rejected row or object, with the reason.

    Attributes
    ----------
    source, line, ordinal
        As of :class:`ElementSet`.
    object : str
        Name and number as far as known.
    reason : str
        One word for counting: ``malformed``, ``decayed``, ``altitude``, …
    detail : str
        The reason as a clause, with field and value.
    """

    source: str
    line: int
    object: str
    reason: str
    detail: str
    ordinal: int | None = None

    @classmethod
    def of(cls, record: ElementSet, reason: str, detail: str) -> Dropped:
        """A rejected record."""
        return cls(record.source, record.line, record.label, reason, detail, record.ordinal)

    @property
    def within(self) -> str:
        """Place and reason within the file."""
        where = f"line {self.line}" if self.line else ""
        if self.ordinal is not None:
            where += f", record {self.ordinal}"
        if self.object:
            where += f" ({self.object})"
        return ": ".join(part for part in (where, self.detail) if part)

    def __str__(self) -> str:
        return ": ".join(part for part in (self.source, self.within) if part)

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON data."""
        return asdict(self)


class RowError(ValueError):
    """An error in a row of a catalogue.

    Parameters
    ----------
    detail : str
        What is wrong, as a clause.
    reason : str
        One word for counting.
    """

    def __init__(self, detail: str, reason: str = "malformed") -> None:
        super().__init__(detail)
        self.detail = detail
        self.reason = reason


@dataclass(frozen=True)
class Catalogue:
    """The content of files: valid records in order, and bad rows.

    Attributes
    ----------
    records : tuple of ElementSet
    dropped : tuple of Dropped
        Empty unless bad rows were to be skipped.
    formats : dict
        File → what it was recognised as.
    """

    records: tuple[ElementSet, ...]
    dropped: tuple[Dropped, ...] = ()
    formats: dict[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[ElementSet]:
        return iter(self.records)


def clean_name(text: str) -> str:
    """A name that is safe to print: one line, no control characters, limited length."""
    if not (text.isascii() and text.isprintable()):
        text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return " ".join(text.split())[:LONGEST_NAME].rstrip()


def shown(value: Any, longest: int = 40) -> str:
    """A value from a file, as quoted in messages."""
    text = clean_name(str(value)[: 2 * longest])
    return text if len(text) <= longest else text[: longest - 1] + "…"
