"""A synthetic catalogue as a TLE file, for tests of ``serve``."""

from __future__ import annotations

import random


def catalogue(objects: int, seed: int = 0) -> bytes:
    """Element sets of objects in low orbits, in groups of similar planes.

    Parameters
    ----------
    objects : int
        At most 80,000.
    seed : int
    """
    drawn = random.Random(seed)
    lines = []
    for at in range(objects):
        number, name = 10_000 + at, f"PIECE {at} DEB" if at % 3 else f"STAGE {at} R/B"
        first = (
            f"1 {number:05d}U 20001A   26001.{drawn.randrange(10**8):08d}  .00000100  00000-0"
            f"  10000-4 0  999"
        )
        second = (
            f"2 {number:05d} {98.0 + 0.2 * drawn.random():8.4f} {20.0 * (at % 18):8.4f} "
            f"{drawn.randrange(5_000):07d} {drawn.uniform(0, 359):8.4f} "
            f"{drawn.uniform(0, 359):8.4f} {drawn.uniform(14.1, 14.4):11.8f}{1:5d}"
        )
        lines += [name, *(line + _check_digit(line) for line in (first, second))]
    return "\n".join(lines).encode() + b"\n"


def _check_digit(line: str) -> str:
    return str(sum(int(each) if each.isdigit() else each == "-" for each in line) % 10)
