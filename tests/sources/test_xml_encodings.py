"""XML in the encoding that it declares."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from catalogue_files import as_xml, field
from messages import oem, oem_in_xml

from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.ephemerides.oem import read_oem
from adr_opt.ui.serve.objects.recognise import recognised

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
