"""Reading of pseudo-terminals that other programs write to."""

import os
from collections.abc import Iterator


def parts(terminal: int) -> Iterator[bytes]:
    """Everything that is written, part by part, until the other end is closed."""
    try:
        while part := os.read(terminal, 4096):
            yield part
    except OSError:  # Linux says EIO when the other end is closed
        pass


def read_until(terminal: int, wanted: bytes = b"\0") -> bytes:
    """Everything that is written until something appears, or until the other end is closed."""
    said = b""
    for part in parts(terminal):
        said += part
        if wanted in said:
            break
    return said
