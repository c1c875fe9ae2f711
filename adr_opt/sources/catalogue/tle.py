"""Two-line and three-line element sets, read by column and verified by checksum."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime, timedelta

from .records import Dropped, ElementSet, RowError, clean_name, shown

LENGTH = 69
LONGEST_LINE = 1000
FRACTION_US = 864
"""Microseconds in the last of eight decimals of an epoch's day, so that TLE epochs are exact."""

ALPHA_5 = "ABCDEFGHJKLMNPQRSTUVWXYZ"
"""First letters of catalogue numbers from 100000 on, without I and O."""

# Truncated and spoilt lines must look like element lines too, or they would pass for names; a name
# has at most 24 characters.
_ELEMENT_LINE = re.compile(r"([12]) (?:[A-Z\d ][\d ]{3}|[A-Z\d]?[\d ]{0,3}$|.{38})")
_NUMBER = r"([A-HJ-NP-Z \d][ \d]{3}\d)"
_LINE_1 = re.compile(
    rf"1 {_NUMBER}([A-Z ]) ([ -~]{{8}}) (\d\d)([ \d]{{3}})\.(\d{{8}}) ([ +-])([ \d])?\.(\d{{8}})"
    r" ([ +-])(\d{5})([+-]\d) ([ +-])(\d{5})([+-]\d) ([ \d]) ([ \d]{4})\d",
    re.ASCII,
)
_LINE_2 = re.compile(
    rf"2 {_NUMBER} ([ \d]{{3}}\.\d{{4}}) ([ \d]{{3}}\.\d{{4}}) ([ \d]{{7}}) ([ \d]{{3}}\.\d{{4}})"
    r" ([ \d]{3}\.\d{4}) ([ \d]{2}\.\d{8})([ \d]{5})\d",
    re.ASCII,
)
_DIGITS = bytes(
    code - 48 if 48 <= code <= 57 else 1 if code == ord("-") else 0 for code in range(256)
)


def looks_like_tle(lines: Iterable[str]) -> bool:
    """Whether any line could be an element line."""
    return any(_ELEMENT_LINE.match(line) for line in lines)


def read_tle(lines: Iterable[str], source: str) -> Iterator[ElementSet | Dropped]:
    """Element sets among lines, in order.

    Blank lines and lines that begin with ``#`` are passed over. Text behind column 69 is ignored
    if a blank sets it off.
    """
    name, name_line = "", 0
    first, first_line = "", 0
    for number, raw in enumerate(lines, 1):
        line = raw[:LONGEST_LINE].rstrip()
        if not line or line.startswith("#"):
            continue
        kind = _ELEMENT_LINE.match(line)
        if kind is not None and kind[1] == "2" and first:
            try:
                yield _record(first, line, name, source, first_line)
            except RowError as error:
                # the second line carries its own errors
                at = number if error.detail.startswith("line 2 ") else first_line
                yield _bad(error.detail, source, at, first, name, error.reason)
            first = name = ""
            continue
        if first:
            yield _bad("line 1 of a TLE without its line 2", source, first_line, first, name)
            first = name = ""
        if kind is None:
            if name:
                yield _stray(name, source, name_line)
            name, name_line = line, number
        elif kind[1] == "1":
            first, first_line = line, number
        else:
            yield _bad("line 2 of a TLE without its line 1", source, number, line, name)
            name = ""
    if first:
        yield _bad("line 1 of a TLE without its line 2", source, first_line, first, name)
    elif name:
        yield _stray(name, source, name_line)


def _stray(line: str, source: str, number: int) -> Dropped:
    return Dropped(source, number, "", "malformed", f"{shown(line)!r} has no TLE lines after it")


def _bad(
    detail: str, source: str, number: int, line: str, name: str, reason: str = "malformed"
) -> Dropped:
    label = " ".join(part for part in (_name(name), clean_name(line[2:7])) if part)
    return Dropped(source, number, label, reason, detail)


def _name(line: str) -> str:
    # Space-Track numbers the name line 0
    return clean_name(line[2:] if line.startswith("0 ") else line)


def checksum(line: str) -> int:
    """Sum modulo 10 of the digits in the first 68 columns, with a minus sign as 1."""
    return sum(line[: LENGTH - 1].encode("latin-1", "replace").translate(_DIGITS)) % 10


