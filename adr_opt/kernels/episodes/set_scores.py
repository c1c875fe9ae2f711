"""Scores of choices by the network of the learned policy: a set of tokens, and attention.

The same as the network in PyTorch that is trained. Only choices that are there are tokens, as
attention looks at no others.
"""

from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.lists import kept_least
from ..core.memory import borrowed
from .choices import (
    ANGLE_FROM_CHASER,
    CHOICE_FIELDS,
    COST,
    INCLINATION_FROM_HOME,
    IS_OPEN,
    IS_STATION,
    LEGAL,
    MISSION_FIELDS,
    PHASE,
    RAAN_FROM_HOME,
    RADIUS_FROM_HOME,
)

TOKENS = 17
"""Number of choices that the network looks at: stations, and the cheapest moves, legal first."""

HEADS = 4
"""Number of attention heads."""

PLACE, PLACE_WIDTH = 6, 6
"""Features of a token's orbit, and their projection in a head: products for two tokens hold their
distance and their phase."""

PLACES = (RADIUS_FROM_HOME, INCLINATION_FROM_HOME, RAAN_FROM_HOME)
"""Fields that locate the orbit of a choice."""

CONTEXT = len(MISSION_FIELDS) + 2 * len(CHOICE_FIELDS)
"""Number of context features: of the mission, and means and deviations over all open targets."""

LAST, EQUAL = 100.0, 1e-3
"""Penalty that ranks illegal choices last, and weight that breaks ties of cost by planes."""

UNSEEN = -30.0
"""Score of choices that are not among the tokens."""

ILLEGAL = -1e8
"""Score of an illegal move."""

FIELDS, NUMBERS = len(CHOICE_FIELDS), len(MISSION_FIELDS)
NORM = np.float32(1e-5)


class ScorerWeights(NamedTuple):
    """Layers of the network, float32: weights (inputs, outputs), then biases (outputs,).

    Those from ``attend`` to ``narrow`` have a leading axis, layers of attention; scales of norms
    and of products are in the layers after and before them.
    """

    token: np.ndarray
    token_bias: np.ndarray
    context: np.ndarray
    context_bias: np.ndarray
    encode: np.ndarray
    encode_bias: np.ndarray
    attend: np.ndarray
    attend_bias: np.ndarray
    place: np.ndarray
    place_bias: np.ndarray
    merge: np.ndarray
    merge_bias: np.ndarray
    widen: np.ndarray
    widen_bias: np.ndarray
    narrow: np.ndarray
    narrow_bias: np.ndarray
    head: np.ndarray
    head_bias: np.ndarray
    score: np.ndarray
    score_bias: np.ndarray


@inlined
def _linear(x, rows, weight, bias, out):
    """Products of rows and weights, four inputs at once: that spares half of the memory traffic."""
    inputs, outputs = weight.shape
    fours = inputs - inputs % 4
    for r in range(rows):
        for at in range(outputs):
            out[r, at] = bias[at]
        for k in range(0, fours, 4):
            a, b, c, d = x[r, k], x[r, k + 1], x[r, k + 2], x[r, k + 3]
            for at in range(outputs):
                out[r, at] += (a * weight[k, at] + b * weight[k + 1, at]) + (
                    c * weight[k + 2, at] + d * weight[k + 3, at]
                )
        for k in range(fours, inputs):
            for at in range(outputs):
                out[r, at] += x[r, k] * weight[k, at]


@kernel
def _normed(h, rows, width, out):
    """Layer normalisation: rows less their mean, divided by their deviation."""
    share = np.float32(1.0 / width)
    for r in range(rows):
        mean, square = np.float32(0.0), np.float32(0.0)
        for at in range(width):
            mean += h[r, at]
        mean *= share
        for at in range(width):
            square += (h[r, at] - mean) ** 2
        scale = np.float32(1.0) / np.sqrt(square * share + NORM)
        for at in range(width):
            out[r, at] = (h[r, at] - mean) * scale


@inlined
def _rectify(h, rows, width):
    for r in range(rows):
        for at in range(width):
            h[r, at] = max(h[r, at], np.float32(0.0))


@inlined
def _add(more, rows, width, h):
    for r in range(rows):
        for at in range(width):
            h[r, at] += more[r, at]


@kernel
def _tokens(rows, keys, token):
    """Select the choices that become tokens, best first; returns their number."""
    kept = 0
    for choice in range(len(rows)):
        row = rows[choice]
        is_station, is_there = row[IS_STATION], max(row[IS_OPEN], row[IS_STATION])
        if is_there == 0.0:
            continue
        key = (row[COST] + EQUAL * row[ANGLE_FROM_CHASER]) * (1.0 - is_station)
        key = np.float32(key + LAST * (3.0 - row[LEGAL] - row[IS_OPEN] - is_there))
        kept = kept_least(keys, token, kept, key, choice)
    return kept


@kernel
def _context(rows, mission, out):
    """Numbers of the mission, and means and deviations over all open targets."""
    mean, spread, count = out[NUMBERS:], out[NUMBERS + FIELDS :], 0
    for at in range(NUMBERS):
        out[at] = mission[at]
    for at in range(2 * FIELDS):
        mean[at] = np.float32(0.0)
    for choice in range(len(rows)):
        if rows[choice, IS_OPEN] != 0.0 and rows[choice, IS_STATION] == 0.0:
            count += 1
            for field in range(FIELDS):
                mean[field] += rows[choice, field]
    share = np.float32(1.0 / max(count, 1))
    for field in range(FIELDS):
        mean[field] *= share
    for choice in range(len(rows)):
        if rows[choice, IS_OPEN] != 0.0 and rows[choice, IS_STATION] == 0.0:
            for field in range(FIELDS):
                spread[field] += (rows[choice, field] - mean[field]) ** 2
    for field in range(FIELDS):
        spread[field] = np.sqrt(spread[field] * share)


