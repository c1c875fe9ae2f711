"""Coverage of messages: spans with states, within the usable times that they state.

A segment covers what is in all of START_TIME to STOP_TIME, USEABLE_START_TIME to USEABLE_STOP_TIME
and its states, without the holes among these (CCSDS 502.0-B, section 5.2).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...common.errors import InputError
from .ephemeris import Array
from .interpolation import points_of
from .message_times import seconds_since
from .oem_segment import MessageSegment

CLOSE_S = 1e-6
"""Times closer than this to the end of a span are within it: labels have microseconds [s]."""

LEAST_STEPS = 2.0
"""Number of usual steps that are not yet a gap, whatever the degree: a single state is missing."""

STEPS_PER_STATE = 0.5
"""Further steps allowed per state of the polynomial: half of its states may be missing."""

JITTER = 1.001
"""Steps are rounded to the digits of their labels."""


class Span(NamedTuple):
    """A span that a segment covers without a gap.

    Attributes
    ----------
    begin, end : float
        Since the epoch of the instance [s].
    segment : MessageSegment
    knots : (states,) float64
        Times of the states between two holes, which may reach beyond the span [s].
    states : (states, 6) float64
        [m, m/s].
    lines : (int, int)
        Where the first and the last of them stand in the file.
    """

    begin: float
    end: float
    segment: MessageSegment
    knots: Array
    states: Array
    lines: tuple[int, int]


class Coverage:
    """The spans of a body's messages.

    Parameters
    ----------
    body : str
    segments : sequence of MessageSegment
        All of the body, at least one.
    epoch : datetime
        Of the instance.

    Attributes
    ----------
    spans : tuple of Span
        In the order of their beginnings.

    Raises
    ------
    InputError
        A time or a state cannot be read, or two ephemerides are of one time.
    """

    def __init__(self, body: str, segments: Sequence[MessageSegment], epoch: datetime) -> None:
        self._body, self._epoch, self._first = body, epoch, segments[0]
        self.spans = tuple(sorted(_spans(segments, epoch), key=lambda span: span[:2]))
        for before, after in zip(self.spans, self.spans[1:], strict=False):
            if after.begin < before.end - CLOSE_S:
                raise InputError(
                    f"{after.segment.where}: {body!r} has two ephemerides at one time, the other "
                    f"in {before.segment.source}, line {before.segment.line}; give one of them"
                )

    def check(self, begin_s: float, end_s: float) -> None:
        """Raise :class:`InputError` unless a time is covered without a gap."""
        reached = begin_s
        for span in self.spans:
            if span.begin <= reached + CLOSE_S:
                reached = max(reached, span.end)
        if reached < end_s - CLOSE_S:
            raise self.uncovered(reached + (0.0 if reached == begin_s else CLOSE_S))

    def within(self, times_s: Array) -> Iterator[tuple[Span, npt.NDArray[np.bool_]]]:
        """Spans, and which of some times are in each.

        Raises
        ------
        InputError
            A time is in none.
        """
        missing = np.ones(times_s.size, dtype=np.bool_)
        for span in self.spans:
            inside = (times_s >= span.begin - CLOSE_S) & (times_s <= span.end + CLOSE_S)
            if inside.any():
                missing &= ~inside
                yield span, inside
        if missing.any():
            raise self.uncovered(float(times_s[missing][0]))

    def uncovered(self, time_s: float) -> InputError:
        """A sentence about an uncovered time: the gap around it, and its place in the files."""
        before = [span for span in self.spans if span.end < time_s]
        after = [span for span in self.spans if span.begin > time_s]
        where, said = self._first.where, "within the times that its metadata state"
        if before:
            last = max(before, key=lambda span: span.end)
            where, said = last.segment.at(last.lines[1]), f"after {self._label(last.end)}"
        if after:
            where = after[0].segment.at(after[0].lines[0])
            till = self._label(after[0].begin)
            said = f"from {said.removeprefix('after ')} to {till}" if before else f"before {till}"
        if before and after and last.segment is after[0].segment:
            step = float(np.median(np.diff(last.knots)))
            hole = after[0].begin - last.end
            said += f", a gap of {hole:.6g} s among states {step:.6g} s apart"
        return InputError(
            f"{where}: no state of {self._body!r} {said}; give an ephemeris of the whole mission"
        )

    def _label(self, time_s: float) -> str:
        time = (self._epoch + timedelta(seconds=time_s)).astimezone(UTC)
        return f"{time:%Y-%m-%dT%H:%M:%S.%f}".rstrip("0").rstrip(".") + "Z"


def _spans(segments: Iterable[MessageSegment], epoch: datetime) -> Iterator[Span]:
    for segment in segments:
        system = segment.says("TIME_SYSTEM", "")
        bounds = [
            [
                segment.fields[key]
                for key in (f"{end}_TIME", f"USEABLE_{end}_TIME")
                if segment.fields.get(key)
            ]
            for end in ("START", "STOP")
        ]
        earliest, latest = (seconds_since(epoch, one, system, segment.where) for one in bounds)
        labels, states = segment.states()
        knots = seconds_since(epoch, labels, system, segment.where)
        if not (np.diff(knots) > 0.0).all():
            raise InputError(f"{segment.where}: its times do not increase")
        cuts = np.append(holes(knots, states, *segment.method) + 1, knots.size)
        for first, stop in zip([0, *cuts], cuts, strict=False):
            begin = max(float(earliest.max()), float(knots[first]))
            end = min(float(latest.min()), float(knots[stop - 1]))
            # A state between two holes is of one moment.
            if stop - first > 1 and begin <= end:
                part = slice(first, stop)
                lines = segment.row_lines[first], segment.row_lines[stop - 1]
                yield Span(begin, end, segment, knots[part], states[part], lines)


def holes(knots: Array, states: Array, method: str, degree: int) -> npt.NDArray[np.intp]:
    """Numbers of the states before gaps.

    There a step is longer than those around it by more than the polynomial of the degree can make
    up for, or as long as half a revolution, which no polynomial knows of.

    Parameters
    ----------
    knots : (states,) float64
        Times, rising [s].
    states : (states, 6) float64
        [m, m/s].
    method : {"LAGRANGE", "HERMITE", "LINEAR"}
    degree : int
    """
    steps, count = np.diff(knots), points_of(method, degree)
    most = JITTER * max(LEAST_STEPS, STEPS_PER_STATE * count)
    radius, speed = (np.linalg.norm(part, axis=1) for part in (states[:, :3], states[:, 3:]))
    with np.errstate(divide="ignore", invalid="ignore"):
        axis = 1.0 / np.maximum(2.0 / radius - speed**2 / MU_M3_S2, 0.0)
        half_turn = np.pi * np.sqrt(axis**3 / MU_M3_S2)
    too_long = steps >= np.minimum(half_turn[:-1], half_turn[1:])
    for at in np.flatnonzero(steps > most * steps.min()):
        around = np.concatenate((steps[max(0, at - count) : at], steps[at + 1 : at + 1 + count]))
        too_long[at] |= steps[at] > most * np.median(around)
    return np.flatnonzero(too_long)
