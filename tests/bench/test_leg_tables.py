"""Tables of legs, on few pairs."""

from __future__ import annotations

import pytest
from leg_costs.low_thrust import low_thrust


@pytest.mark.slow
def test_the_table_of_low_thrust_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """The command gets to its last table, and the closed form is near the optimum."""
    low_thrust(pairs=4, bounds=200, repeats=2)
    said = capsys.readouterr().out
    assert abs(float(said.split("All: ")[1].split("%")[0])) < 2.0
    assert "| off |" in said
