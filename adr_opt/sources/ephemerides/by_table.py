"""Ephemerides interpolated between the states of messages."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.frame import FRAMES, Frame
from ...problem.frame_rotation import rotation
from ..catalogue.records import shown
from .ephemeris import Array
from .interpolation import interpolated
from .message_times import seconds_since
from .oem_segment import MessageSegment
from .turning import TurningAxes

SYNONYMS = {"J2000": "EME2000", "TEMEOFDATE": "TEME", "TEMEOFEPOCH": "TEME"}
"""Names of frames beside those of :data:`adr_opt.problem.frame.FRAMES`."""

CLOSE_S = 1e-6
"""Times closer than this to the end of an ephemeris are within it: labels have microseconds [s]."""


class Span(NamedTuple):
    """A segment with its useable time [s]."""

    begin: float
    end: float
    segment: MessageSegment


class ParsedSegment(NamedTuple):
    """A parsed segment: times [s], states [m, m/s], and how they are turned."""

    knots: Array
    states: Array
    is_of_date: bool
    matrix: Array | None


class ByTable:
    """States of a body interpolated as its messages say.

    States are interpolated in the frame of the message and then turned. A segment is parsed when a
    time within it is asked for first.

    Parameters
    ----------
    body : str
        Name of the body.
    segments : sequence of MessageSegment
        All of the body.
    epoch : datetime
        Of the instance.
    frame : Frame
        Of the instance.
    axes : TurningAxes
        Into that frame.

    Raises
    ------
    InputError
        A frame or time system that is not understood, or two ephemerides of one time.
    """

    def __init__(
        self, body: str, segments: Sequence[MessageSegment], epoch: datetime, frame: Frame,
        axes: TurningAxes,
    ) -> None:  # fmt: skip
        self.body, self._epoch, self._frame, self._axes = body, epoch, frame, axes
        self._spans = sorted((_span(one, epoch) for one in segments), key=lambda span: span[:2])
        self._tables: dict[int, ParsedSegment] = {}
        for before, after in zip(self._spans, self._spans[1:], strict=False):
            if after.begin < before.end - CLOSE_S:
                raise InputError(
                    f"{after.segment.where}: {body!r} has two ephemerides of one time, the other "
                    f"in {before.segment.source}, line {before.segment.line}; give one of them"
                )
        for span in self._spans:
            frame_of(span.segment, epoch)
            _ = span.segment.method

    def check_covered(self, begin_s: float, end_s: float) -> None:
        """Raise :class:`InputError` unless the ephemeris covers a time without a gap."""
        reached = begin_s
        for span in self._spans:
            if span.begin <= reached + CLOSE_S:
                reached = max(reached, span.end)
        if reached < end_s - CLOSE_S:
            raise self._uncovered(reached + (0.0 if reached == begin_s else CLOSE_S))

    def state(self, times_s: npt.ArrayLike) -> Array:
        """As of :class:`.ephemeris.Ephemeris`."""
        times = np.asarray(times_s, dtype=np.float64)
        flat = times.ravel()
        found = np.full((flat.size, 6), np.nan)
        for number, span in enumerate(self._spans):
            within = (flat >= span.begin - CLOSE_S) & (flat <= span.end + CLOSE_S)
            if within.any():
                found[within] = self._within(number, flat[within])
        missing = np.flatnonzero(np.isnan(found[:, 0]))
        if missing.size:
            raise self._uncovered(float(flat[missing[0]]))
        shaped: Array = found.reshape(*times.shape, 6)
        return shaped

    def _within(self, number: int, times: Array) -> Array:
        segment = self._spans[number].segment
        if number not in self._tables:
            self._tables[number] = self._table(segment)
        table = self._tables[number]
        clipped = np.clip(times, table.knots[0], table.knots[-1])
        found = interpolated(table.knots, table.states, clipped, *segment.method)
        if table.is_of_date:
            return self._axes.turned(found, clipped)
        if table.matrix is None:
            return found
        turned: Array = (found.reshape(-1, 2, 3) @ table.matrix.T).reshape(-1, 6)
        return turned

    def _table(self, segment: MessageSegment) -> ParsedSegment:
        labels, states = segment.states()
        system = segment.says("TIME_SYSTEM", "")
        knots = seconds_since(self._epoch, labels, system, segment.where)
        if not (np.diff(knots) > 0.0).all():
            raise InputError(f"{segment.where}: its times do not rise")
        own = frame_of(segment, self._epoch)
        matrix = None if own is None else rotation(own, self._frame)
        return ParsedSegment(knots, states, own is None, matrix)

    def _uncovered(self, time_s: float) -> InputError:
        spans = ", ".join(
            f"{span.begin / DAY_S:.6g} to {span.end / DAY_S:.6g}" for span in self._spans[:3]
        )
        more = ", …" if len(self._spans) > 3 else ""
        return InputError(
            f"{self._spans[0].segment.source}: no state of {self.body!r} {time_s / DAY_S:.6g} days "
            f"after the epoch (it covers {spans}{more}); give an ephemeris of the whole mission"
        )


def _span(segment: MessageSegment, epoch: datetime) -> Span:
    labels = [
        segment.fields.get(f"USEABLE_{end}_TIME") or segment.fields[f"{end}_TIME"]
        for end in ("START", "STOP")
    ]
    begin, end = seconds_since(epoch, labels, segment.says("TIME_SYSTEM", ""), segment.where)
    return Span(float(begin), float(end), segment)


def frame_of(segment: MessageSegment, epoch: datetime) -> Frame | None:
    """Fixed frame of a segment, at an epoch of the instance; None for TEME of date.

    Raises
    ------
    InputError
        Another frame or centre.
    """
    said = segment.says("REF_FRAME", "")
    name = SYNONYMS.get(said.replace(" ", ""), said)
    of_epoch = segment.fields.get("REF_FRAME_EPOCH")
    if segment.says("CENTER_NAME", "") != "EARTH":
        raise InputError(
            f"{segment.where}: CENTER_NAME = {shown(segment.fields['CENTER_NAME'])}: must be EARTH"
        )
    for known in FRAMES:
        if name != known:
            continue
        if known != "TEME":
            return Frame(name=known)
        if of_epoch is None:
            return None
        since = seconds_since(epoch, [of_epoch], segment.says("TIME_SYSTEM", ""), segment.where)
        at = datetime.fromtimestamp(epoch.timestamp() + float(since[0]), tz=UTC)
        return Frame(name=known, axes_epoch=at)
    raise InputError(
        f"{segment.where}: REF_FRAME = {shown(segment.fields['REF_FRAME'])}: must be one of "
        f"{', '.join(FRAMES)}"
    )
