"""Approaches as conjunction data messages (CCSDS 508.0-B-1) in key-value notation."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime

import numpy as np

from ...common.errors import InputError
from ...common.wording import printable
from ...problem.frame_rotation import teme_axes
from .approaches import CloseApproach
from .position_errors import PositionErrors, errors_of

_AXES = ("R", "T", "N", "RDOT", "TDOT", "NDOT")

_SAID = (
    "Relative states are in the axes R, T, N of OBJECT1, which a chaser of a plan is. States are "
    "those of the plan and of SGP4; covariances of positions were given, those of velocities are "
    "not known and stand as 0."
)


def conjunction_message(approach: CloseApproach, errors: Mapping[str, PositionErrors]) -> str:
    """The message of an approach.

    Parameters
    ----------
    approach : CloseApproach
    errors : dict of str to PositionErrors
        As :func:`.screen` takes them: the format asks for covariances.

    Raises
    ------
    InputError
        The errors of one of both are not known.
    MissingExtra
        astropy is not installed.
    """
    names = {"chaser": (approach.chaser,), "object": (approach.object, approach.object_id)}
    known = {}
    for role, of_it in names.items():
        found = errors_of(errors, *of_it)
        if found is None:
            raise InputError(f"{of_it[0]!r}: its errors are unknown, but a message must state them")
        known[role] = found
    return "\n".join(_lines(approach, known)) + "\n"


def _lines(approach: CloseApproach, known: Mapping[str, PositionErrors]) -> Iterator[str]:
    yield "CCSDS_CDM_VERS = 1.0"
    yield f"COMMENT {_SAID}"
    yield f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}"
    yield "ORIGINATOR = ADR-OPT"
    yield f"MESSAGE_ID = {printable(approach.chaser)}-{approach.leg}-{approach.time_s:.3f}"
    yield f"TCA = {approach.epoch.removesuffix('Z')}"
    yield f"MISS_DISTANCE = {approach.miss_m:.3f} [m]"
    yield f"RELATIVE_SPEED = {approach.speed_m_s:.6f} [m/s]"
    parts_m = approach.radial_m, approach.along_m, approach.cross_m
    for axis, value in zip("RTN", parts_m, strict=True):
        yield f"RELATIVE_POSITION_{axis} = {value:.3f} [m]"
    if approach.probability is not None:
        yield f"COLLISION_PROBABILITY = {approach.probability:.6E}"
        yield "COLLISION_PROBABILITY_METHOD = FOSTER-1992"
    (matrix,) = teme_axes([datetime.fromisoformat(approach.epoch)])
    about = {"chaser": (approach.chaser, None), "object": (approach.object, approach.object_id)}
    for number, (role, (name, object_id)) in enumerate(about.items(), start=1):
        yield f"OBJECT = OBJECT{number}"
        yield f"OBJECT_DESIGNATOR = {printable(object_id or name)}"
        yield "CATALOG_NAME = NONE"
        yield f"OBJECT_NAME = {printable(name)}"
        yield f"INTERNATIONAL_DESIGNATOR = {object_id or 'UNKNOWN'}"
        yield "EPHEMERIS_NAME = NONE"
        yield "COVARIANCE_METHOD = DEFAULT"
        yield f"MANEUVERABLE = {'YES' if role == 'chaser' else 'N/A'}"
        yield "REF_FRAME = GCRF"
        state = 1e-3 * (np.array(approach.states[number - 1]).reshape(2, 3) @ matrix).ravel()
        for axis, value, unit in zip(
            ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"),
            state,
            3 * ["km"] + 3 * ["km/s"],
            strict=True,
        ):
            yield f"{axis} = {value:.9f} [{unit}]"
        yield from _covariance(known[role])


def _covariance(known: PositionErrors) -> Iterator[str]:
    for row, column in itertools.product(range(6), repeat=2):
        if column <= row:
            value = known.covariance_m2[row, column] if row < 3 else 0.0
            unit = "m**2" + ("/s" * (row > 2) if column < 3 else "/s**2")
            yield f"C{_AXES[row]}_{_AXES[column]} = {value:.9E} [{unit}]"
