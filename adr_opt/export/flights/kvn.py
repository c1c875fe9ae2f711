"""Common parts of CCSDS messages in key-value notation (CCSDS 502.0-B-2, section 7)."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime

from ...common.constants import EARTH_RADIUS_M, J2
from ...common.wording import printable
from ...fly.trajectory.axes import Axes
from ...fly.trajectory.clock import UtcClock
from ...plan.plan import Plan
from ...problem.instance import Instance

ORIGINATOR = "ADR-OPT"
OBJECT_NAME = "CHASER"
OBJECT_ID = "UNKNOWN"
"""Object identifier of a chaser, as it is in no catalogue."""

WIDTH = 100


def comment(text: str) -> Iterator[str]:
    """Lines of a comment."""
    for line in textwrap.wrap(printable(text), WIDTH):
        yield f"COMMENT {line}"


def origin(instance: Instance, plan: Plan, axes: Axes) -> list[str]:
    """Sentences on the source of a file and its accuracy."""
    said = [
        f"Plan by {plan.method} (seed {plan.seed}) for the instance {instance.name}, "
        f"sha256 {plan.instance.sha256}.",
        f"{_motion(instance)}, impulsive burns. At the end of a leg the chaser is docked; the step "
        f"there is the residual of the approach, {_residual(instance)}.",
        axes.said,
    ]
    if instance.is_approximate:
        said.append(
            "Some orbits are eccentric. The plan flies between circles of the same semi-major "
            "axes, and so do the states here; on the true orbits it misses"
            + (
                " by what adr-opt fly reports."
                if instance.dynamics == "two-body"
                else ", by an amount that has not been computed."
            )
        )
    return said


def _residual(instance: Instance) -> str:
    """Accuracy of planned states; an eccentric orbit's mean motion differs from its circle's.

    A safety ellipse lasts for revolutions, in which J2 and what is not linear add up.
    """
    if instance.transfer.approach == "safety-ellipse":
        return "up to some ten metres after a safety ellipse"
    if instance.dynamics == "j2" and instance.is_approximate:
        return "centimetres, or decimetres where orbits are eccentric"
    return "a few centimetres"


def _motion(instance: Instance) -> str:
    """The dynamics of the states, with their constants."""
    gravity = "GM = 398600.4418 km**3/s**2"
    if instance.dynamics == "two-body":
        return f"Two-body motion, {gravity}"
    return (
        f"Mean motion under J2 = {J2:.8e} ({gravity}, R = {EARTH_RADIUS_M / 1e3:.3f} km): nodes "
        "and latitudes advance at their secular rates; short-period variations, some kilometres, "
        "are left out, so these are not osculating states"
    )


def who(instance: Instance, chaser: str | None) -> list[str]:
    """A sentence naming the chaser, if there are several."""
    if chaser is None:
        return []
    return [f"The chaser is {chaser}, one of {len(instance.chasers)} of the instance."]


def object_name(chaser: str | None) -> str:
    """Object name of the chaser."""
    return OBJECT_NAME if chaser is None else printable(chaser)


def header(keyword: str, said: Iterable[str], version: str = "2.0") -> Iterator[str]:
    """Header of a message, with its comments."""
    yield f"{keyword} = {version}"
    for sentence in said:
        yield from comment(sentence)
    yield f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}"
    yield f"ORIGINATOR = {ORIGINATOR}"


def metadata(
    instance: Instance, axes: Axes, name: str = OBJECT_NAME, object_id: str | None = None
) -> Iterator[str]:
    """Metadata common to both messages: object, frame and time system."""
    yield f"OBJECT_NAME = {name}"
    yield f"OBJECT_ID = {object_id or OBJECT_ID}"
    yield "CENTER_NAME = EARTH"
    yield f"REF_FRAME = {axes.frame.name}"
    if axes.frame.axes_epoch is not None:
        since_s = (axes.frame.axes_epoch - instance.epoch).total_seconds()
        yield f"REF_FRAME_EPOCH = {UtcClock(instance).label(since_s)}"
    yield "TIME_SYSTEM = UTC"
