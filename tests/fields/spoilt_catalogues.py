"""Catalogues that are spoilt, and what becomes of them."""

from __future__ import annotations

import time

import numpy as np
from catalogue_files import SPELLINGS, as_space_track_json, field

from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue import Imported, to_instance
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.catalogue.records import Catalogue
from adr_opt.sources.catalogue.tle import LENGTH, checksum

LONGEST_SENTENCE = 600

SEEDS = [write(field(3)).encode() for write in (*SPELLINGS.values(), as_space_track_json)]


PIECES = [
    b"",
    b"\n",
    b"\r",
    b"\0",
    b" ",
    b",",
    b'"',
    b"=",
    b"[",
    b"]",
    b"{",
    b"}",
    b"<",
    b">",
    b"&",
    b"<!--",
    b"<![CDATA[",
    b"<!DOCTYPE a>",
    b"nan",
    b"inf",
    b"1e999",
    b"-1",
    b"0",
    b"9" * 400,
    b"1e-320",
    b"null",
    b"true",
    b"\xff\xfe",
    b"\xc3",
    b"\xe2\x80\xa8",
    b"\\ud800",
    b"1.0",
    b"1_0",
    "٣".encode(),
    b"1 00005",
    b"2 00005",
    b"#",
    b"CCSDS_OMM_VERS = 2.0\n",
    b"</segment>",
    b"<segment>",
    b"16.9",
    b"0.9999999",
]


def outcome(data: bytes, *, skip_bad: bool) -> None:
    """Read and import; anything but an InputError with a short sentence is a finding."""
    begin = time.process_time()
    try:
        found = read_bytes(data, "file", skip_bad=skip_bad)
        assert isinstance(found, Catalogue)
        made = to_instance(found, max_targets=2, skip_bad=skip_bad)
        assert isinstance(made, Imported)
        made.instance.to_json().encode()
        assert np.isfinite(made.instance.orbits()).all()
        str(made.to_dict()).encode()
    except InputError as error:
        said = str(error)
        assert "\n" not in said
        assert 10 < len(said) < LONGEST_SENTENCE
        assert said.isprintable()
    assert time.process_time() - begin < 10.0


def with_checksums(data: bytes) -> bytes:
    """The data with right checksums in its TLE lines, so that they are not all that is tried."""
    lines = data.split(b"\n")
    for place, line in enumerate(lines):
        if line[:2] in (b"1 ", b"2 ") and len(line) >= LENGTH:
            right = str(checksum(line[:LENGTH].decode("latin-1"))).encode()
            lines[place] = line[: LENGTH - 1] + right + line[LENGTH:]
    return b"\n".join(lines)
