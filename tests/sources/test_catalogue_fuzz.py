"""No content or encoding of a catalogue ends in anything but records, bad rows or one sentence."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest
from catalogue_files import SPELLINGS, as_xml, field
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from messages import oem, oem_in_xml
from seeds import over_examples
from spoilt_catalogues import PIECES, SEEDS, outcome, with_checksums

from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.ephemerides.oem import read_oem
from adr_opt.ui.serve.objects.recognise import recognised

pytest.importorskip("sgp4")


@st.composite
def spoilt(draw: st.DrawFn) -> bytes:
    """A file of any spelling with some pieces cut, doubled, or replaced."""
    data = draw(st.sampled_from(SEEDS))
    for _ in range(draw(st.integers(1, 4))):
        begin = draw(st.integers(0, len(data)))
        end = min(len(data), begin + draw(st.sampled_from([0, 1, 1, 2, 8, 70, 10_000])))
        piece = draw(
            st.one_of(st.sampled_from(PIECES), st.binary(max_size=4), st.just(data[begin:end] * 2))
        )
        data = data[:begin] + piece + data[end:]
    return data


@over_examples(
    spoilt(), st.booleans(), gate=200, full=600, suppress_health_check=[HealthCheck.too_slow]
)
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
                "MEAN_MOTION",
                "ECCENTRICITY",
                "INCLINATION",
                "RA_OF_ASC_NODE",
                "BSTAR",
                "ARG_OF_PERICENTER",
                "MEAN_ANOMALY",
                "MEAN_MOTION_DOT",
                "MEAN_MOTION_DDOT",
                "NORAD_CAT_ID",
                "EPHEMERIS_TYPE",
            ]
        ),
        NUMBER,
        min_size=1,
    )
)
@example({"MEAN_MOTION": "1e-9", "ECCENTRICITY": "0.0"})  # beyond all orbits that a file may have
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
    began = time.process_time()
    with pytest.raises(InputError, match="line 1: a tag or a comment longer than 1 MiB"):
        read_bytes(begin + b"a" * 30_000_000 + end, "file")
    assert time.process_time() - began < 5.0
    with pytest.raises(InputError, match="no element set"):
        read_bytes(begin + b"a" * 900_000 + end, "file")


RECORD = replace(field(1)[0], name="SATÉLITE Ñ")


def omm_text() -> str:
    return as_xml([RECORD])


def oem_text() -> str:
    text = oem("SATÉLITE Ñ", "2000-001A", RECORD.epoch, lambda times: [[7e6] * 6] * len(times))
    return oem_in_xml(text)


READERS = {
    "OMM": (omm_text, lambda data: read_bytes(data, "a.xml").records[0].name),
    "OEM": (oem_text, lambda data: read_oem(data, "a.xml")[0].names[0]),
}


@pytest.mark.parametrize("message", READERS)
@pytest.mark.parametrize(
    "encoding", ["UTF-8", "utf-8-sig", "ISO-8859-1", "iso-8859-15", "windows-1252", "UTF-16"]
)
def test_xml_is_read_in_its_encoding(message: str, encoding: str, tmp_path: Path) -> None:
    """Each reader of XML knows names by the encoding declared, and `serve` takes the file."""
    write, name_of = READERS[message]
    declared = encoding.removesuffix("-sig")
    body = write().partition("?>")[2]
    data = f'<?xml version="1.0" encoding="{declared}"?>{body}'.encode(encoding)
    assert name_of(data) == "SATÉLITE Ñ"
    path = tmp_path / "a.xml"
    path.write_bytes(data)
    assert recognised(path, "a.xml").count == 1


@pytest.mark.parametrize("message", READERS)
def test_other_encodings_are_one_sentence(message: str) -> None:
    """What is unknown, or of several bytes a character, is named; wrong bytes are not guessed."""
    write, name_of = READERS[message]
    body = write().partition("?>")[2]
    for encoding in ("klingon", "shift_jis", "hex"):
        data = f'<?xml version="1.0" encoding="{encoding}"?>{body}'.encode("ascii", "replace")
        with pytest.raises(InputError, match=f"in the encoding '{encoding}', which is unknown"):
            name_of(data)
    with pytest.raises(InputError, match="not well-formed"):
        name_of(f'<?xml version="1.0"?>{body}'.encode("latin-1"))
