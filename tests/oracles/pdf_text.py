"""The text of a PDF file that Chromium has printed: one stream a page, and fonts that map back."""

from __future__ import annotations

import re
import unicodedata
import zlib


def pdf_text(pdf: bytes) -> str:
    """All pages in the order in which they are painted, without white space and ligatures."""
    objects = dict(re.findall(rb"(\d+) 0 obj\s*(.*?)endobj", pdf, re.DOTALL))

    def read(place: bytes, of: bytes) -> str:
        """The stream that an object refers to."""
        (number,) = re.findall(place + rb" (\d+) 0 R", of)
        stream = objects[number].split(b"stream", 1)[1].lstrip()
        return zlib.decompressobj().decompress(stream).decode("latin-1")

    def letters(font: bytes) -> dict[int, str]:
        """Letters of a font by its numbers of them."""
        rows = re.findall(r"<(\w{4})> (?:<(\w{4})> )?<(\w{4})>\n", read(b"/ToUnicode", font))
        return {
            at: chr(int(letter, 16) + at - int(first, 16))
            for first, last, letter in rows
            for at in range(int(first, 16), int(last or first, 16) + 1)
        }

    said = ""
    for page in objects.values():
        if page.startswith(b"<</Type /Page\n"):
            used = re.findall(rb"/(F\d+) (\d+) 0 R", page)
            fonts = {name.decode(): letters(objects[number]) for name, number in used}
            font: dict[int, str] = {}
            drawn = re.findall(r"/(F\d+) [\d.]+ Tf|<(\w+)> Tj", read(b"/Contents", page))
            for name, numbers in drawn:
                font = fonts[name] if name else font
                said += "".join(font[int(each, 16)] for each in re.findall("....", numbers))
    return "".join(unicodedata.normalize("NFKC", said).split())
