"""Runs stopped at a tenth of the time of their proof."""

from __future__ import annotations

from run_all_rows import Load


def test_shares_are_of_proven_fields_alone(load: Load) -> None:
    """Of a proven field there is a share up to one; what is not proven in time has none."""
    tenth = load("tenth")
    ((line, shares),) = tenth.lines(["tiny"], range(2), 20.0, 0.0)
    assert "2 of 2" in line
    assert all(0.0 <= share <= 1.0 for share in shares)
    ((line, shares),) = tenth.lines(["tiny"], range(1), 20.0, 1e9)
    assert "0 of 1" in line
    assert shares == []
