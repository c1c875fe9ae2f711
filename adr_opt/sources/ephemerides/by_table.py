"""Ephemerides interpolated between the states of messages."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...problem.frame import FRAMES, Frame
from ...problem.frame_rotation import rotation
from ..catalogue.records import shown
from .coverage import Coverage, Span
from .ephemeris import Array, TurningAxes
from .interpolation import interpolated
from .message_times import seconds_since
from .oem_segment import MessageSegment

SYNONYMS = {"J2000": "EME2000", "TEMEOFDATE": "TEME", "TEMEOFEPOCH": "TEME"}
"""Names of frames beside those of :data:`adr_opt.problem.frame.FRAMES`."""


class ByTable:
    """States of a body, interpolated by the method that its messages state.

    States are interpolated in the frame of the message and then turned.

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
        A frame or time system that is not understood, a bad state, or two ephemerides of one time.
    """

    def __init__(
        self,
        body: str,
        segments: Sequence[MessageSegment],
        epoch: datetime,
        frame: Frame,
        axes: TurningAxes,
    ) -> None:
        self.body, self._epoch, self._frame, self._axes = body, epoch, frame, axes
        self._frames = {id(segment): frame_of(segment, epoch) for segment in segments}
        self._coverage = Coverage(body, segments, epoch)

    def check_covered(self, begin_s: float, end_s: float) -> None:
        """Raise :class:`InputError` unless the ephemeris covers a time without a gap."""
        self._coverage.check(begin_s, end_s)

    def state(self, times_s: npt.ArrayLike) -> Array:
        """States at times, as in :class:`.ephemeris.Ephemeris`."""
        times = np.asarray(times_s, dtype=np.float64)
        flat = times.ravel()
        found = np.empty((flat.size, 6))
        for span, inside in self._coverage.within(flat):
            found[inside] = self._within(span, flat[inside])
        shaped: Array = found.reshape(*times.shape, 6)
        return shaped

    def _within(self, span: Span, times: Array) -> Array:
        clipped = np.clip(times, span.knots[0], span.knots[-1])
        found = interpolated(span.knots, span.states, clipped, *span.segment.method)
        own = self._frames[id(span.segment)]
        if own is None:
            return self._axes.turned(found, clipped)
        matrix = rotation(own, self._frame)
        if matrix is None:
            return found
        turned: Array = (found.reshape(-1, 2, 3) @ matrix.T).reshape(-1, 6)
        return turned


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
