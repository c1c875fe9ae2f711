"""Files that are spoilt on purpose: bytes, tokens, keys, columns, types, numbers, ends and rows.

Every case is drawn from its number, so that one that fails can be made again by itself.
"""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from typing import Any

NUMBERS = (
    "nan",
    "NaN",
    "inf",
    "-inf",
    "Infinity",
    "-Infinity",
    "1e308",
    "-1e308",
    "1e999",
    "-0",
    "-0.0",
    "0",
    "1e-320",
    "-1",
    "1e12",
    "0.1",
    "9" * 400,
    "1_000",
    "0x10",
    "٣",
    "",
    "null",
    "true",
    '""',
)
"""Replacements of a number in a text."""

VALUES = (
    None,
    True,
    False,
    0,
    -0.0,
    -1,
    1e308,
    -1e308,
    1e-320,
    10**400,
    float("nan"),
    float("inf"),
    "",
    "nan",
    "1",
    "a\0b",
    "\x1b[2J",
    "\u202e",
    [],
    [[]],
    {},
    {"a": 1},
    [None],
    "x" * 3000,
    2**63,
)
"""Replacements of a value in JSON."""

PIECES = (
    b"",
    b"\n",
    b"\r",
    b"\0",
    b",",
    b'"',
    b'""',
    b"[",
    b"]",
    b"{",
    b"}",
    b":",
    b"nan",
    b"1e308",
    b"-0",
    b"\xff",
    b"\xc3",
    b"\xe2\x80\xa8",
    b"\x1b[2J",
    b"\\u0000",
    b"\\ud800",
    b"null",
    b"9" * 400,
    b"PAR1",
    b"OHDR",
)
"""Replacements of some bytes."""

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def drawn(kind: str, number: int) -> random.Random:
    """Source of a case's random numbers."""
    return random.Random(f"{kind} {number}")


def several(rng: random.Random) -> range:
    """Number of simultaneous mutations: mostly one."""
    return range(rng.choice([1, 1, 1, 2, 3, 8]))


def spoilt_bytes(data: bytes, rng: random.Random) -> bytes:
    """The file with bytes changed, pieces cut, doubled or put in, or its end cut off."""
    for _ in several(rng):
        begin = rng.randrange(len(data) + 1)
        end = min(len(data), begin + rng.choice([0, 1, 1, 2, 8, 70, 1000]))
        how = rng.randrange(5)
        if how == 0:
            data = data[:begin]
        elif how == 1:
            data = data[:begin] + data[begin:end] * 2 + data[end:]
        elif how == 2 and begin < len(data):
            data = data[:begin] + bytes([rng.randrange(256)]) + data[begin + 1 :]
        elif how == 3:
            other = rng.randrange(len(data) + 1)
            data = data[:begin] + data[other : other + end - begin] + data[end:]
        else:
            data = data[:begin] + rng.choice(PIECES) + data[end:]
    return data


def changed_bytes(data: bytes, rng: random.Random) -> bytes:
    """The file with other bytes here and there, and as long as before."""
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5, 20])):
        changed[rng.randrange(len(data))] = rng.choice([0, 255, rng.randrange(256)])
    return bytes(changed)


def spoilt_numbers(data: bytes, rng: random.Random) -> bytes:
    """The text with other numbers in it."""
    for _ in several(rng):
        places = list(NUMBER.finditer(data))
        if not places:
            break
        place = rng.choice(places)
        data = data[: place.start()] + rng.choice(NUMBERS).encode() + data[place.end() :]
    return data


def spoilt_lines(data: bytes, rng: random.Random) -> bytes:
    """The text with lines doubled, dropped, exchanged, glued together or cut."""
    lines = data.split(b"\n")
    for _ in several(rng):
        one, other, how = rng.randrange(len(lines)), rng.randrange(len(lines)), rng.randrange(5)
        if how == 0:
            lines.insert(other, lines[one])
        elif how == 1 and len(lines) > 1:
            del lines[one]
        elif how == 2:
            lines[one], lines[other] = lines[other], lines[one]
        elif how == 3:
            lines[one] += lines[other]
        else:
            lines[one] = lines[one][: rng.randrange(len(lines[one]) + 1)]
    return b"\n".join(lines)


def spoilt_json(data: bytes, rng: random.Random) -> bytes:
    """The JSON with keys dropped, misspelt or given twice, values of other types, items doubled."""
    content = json.loads(data)
    twice = None
    for _ in several(rng):
        places = list(_places(content))
        if not places:
            break
        inside, key = rng.choice(places)
        how = rng.randrange(5)
        if how == 0:
            del inside[key]
        elif how == 1:
            inside[key] = rng.choice(VALUES)
        elif how == 2 and isinstance(inside, dict):
            inside[_misspelt(key, rng)] = inside.pop(key)
        elif how == 3 and isinstance(inside, list):
            inside.insert(key, inside[rng.randrange(len(inside))])
        elif how == 3:
            other, its = rng.choice(places)
            if other is not inside:
                inside[key] = json.loads(json.dumps(other[its]))
        else:
            twice = key if isinstance(key, str) else None
    text = json.dumps(content, ensure_ascii=rng.random() < 0.5)
    if twice is not None:
        text = text.replace(
            f'"{twice}":', f'"{twice}": {json.dumps(rng.choice(VALUES))}, "{twice}":'
        )
    return text.encode(errors="surrogatepass")


def _places(content: Any) -> Any:
    """Every key of an object and every place of a list, with what it is in."""
    if isinstance(content, dict | list):
        keys = content.keys() if isinstance(content, dict) else range(len(content))
        for key in list(keys):
            yield content, key
            yield from _places(content[key])


def _misspelt(key: str, rng: random.Random) -> str:
    at = rng.randrange(len(key) + 1)
    return rng.choice([key[:at], key[:at] + key[at + 1 :], key.upper(), key + "_s", key[:at] + "x"])


def spoilt_cells(data: bytes, rng: random.Random, others: tuple[str, ...] = ()) -> bytes:
    """The CSV with other cells, of which some stand elsewhere in it, and columns more or less."""
    import csv
    import io

    rows = list(csv.reader(io.StringIO(data.decode(), newline="")))
    for _ in several(rng):
        row, how = rng.choice(rows), rng.randrange(6)
        if not row:
            continue
        at = rng.randrange(len(row))
        if how == 0:
            del row[at]
        elif how == 1:
            row.insert(at, row[at])
        elif how == 2:
            row[at] = rng.choice(NUMBERS)
        elif how == 3:
            row[at] = rng.choice(
                (*others, "\x1b[2J", "[]", "[[]]", "{}", "1e308", "nan", "+", "a\0")
            )
        elif how == 4:
            row[at] = rng.choice(rng.choice(rows) or [""])
        else:
            rows.append(list(row))
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator=rng.choice(["\n", "\n", "\r\n"])).writerows(rows)
    return text.getvalue().encode(errors="surrogatepass")


Mutator = Callable[[bytes, random.Random], bytes]


def spoilt(data: bytes, rng: random.Random, *ways: Mutator) -> bytes:
    """The file spoilt in one of some ways, and now and then in two."""
    for _ in range(rng.choice([1, 1, 1, 2])):
        way = rng.choice(ways)
        try:
            data = way(data, rng)
        except (ValueError, RecursionError):  # already spoilt: no JSON, no CSV
            data = spoilt_bytes(data, rng)
    return data