def _check(line: str, which: int) -> str:
    if len(line) < LENGTH:
        raise RowError(
            f"line {which} of the TLE has {len(line)} of {LENGTH} characters", "truncated"
        )
    if len(line) > LENGTH and line[LENGTH] not in " \t":
        raise RowError(f"line {which} of the TLE is longer than {LENGTH} characters")
    line = line[:LENGTH]
    stated, true = line[-1], checksum(line)
    if stated != str(true):
        raise RowError(
            f"line {which} of the TLE has the checksum {shown(stated) or 'blank'}, "
            f"its digits give {true}",
            "checksum",
        )
    return line


def _record(first: str, second: str, name: str, source: str, line: int) -> ElementSet:
    one = _LINE_1.fullmatch(_check(first, 1))
    if one is None:
        raise RowError("line 1 of the TLE breaks its format in some column")
    two = _LINE_2.fullmatch(_check(second, 2))
    if two is None:
        raise RowError("line 2 of the TLE breaks its format in some column")
    if one[1] != two[1]:
        raise RowError(
            f"line 2 of the TLE is about object {two[1].strip()}, line 1 about {one[1].strip()}"
        )
    sign, whole, dot = one[7], one[8], one[9]
    ephemeris_type = int(one[16]) if one[16] != " " else 0
    return ElementSet(
        name=_name(name),
        object_id=_designator(one[3]),
        number=catalogue_number(one[1]),
        epoch=_epoch(one[4], one[5], one[6]),
        mean_motion_rev_day=_number(two[7], "mean motion", 1e-9, 100.0),
        eccentricity=float("0." + two[4].replace(" ", "0")),
        inclination_deg=_number(two[2], "inclination", 0.0, 180.0),
        raan_deg=_number(two[3], "RAAN", 0.0, 360.0),
        argument_of_perigee_deg=_number(two[5], "argument of perigee", 0.0, 360.0),
        mean_anomaly_deg=_number(two[6], "mean anomaly", 0.0, 360.0),
        bstar=_power(one[13], one[14], one[15]),
        mean_motion_dot_rev_day2=float(f"{sign.strip()}{(whole or '').strip()}.{dot}"),
        mean_motion_ddot_rev_day3=_power(one[10], one[11], one[12]),
        classification=one[2].strip() or "U",
        ephemeris_type=ephemeris_type,
        element_set=_count(one[17], 1, "element set"),
        revolution=_count(two[8], 2, "revolution"),
        not_sgp4="ephemeris type 4 is SGP4-XP, not SGP4" if ephemeris_type == 4 else "",
        source=source,
        line=line,
    )


def catalogue_number(text: str) -> int:
    """A catalogue number of five columns, Alpha-5 or digits.

    Raises
    ------
    RowError
        It is neither.
    """
    head, tail = text[:1], text[1:]
    try:
        if head in ALPHA_5:
            return (10 + ALPHA_5.index(head)) * 10000 + int(tail)
        return int(text)
    except ValueError:
        raise RowError(f"catalogue number {shown(text)!r} is neither digits nor Alpha-5") from None


def _designator(columns: str) -> str:
    """``97051C`` in OMM's form ``1997-051C``; other texts unchanged."""
    if re.match(r"\d{5}[A-Z]", columns, re.ASCII):
        year = int(columns[:2])
        return f"{year + (1900 if year >= 57 else 2000)}-{clean_name(columns[2:])}"
    return clean_name(columns)


def _epoch(year_text: str, day_text: str, fraction: str) -> datetime:
    year, day = int(year_text), _count(day_text, 1, "day of the epoch")
    if not 1 <= day <= 366:
        raise RowError(f"line 1 of the TLE has the day {day} in its epoch, not 1 to 366")
    begin = datetime(year + (1900 if year >= 57 else 2000), 1, 1, tzinfo=UTC)
    return begin + timedelta(days=day - 1, microseconds=int(fraction) * FRACTION_US)


def _number(text: str, what: str, low: float, high: float) -> float:
    try:
        value = float(text)
    except ValueError:
        raise RowError(f"line 2 of the TLE has {shown(text)!r} as {what}") from None
    if not low <= value <= high:
        raise RowError(f"line 2 of the TLE has {what} {value:g}, not {low:g} to {high:g}")
    return value


def _count(text: str, which: int, what: str) -> int:
    if not text.strip():
        return 0
    try:
        return int(text)
    except ValueError:
        raise RowError(f"line {which} of the TLE has {text!r} as {what}") from None


def _power(sign: str, digits: str, exponent: str) -> float:
    return float(f"{sign.strip()}0.{digits}e{exponent}")
