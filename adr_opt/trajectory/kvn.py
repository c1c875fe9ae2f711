"""What CCSDS messages in key-value notation have in common (CCSDS 502.0-B-2, section 7)."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from datetime import UTC, datetime

from ..instance import Instance
from ..plan import Plan

ORIGINATOR = "ADR-OPT"
OBJECT_NAME = "CHASER"
OBJECT_ID = "UNKNOWN"
"""The chaser is in no catalogue of launched objects."""

WIDTH = 100


def plain(text: str) -> str:
    """Text as a message may hold it: printable ASCII, one line."""
    return "".join(sign if " " <= sign <= "~" else "?" for sign in text)


def comment(text: str) -> Iterator[str]:
    """Lines of a comment."""
    for line in textwrap.wrap(plain(text), WIDTH):
        yield f"COMMENT {line}"


def origin(instance: Instance, plan: Plan) -> list[str]:
    """Sentences that say what a file was made from and how far it can be trusted."""
    said = [
        f"Plan by {plan.method} (seed {plan.seed}) for the instance {instance.name}, "
        f"sha256 {plan.instance.sha256}.",
        "Two-body motion, GM = 398600.4418 km**3/s**2, impulsive burns. At the end of a leg the "
        "chaser is docked; the step there is the residual of the approach, a few centimetres.",
        "The reference frame is named by whoever exports: an instance says only that its elements "
        "are inertial.",
    ]
    if instance.is_approximate:
        said.append(
            "Some orbits are eccentric. The plan flies between circles of the same semi-major "
            "axes, and so do the states here; on the true orbits it misses by what adr-opt fly "
            "reports."
        )
    return said


def header(keyword: str, instance: Instance, plan: Plan) -> Iterator[str]:
    """The header of a message of version 2.0."""
    yield f"{keyword} = 2.0"
    for sentence in origin(instance, plan):
        yield from comment(sentence)
    yield f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}"
    yield f"ORIGINATOR = {ORIGINATOR}"


def metadata(frame: str) -> Iterator[str]:
    """What both messages say of the object, the frame and the time system."""
    yield f"OBJECT_NAME = {OBJECT_NAME}"
    yield f"OBJECT_ID = {OBJECT_ID}"
    yield "CENTER_NAME = EARTH"
    yield f"REF_FRAME = {frame}"
    yield "TIME_SYSTEM = UTC"
