"""docs/refining.md says what its picture shows."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_page_says_what_the_picture_shows() -> None:
    """The totals and shares beside the picture of planned and flown legs are those drawn."""
    pytest.importorskip("matplotlib")
    own, free = runpy.run_path(str(ROOT / "docs/draw_model.py"))["refined_cloud"]()
    page = " ".join((ROOT / "docs/refining.md").read_text(encoding="utf-8").split())
    shares = [leg.flown_delta_v_m_s / leg.planned_delta_v_m_s for leg in free.legs]
    # Numbers of another machine differ in what an optimiser leaves: a tenth of a metre per second.
    said = page.partition("It is planned with ")[2].partition(" times the plan of a leg")[0]
    numbers = [float(word) for word in said.replace(",", " ").split() if word[0].isdigit()]
    shown = [own.planned_delta_v_m_s, own.flown_delta_v_m_s, free.flown_delta_v_m_s]
    assert numbers[:3] == pytest.approx(shown, abs=0.5)
    assert numbers[3:] == pytest.approx([min(shares), max(shares)], abs=0.02)
    assert int(np.sum(np.array(shares) > 1.0)) == 1
