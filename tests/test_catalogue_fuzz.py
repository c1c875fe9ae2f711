"""No content of a catalogue file ends in anything but records, bad rows or one sentence."""

from __future__ import annotations

import time

import numpy as np
import pytest
from catalogue_files import SPELLINGS, as_space_track_json, field
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue import Imported, to_instance
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.catalogue.records import Catalogue
from adr_opt.sources.catalogue.tle import LENGTH, checksum

pytest.importorskip("sgp4")

LONGEST_SENTENCE = 600
SEEDS = [write(field(3)).encode() for write in (*SPELLINGS.values(), as_space_track_json)]

PIECES = [
    b"", b"\n", b"\r", b"\0", b" ", b",", b'"', b"=", b"[", b"]", b"{", b"}", b"<", b">", b"&",
    b"<!--", b"<![CDATA[", b"<!DOCTYPE a>", b"nan", b"inf", b"1e999", b"-1", b"0", b"9" * 400,
    b"1e-320", b"null", b"true", b"\xff\xfe", b"\xc3", b"\xe2\x80\xa8", b"\\ud800", b"1.0", b"1_0",
    "٣".encode(), b"1 00005", b"2 00005", b"#", b"CCSDS_OMM_VERS = 2.0\n", b"</segment>",
    b"<segment>", b"16.9", b"0.9999999",
]  # fmt: skip


def outcome(data: bytes, *, skip_bad: bool) -> None:
    """Read and import; anything but an InputError with a short sentence is a finding."""
    begin = time.monotonic()
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
    assert time.monotonic() - begin < 10.0


@st.composite
def spoilt(draw: st.DrawFn) -> bytes:
    """A file of any spelling with some pieces cut, doubled, or replaced."""
    data = draw(st.sampled_from(SEEDS))
    for _ in range(draw(st.integers(1, 4))):
        begin = draw(st.integers(0, len(data)))
        end = min(len(data), begin + draw(st.sampled_from([0, 1, 1, 2, 8, 70, 10_000])))
        piece = draw(
            st.one_of(
                st.sampled_from(PIECES),
                st.binary(max_size=4),
                st.just(data[begin:end] * 2),
            )
        )
        data = data[:begin] + piece + data[end:]
    return data


def with_checksums(data: bytes) -> bytes:
    """The data with right checksums in its TLE lines, so that they are not all that is tried."""
    lines = data.split(b"\n")
    for place, line in enumerate(lines):
        if line[:2] in (b"1 ", b"2 ") and len(line) >= LENGTH:
            right = str(checksum(line[:LENGTH].decode("latin-1"))).encode()
            lines[place] = line[: LENGTH - 1] + right + line[LENGTH:]
    return b"\n".join(lines)


@given(spoilt(), st.booleans())
@settings(max_examples=600, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_spoilt_files(data: bytes, skip_bad: bool) -> None:
    """A spoilt file is read as far as it is good, or refused in one printable sentence."""
    outcome(data, skip_bad=skip_bad)
    outcome(with_checksums(data), skip_bad=skip_bad)


@given(st.binary(max_size=300), st.booleans())
@settings(max_examples=200, deadline=None)
def test_any_bytes(data: bytes, skip_bad: bool) -> None:
    """Bytes that are no catalogue are refused in one printable sentence."""
    outcome(data, skip_bad=skip_bad)


NUMBER = st.one_of(
    st.floats().map(repr),
    st.integers().map(str),
    st.sampled_from(["", "0", "1", "1e-9", "99.9", "16.5", "0.999999", "179.99", "360", "null"]),
)


@given(
    st.dictionaries(
        st.sampled_from(
            [
                "MEAN_MOTION", "ECCENTRICITY", "INCLINATION", "RA_OF_ASC_NODE", "BSTAR",
                "ARG_OF_PERICENTER", "MEAN_ANOMALY", "MEAN_MOTION_DOT", "MEAN_MOTION_DDOT",
                "NORAD_CAT_ID", "EPHEMERIS_TYPE",
            ]
        ),
        NUMBER,
        min_size=1,
    )
)  # fmt: skip
@settings(max_examples=300, deadline=None)
def test_any_elements(values: dict[str, str]) -> None:
    """Whatever the elements are, SGP4 gives a usable orbit, or the object is named and left out."""
    rows = SPELLINGS["csv"](field(2)).splitlines()
    changed = dict(zip(rows[0].split(","), rows[1].split(","), strict=True)) | values
    text = "\n".join([rows[0], ",".join(changed.values()), rows[2]])
    outcome(text.encode(), skip_bad=True)
    outcome(text.encode(), skip_bad=False)


@pytest.mark.parametrize(
    ("begin", "end"),
    [
        (b'<ndm><omm id="', b'"/></ndm>'),
        (b"<ndm><omm ", b"='1'/></ndm>"),
        (b"<ndm><", b"/></ndm>"),
        (b"<ndm><!--", b"--></ndm>"),
        (b"<ndm><?a ", b"?></ndm>"),
        (b"<!--", b"--><ndm/>"),
    ],
)
def test_a_token_without_end_is_refused_at_once(begin: bytes, end: bytes) -> None:
    """One tag, attribute or comment of 30 MB costs no more time than one of 2 MB."""
    began = time.perf_counter()
    with pytest.raises(InputError, match="line 1: a tag or a comment longer than 1 MiB"):
        read_bytes(begin + b"a" * 30_000_000 + end, "file")
    assert time.perf_counter() - began < 5.0
    with pytest.raises(InputError, match="no element set"):
        read_bytes(begin + b"a" * 900_000 + end, "file")
