"""Copies of instances: what is worked out of one is not taken for another."""

from __future__ import annotations

import pickle

import numpy as np

import adr_opt


def test_rows_of_orbits_are_those_of_the_copy() -> None:
    """A changed or unchecked copy has rows of its own orbits, and nobody changes those kept."""
    drawn = adr_opt.generate("tiny", 3, targets=5)
    rows = drawn.orbits()
    rows[:] = 0.0
    fresh = adr_opt.generate("tiny", 3, targets=5)
    assert np.array_equal(drawn.orbits(), fresh.orbits(), equal_nan=True)
    turned = drawn.targets[::-1]
    replaced, copied = drawn.replace(targets=turned), drawn.model_copy(update={"targets": turned})
    first = drawn.first_target
    for other in (replaced, copied):
        assert np.array_equal(other.orbits()[first:], fresh.orbits()[first:][::-1])
    assert np.array_equal(drawn.orbits(), fresh.orbits(), equal_nan=True)
    drifting = drawn.model_copy(update={"dynamics": "j2"})
    assert not np.array_equal(drifting.orbits(), fresh.orbits(), equal_nan=True)
    again = pickle.loads(pickle.dumps(drawn))
    assert again == drawn
    assert np.array_equal(again.orbits(), fresh.orbits(), equal_nan=True)
