"""Catalogue files: format detection, records, bad rows and duplicates."""

from __future__ import annotations

import io
import itertools
import os
import re
import stat
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from ...common.errors import InputError
from ..file_formats import UTF_16, ephemeris_format, head_of
from .omm_formats import read_csv, read_json, read_kvn, read_xml
from .records import Catalogue, Dropped, ElementSet, shown
from .tle import looks_like_tle, read_tle

LARGEST_BYTES = 256 * 2**20
"""Maximum file size: all objects ever catalogued, as OMM XML, take about half of it [bytes]."""

MOST_BAD_ROWS = 100_000
"""Maximum number of bad rows; with more, the file is not a catalogue."""

Paths = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


def read(paths: Paths, *, skip_bad: bool = False) -> Catalogue:
    """Read element sets from one or more files of any of the formats.

    Parameters
    ----------
    paths : path or sequence of paths
    skip_bad : bool
        Keep the good rows and list the bad ones, and of several element sets of one object keep
        the newest; else the first bad row or duplicate is an error.

    Raises
    ------
    InputError
        A file cannot be read or is no catalogue, a row is bad, or nothing good is left.
    """
    listed = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    return joined(
        (read_bytes(load_bytes(path), str(path), skip_bad=skip_bad) for path in listed),
        skip_bad=skip_bad,
    )


def joined(parts: Iterable[Catalogue], *, skip_bad: bool = False) -> Catalogue:
    """One catalogue of several, without duplicates.

    Parameters
    ----------
    parts : iterable of Catalogue
        As :func:`read_bytes` gives them.
    skip_bad : bool
        As of :func:`read`.

    Raises
    ------
    InputError
        As of :func:`read`.
    """
    records: list[ElementSet] = []
    dropped: list[Dropped] = []
    formats: dict[str, str] = {}
    for found in parts:
        records += found.records
        dropped += found.dropped
        formats |= found.formats
    kept, older = _newest(records, skip_bad)
    return Catalogue(tuple(kept), (*dropped, *older), formats)


def read_bytes(data: bytes, source: str, *, skip_bad: bool = False) -> Catalogue:
    """Read element sets from the content of one file, duplicates included.

    Parameters
    ----------
    data : bytes
    source : str
        Names the file in errors.
    skip_bad : bool
        As of :func:`read`.

    Raises
    ------
    InputError
        As of :func:`read`.
    """
    kind, rows = _recognise(data, source)
    records: list[ElementSet] = []
    dropped: list[Dropped] = []
    for row in rows:
        if isinstance(row, ElementSet):
            records.append(row)
            continue
        if not skip_bad:
            raise InputError(f"{row}; correct it, or leave bad rows out with --skip-bad")
        dropped.append(row)
        if len(dropped) > MOST_BAD_ROWS:
            raise InputError(
                f"{source}: more than {MOST_BAD_ROWS} bad rows up to line {row.line}; give a "
                "catalogue"
            )
    if not records:
        first = f"; the first of {len(dropped)} bad rows: {dropped[0].within}" if dropped else ""
        raise InputError(f"{source}: no element set in it ({kind}){first}; give a catalogue")
    return Catalogue(tuple(records), tuple(dropped), {source: kind})


def load_bytes(path: str | os.PathLike[str]) -> bytes:
    """Content of a file of element sets, or an :class:`InputError` if it cannot be one."""
    try:
        with Path(path).open("rb") as file:
            status = os.fstat(file.fileno())
            size = status.st_size if stat.S_ISREG(status.st_mode) else 0
            # one byte more than allowed: devices and pipes do not say how long they are
            data = b"" if size > LARGEST_BYTES else file.read(LARGEST_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a folder; name a file in it") from None
    except (OSError, ValueError) as error:
        said = getattr(error, "strerror", None) or error
        raise InputError(
            f"{path}: cannot be read ({said}); check the path and its permissions"
        ) from None
    if size > LARGEST_BYTES or len(data) > LARGEST_BYTES:
        raise InputError(
            f"{path}: larger than {LARGEST_BYTES // 2**20} MiB; give a part of the catalogue"
        )
    return data


def _recognise(data: bytes, source: str) -> tuple[str, Iterable[ElementSet | Dropped]]:
    """Name of the format, and its reader applied to the data."""
    if data.startswith((b"\x1f\x8b", b"PK\x03\x04", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd")):
        raise InputError(f"{source}: compressed; unpack it first")
    data = data.removeprefix(b"\xef\xbb\xbf")
    head = head_of(data)
    if data.startswith(UTF_16) and not head.startswith("<"):
        raise InputError(f"{source}: a text in UTF-16; save it as UTF-8")
    if not head:
        raise InputError(f"{source}: empty; download the catalogue again")
    if "\0" in head:
        raise InputError(f"{source}: not a text file; give TLE or OMM")
    if head.startswith("<"):
        if re.search(r"<(!doctype\s+html|html)\b", head, re.IGNORECASE):
            raise InputError(
                f"{source}: a web page{_title(head)}, not a catalogue; download it again"
            )
        return "OMM XML", read_xml(data.lstrip(), source)
    if head.startswith(("[", "{")):
        return "OMM JSON", read_json(data.decode("utf-8", "replace"), source)
    if ephemeris_format(head):
        raise InputError(
            f"{source}: {ephemeris_format(head)}, not mean elements; give a catalogue, and this "
            "file with --oem"
        )
    begin = next((line for line in head.splitlines() if _says_something(line)), "")
    message = re.match(r"\s*CCSDS_(\w+)_VERS\s*=", begin)
    if message is not None:
        if message[1] != "OMM":
            raise InputError(
                f"{source}: an {shown(message[1])}, not an OMM; give mean elements (OMM or TLE)"
            )
        return "OMM KVN", read_kvn(_lines(data), source)
    if "MEAN_MOTION" in begin.upper() or "NORAD_CAT_ID" in begin.upper():
        return "OMM CSV", read_csv(_lines(data), source)
    if looks_like_tle(itertools.islice(_lines(data), 1000)):
        return "TLE", read_tle(_lines(data), source)
    raise InputError(
        f"{source}: neither TLE nor OMM, it begins with {shown(begin)!r}; give a catalogue"
    )


def _says_something(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(("COMMENT", "#"))


def _title(head: str) -> str:
    title = re.search(r"<title[^>]*>([^<]*)", head, re.IGNORECASE)
    return f" ({shown(title[1])!r})" if title is not None and title[1].strip() else ""


def _lines(data: bytes) -> Iterator[str]:
    # one at a time: a list of all lines would be many times larger than a file of short ones
    return iter(io.TextIOWrapper(io.BytesIO(data), encoding="utf-8", errors="replace"))


def _newest(records: list[ElementSet], skip_bad: bool) -> tuple[list[ElementSet], list[Dropped]]:
    """Records without duplicates, and those older than another of the same object."""
    best: dict[tuple[object, ...], ElementSet] = {}
    older: list[Dropped] = []
    for record in records:
        other = best.get(record.key)
        if other is None:
            best[record.key] = record
            continue
        detail = f"the object is also in {other.source}, line {other.line}"
        if not skip_bad:
            raise InputError(
                f"{Dropped.of(record, 'duplicate', detail)}; keep one, or keep the newest of each "
                "object with --skip-bad"
            )
        if record.epoch > other.epoch:
            best[record.key], record, other = record, other, record
        detail = f"the elements in {other.source}, line {other.line}, are kept"
        older.append(Dropped.of(record, "duplicate", detail))
    return list(best.values()), older
