"""Runs stopped at a tenth of the time of their proof."""

from __future__ import annotations

import planners

import adr_opt


def test_shares_are_of_proven_fields_alone() -> None:
    """Of a proven field there is a share up to one; what is proven in less time has none."""
    for seed in range(2):
        found = planners.stopped(adr_opt.generate("tiny", seed), 20.0, 0.0)
        assert found is not None
        assert 0.0 <= found.stopped <= found.optimum
    assert planners.stopped(adr_opt.generate("tiny", 0), 20.0, 1e9) is None
