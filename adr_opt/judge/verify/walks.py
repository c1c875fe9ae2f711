"""Check of a chaser's walks against a claim, from multipliers and neighbourhoods.

*Walks* are what plans are relaxed to. A walk keeps to all rules of its chaser but one: it may come
back to a target that it has forgotten. When it goes from a body i to a body j it goes on
remembering those targets that stand in the neighbourhood of j, and i if that is a target. So every
plan is a walk, whatever the neighbourhoods, and what holds for walks holds for plans.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from .ahead import Ahead, look_ahead
from .cargo import after_service
from .cuts import NumberedCut, tolls_of
from .labels import FINE, FOUND, FULL, WORD, KeptLabels, Price, Question, WalkLabels, search
from .legs import Legs, Loss, lost_by, lost_on

Array = npt.NDArray[Any]

FIRST_LABELS, FIRST_KEPT = 1 << 18, 1 << 9
"""Initial capacities: for labels, and for labels kept at each body."""


class Paying(NamedTuple):
    """What walks that pay for ΔV pay besides, and are to be worth.

    Attributes
    ----------
    per_s : float
        What they pay for a second until they end [m/s].
    worths : sequence of Fraction
        Of the service of each body; nothing where it does not matter.
    least : Fraction
        What they are to be worth together.
    """

    per_s: float
    worths: Sequence[Fraction] = ()
    least: Fraction = Fraction(0)


class WalkAnswer(NamedTuple):
    """The answer.

    Attributes
    ----------
    reached : bool
        Whether there is a walk that collects as much.
    labels : int
        How many it took to know.
    """

    reached: bool
    labels: int


def walks_reach(
    legs: Legs,
    gains: Sequence[Fraction],
    neighbourhoods: npt.NDArray[np.bool_],
    most: Fraction,
    slot_m_s: float,
    cuts: tuple[NumberedCut, ...] = (),
    paying: Paying | None = None,
    losses: Sequence[Loss] = (),
) -> WalkAnswer:
    """Check whether a walk collects ``most``.

    Parameters
    ----------
    legs : Legs
    gains : sequence of Fraction
        What the service of each body is worth, less its multiplier.
    neighbourhoods : (bodies, bodies) bool
        Whether a walk that comes to a body (row) still remembers another one (column).
    most : Fraction
    slot_m_s : float
        In which ΔV is counted where labels look ahead: how many there are depends on it, and
        nothing else [m/s].
    cuts : tuple of NumberedCut
        What walks pay for at their second services.
    paying : Paying, optional
        Walks pay for ΔV, and count only if they are worth as much; gains are in m/s then.
    losses : sequence of Loss
        Of gains, where prizes fall; none is known to walks that pay, which may collect more then.
    """
    ahead = look_ahead(legs, gains, slot_m_s, 0.0 if paying is None else 1.0)
    # Exact sums: what is worth something is worth no less in units, and what is asked for no more.
    unit = Fraction(ahead.unit) / (1 << FINE)
    worth = [max(math.ceil(gain / unit), -(2**58)) for gain in gains]
    need = min(max(math.floor(most / unit), -(2**60)), 2**60)
    of_bodies = (len(gains) - 1) // WORD + 1
    remembered = np.zeros((len(gains), of_bodies), dtype=np.int64)
    for i, j in np.argwhere(neighbourhoods):
        remembered[i, j // WORD] |= 1 << (j % WORD)
    tolls = tolls_of(cuts, len(gains), unit)
    price = _price(legs, ahead, unit, slot_m_s, paying)
    lost = lost_on(legs, losses, unit)
    question = Question(np.array(worth), need, remembered, tolls, price, lost)
    words = of_bodies, tolls.rows.shape[1]
    labels = _labels_room(FIRST_LABELS, words, ahead.last.size)
    kept = _kept_room(len(gains) * legs.terms.cargo.full.size, words, FIRST_KEPT)
    launched = [
        gain - lost_by(losses, body, float(legs.terms.ready[body]), unit)
        for body, gain in enumerate(worth)
    ]
    cursor = _begin(legs, ahead.last, question, launched, labels)
    ready = np.empty(FIRST_LABELS, dtype=np.int64)
    while True:
        state = search(legs, ahead, question, labels, kept, cursor, ready)
        if state != FULL:
            return WalkAnswer(state == FOUND, int(cursor[1]))
        if cursor[1] == labels.body.size:
            more = _labels_room(2 * labels.body.size, words, ahead.last.size)
            arrays: Iterable[tuple[Array, Array]] = zip(more, labels, strict=True)
            for new, old in arrays:
                new[: old.shape[0]] = old
            labels, ready = more, np.append(ready, ready)
        else:
            wider = _kept_room(kept.size.size, words, 2 * kept.left.shape[1])
            wider.size[:] = kept.size
            arrays = zip(wider[1:], kept[1:], strict=True)
            for new, old in arrays:
                new[..., : old.shape[-1]] = old
            kept = wider


def _price(
    legs: Legs, ahead: Ahead, unit: Fraction, slot_m_s: float, paying: Paying | None
) -> Price:
    """What walks pay for ΔV; nothing if they do not."""
    if paying is None:
        return Price(False, 0.0, 0.0, 0.0, np.zeros(0, dtype=np.int64), 0, ahead)
    per_m_s, since = float(1 / unit), legs.terms.begin
    worth, least, reach = np.zeros(legs.terms.bodies, dtype=np.int64), 0, ahead
    if paying.worths:
        reach = look_ahead(legs, paying.worths, slot_m_s)
        size = Fraction(reach.unit) / (1 << FINE)
        worth[:] = [math.ceil(each / size) for each in paying.worths]
        least = math.floor(paying.least / size)
    return Price(True, per_m_s, per_m_s * paying.per_s, since, worth, least, reach)


def _begin(
    legs: Legs,
    last: npt.NDArray[np.float64],
    question: Question,
    launched: Sequence[int],
    labels: WalkLabels,
) -> npt.NDArray[np.int64]:
    """The first labels, and the cursor of the search.

    A launch onto a target has what it is worth by then.
    Of kits that weigh something there are as many aboard as will be left behind, be it any number.
    """
    cargo, at = legs.terms.cargo, 0
    most_kits = cargo.full.size - 1
    for body in legs.terms.starts.tolist():
        is_launch = body != legs.terms.home
        takes = int(cargo.takes[body]) if is_launch else 0
        for kits in range(takes if cargo.heavy else most_kits, most_kits + 1):
            left = float(legs.terms.begun[kits])
            if is_launch:  # who is launched onto a target has serviced it by then
                left = float(after_service(cargo, body, kits, left)) if kits >= takes else -1.0
            if left < 0.0:
                continue
            labels.body[at], labels.came_from[at] = body, -1
            labels.time[at], labels.left[at] = legs.terms.ready[body], left
            labels.kits[at] = kits - takes
            labels.counts[at] = legs.terms.counting.adds[body] if is_launch else 0
            labels.value[at] = launched[body] if is_launch else 0
            pays = question.price.pays and is_launch
            labels.worth[at] = question.price.worth[body] if pays else 0
            labels.memory[at], labels.odd[at] = 0, question.tolls.rows[body] if is_launch else 0
            step = int(np.searchsorted(last, legs.terms.ready[body] - SLACK_S))
            labels.following[at], labels.head[step] = labels.head[step], at
            at += 1
    return np.array([0, at, 0, -1])


def _labels_room(size: int, words: tuple[int, int], steps: int) -> WalkLabels:
    """Storage for labels, by the step they are ready in; with words of memory and of cuts."""
    body, kits, came_from = (np.empty(size, dtype=np.int32) for _ in range(3))
    time, left = np.empty(size), np.empty(size)
    counts, value, worth, following = (np.empty(size, dtype=np.int64) for _ in range(4))
    memory, odd = (np.empty((size, each), dtype=np.int64) for each in words)
    head = np.full(steps + 1, -1)
    return WalkLabels(
        body, kits, came_from, counts, time, left, value, worth, memory, odd, following, head
    )


def _kept_room(places: int, words: tuple[int, int], size: int) -> KeptLabels:
    """Storage for labels kept for comparison."""
    value, worth, counts = (np.empty((places, size), dtype=np.int64) for _ in range(3))
    return KeptLabels(
        np.zeros(places, dtype=np.int64),
        np.empty((places, size)),
        value,
        worth,
        counts,
        np.empty((places, size), dtype=np.int32),
        *(np.empty((places, each, size), dtype=np.int64) for each in words),
    )
