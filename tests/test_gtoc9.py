"""The closed form of long transfers against legs that others optimised and flew in full."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data")) / "gtoc9"

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no folder {FOLDER} (ADR_OPT_EXTERNAL_DATA)"),
]


def test_the_winning_legs_cost_what_the_closed_form_says() -> None:
    """The total of the 113 legs is met within 1 %, and a leg within 5.1 % in the mean."""
    pytest.importorskip("scipy")
    path = Path(__file__).parents[1] / "bench" / "gtoc9.py"
    spec = importlib.util.spec_from_file_location("gtoc9", path)
    assert spec is not None
    assert spec.loader is not None
    reader = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reader)
    legs = reader.read_legs(FOLDER)
    assert len(legs) == 113
    flown = np.array([leg.flown for leg in legs])
    planned = np.array([leg.closed_form for leg in legs])
    assert abs(planned.sum() / flown.sum() - 1.0) <= 0.01
    assert np.abs(planned / flown - 1.0).mean() <= 0.051