@inlined
def _write_place(x, place):
    """Write the features that locate a token's orbit."""
    square = np.float32(0.0)
    for at in range(len(PLACES)):
        place[at] = x[PLACES[at]]
        square += place[at] ** 2
    phase = np.float32(np.pi) * x[PHASE]
    place[3], place[4], place[5] = square, np.sin(phase), np.cos(phase)


@kernel
def _attention(split, lies, rows, width, across, near, seen):
    """Attention: mean of all tokens' values, weighted by their nearness."""
    part = width // HEADS
    for head in range(HEADS):
        first, place = head * part, head * PLACE_WIDTH
        # Keys lie across, so that sums are over tokens side by side.
        for t in range(rows):
            for at in range(part):
                across[at, t] = split[t, width + first + at]
            for at in range(PLACE_WIDTH):
                across[part + at, t] = lies[t, HEADS * PLACE_WIDTH + place + at]
        for r in range(rows):
            for t in range(rows):
                near[t] = np.float32(0.0)
            for at in range(part):
                query = split[r, first + at]
                for t in range(rows):
                    near[t] += query * across[at, t]
            for at in range(PLACE_WIDTH):
                query = lies[r, place + at]
                for t in range(rows):
                    near[t] += query * across[part + at, t]
            most, total = near[0], np.float32(0.0)
            for t in range(1, rows):
                most = max(most, near[t])
            for t in range(rows):
                near[t] = np.exp(near[t] - most)
                total += near[t]
            for at in range(part):
                seen[r, first + at] = np.float32(0.0)
            for t in range(rows):
                share = near[t] / total
                for at in range(part):
                    seen[r, first + at] += share * split[t, 2 * width + first + at]


@kernel
def set_scores(weights, moves, mission, scores):
    """Scores of the choices of some states.

    Parameters
    ----------
    weights : ScorerWeights
    moves : (states, choices, len(CHOICE_FIELDS)) float32
    mission : (states, len(MISSION_FIELDS)) float32
    scores : (states, choices) float32
        Written; :data:`ILLEGAL` for illegal choices, :data:`UNSEEN` for legal ones that are no
        tokens.

    Returns
    -------
    good : bool
        False if a score has no measure, by which an illegal move might seem best.
    """
    weights = borrowed(weights)
    width, good = weights.encode_bias.size, True
    token = np.empty(TOKENS, dtype=np.int64)
    keys = np.empty(TOKENS, dtype=np.float32)
    whole, beside = np.zeros((1, CONTEXT), dtype=np.float32), np.empty((3, width), dtype=np.float32)
    x = np.empty((TOKENS, FIELDS), dtype=np.float32)
    place = np.empty((TOKENS, PLACE), dtype=np.float32)
    h, away, seen = np.empty((3, TOKENS, width), dtype=np.float32)
    wide = np.empty((TOKENS, 2 * width), dtype=np.float32)
    split = np.empty((TOKENS, 3 * width), dtype=np.float32)
    lies = np.empty((TOKENS, 2 * HEADS * PLACE_WIDTH), dtype=np.float32)
    across = np.empty((width // HEADS + PLACE_WIDTH, TOKENS), dtype=np.float32)
    near = np.empty(TOKENS, dtype=np.float32)
    for s in range(len(moves)):
        rows = moves[s]
        count = _tokens(rows, keys, token)
        _context(rows, mission[s], whole[0])
        _linear(whole, 1, weights.context, weights.context_bias, beside)
        for t in range(count):
            for field in range(FIELDS):
                x[t, field] = rows[token[t], field]
            _write_place(x[t], place[t])
        _linear(x, count, weights.token, weights.token_bias, away)
        for t in range(count):
            for at in range(width):
                away[t, at] = max(away[t, at] + beside[0, at], np.float32(0.0))
        _linear(away, count, weights.encode, weights.encode_bias, h)
        for layer in range(len(weights.attend)):
            _normed(h, count, width, away)
            _linear(away, count, weights.attend[layer], weights.attend_bias[layer], split)
            _linear(place, count, weights.place[layer], weights.place_bias[layer], lies)
            _attention(split, lies, count, width, across, near, seen)
            _linear(seen, count, weights.merge[layer], weights.merge_bias[layer], away)
            _add(away, count, width, h)
            _normed(h, count, width, away)
            _linear(away, count, weights.widen[layer], weights.widen_bias[layer], wide)
            _rectify(wide, count, 2 * width)
            _linear(wide, count, weights.narrow[layer], weights.narrow_bias[layer], away)
            _add(away, count, width, h)
        # What all tokens share of the head is worked out once.
        for at in range(width):
            pooled = np.float32(0.0)
            for t in range(count):
                pooled += h[t, at]
            beside[1, at] = pooled / np.float32(max(count, 1)) + beside[0, at]
        _linear(beside[1:], 1, weights.head[width:], weights.head_bias, beside[2:])
        _linear(h, count, weights.head[:width], beside[2], away)
        _rectify(away, count, width)
        for choice in range(len(rows)):
            scores[s, choice] = UNSEEN if rows[choice, LEGAL] != 0.0 else ILLEGAL
        for t in range(count):
            score = weights.score_bias[0]
            for at in range(width):
                score += away[t, at] * weights.score[at]
            good = good and abs(score) < -ILLEGAL
            if rows[token[t], LEGAL] != 0.0:
                scores[s, token[t]] = score
    return good
