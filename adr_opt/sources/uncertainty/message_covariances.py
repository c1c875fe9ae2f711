"""Covariances in CCSDS Orbit Ephemeris Messages (502.0-B, section 5.2.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta
from typing import NamedTuple

import numpy as np

from ...common.errors import InputError
from ...problem.frame import Frame
from ...problem.frame_rotation import rotation
from ...problem.instance import Instance
from ..catalogue.records import shown
from ..ephemerides.by_table import frame_of
from ..ephemerides.message_times import seconds_since
from ..ephemerides.oem import read_oem
from ..ephemerides.oem_segment import MessageSegment
from ..ephemerides.of_instance import by_body
from .target_error import Array, TargetError

OWN_AXES = ("RTN", "RSW")
"""Names of the axes outward, along-track and cross-track."""


class StatedCovariance(NamedTuple):
    """A covariance as a message states it.

    Attributes
    ----------
    epoch : str
        Its time.
    frame : str
        Name of its axes; empty for those of the states.
    matrix : (6, 6) float64
        [m², m²/s, m²/s²].
    """

    epoch: str
    frame: str
    matrix: Array


def of_message(instance: Instance, text: str, source: str) -> dict[str, TargetError]:
    """Errors of an instance's bodies: for each, the latest covariance up to the epoch.

    Where all are of later than the epoch, the first of them.

    Raises
    ------
    InputError
        The message is bad, or has no covariance of a body, or one in axes that are not understood.
    """
    listed = {station.name: station.object_id for station in instance.stations}
    listed |= {target.name: target.object_id for target in instance.targets}
    found = {}
    for body, segments in by_body(read_oem(text.encode(), source), listed).items():
        stated = [
            (_since(instance, segment, one), segment, one)
            for segment in segments
            for one in _covariances(segment)
        ]
        if stated:
            before = [one for one in stated if one[0] <= 0.0]
            by_time = sorted(before or stated, key=lambda one: one[0])
            found[body] = _error(instance, *by_time[-1 if before else 0])
    if not found:
        raise InputError(f"{source}: no covariance of a body of {instance.name!r}; give a table")
    return found


def _since(instance: Instance, segment: MessageSegment, one: StatedCovariance) -> float:
    system = segment.says("TIME_SYSTEM", "")
    return float(seconds_since(instance.epoch, [one.epoch], system, segment.where)[0])


def _error(
    instance: Instance, since_s: float, segment: MessageSegment, one: StatedCovariance
) -> TargetError:
    covariance = np.zeros((7, 7))
    covariance[:6, :6] = one.matrix
    where = f"{segment.where}: covariance of {one.epoch}"
    try:
        if one.frame in OWN_AXES:
            return TargetError(covariance, "rtn", since_s)
        said = replace(segment, fields=segment.fields | {"REF_FRAME": one.frame})
        own = frame_of(said if one.frame else segment, instance.epoch)
        if own is None:  # TEME of date
            date = instance.epoch + timedelta(seconds=since_s)
            own = Frame(name="TEME", axes_epoch=date)
        if instance.frame is None:
            raise InputError("it is inertial, but the instance names no frame; give it one")
        turn = rotation(own, instance.frame)
        if turn is not None:
            both = np.kron(np.eye(2), turn)
            covariance[:6, :6] = both @ one.matrix @ both.T
        return TargetError(covariance, "inertial", since_s)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _covariances(segment: MessageSegment) -> Iterator[StatedCovariance]:
    """The covariances of a segment."""
    epoch = frame = ""
    rows: list[list[float]] = []
    for line in segment.covariance_rows:
        keyword, is_field, value = line.partition("=")
        if is_field and rows:
            raise InputError(
                f"{segment.where}: a covariance has {len(rows)} rows; it must have six"
            )
        if is_field and keyword.strip() == "EPOCH":
            epoch, frame = value.strip(), ""
        elif is_field and keyword.strip() == "COV_REF_FRAME":
            frame = value.strip().upper()
        elif is_field:
            raise InputError(f"{segment.where}: {shown(keyword.strip())} is no covariance keyword")
        else:
            rows.append(_row(segment, line, len(rows) + 1))
        if len(rows) == 6:
            if not epoch:
                raise InputError(f"{segment.where}: a covariance has no EPOCH")
            matrix = np.zeros((6, 6))
            for at, row in enumerate(rows):
                matrix[at, : at + 1] = matrix[: at + 1, at] = row
            yield StatedCovariance(epoch, frame, 1e6 * matrix)
            epoch, rows = "", []
    if rows:
        raise InputError(f"{segment.where}: a covariance has {len(rows)} rows; it must have six")


def _row(segment: MessageSegment, line: str, count: int) -> list[float]:
    try:
        row = [float(part) for part in line.split()]
    except ValueError:
        row = []
    if len(row) != count or not np.isfinite(row).all():
        raise InputError(
            f"{segment.where}: {shown(line)!r} is not a row of {count} numbers of a covariance"
        )
    return row
