"""Episodes take no memory that there is not."""

from __future__ import annotations

import pytest
from conftest import Cli, refused

import adr_opt
from adr_opt.learning.episodes import FieldPool, pool


def test_a_pool_beyond_the_memory_is_refused() -> None:
    """Thousands of targets with all their connections are refused before anything is taken."""
    with pytest.raises(adr_opt.InputError, match=r"500001 bodies with 206 departures each take"):
        FieldPool(1, 500_001, 206)


def test_ppo_says_so(cli: Cli, tiny_file: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """The planner ends with a sentence and status 2 where the memory does not suffice."""
    pytest.importorskip("onnxruntime")
    monkeypatch.setattr(pool, "available_bytes", lambda: 1000.0)
    refused(cli("solve", tiny_file, "--method", "ppo"), "8 bodies", "use another method")
