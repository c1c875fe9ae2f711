"""Drawn orienteering with windows: missions are their tours, and a table keeps the best known."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import peers
import pytest
from contest import orienteering

import adr_opt


def best_by_enumeration(places) -> int:
    """Prizes of the best order of some of the places."""
    best, numbers = 0, range(1, places.prize.size)
    for size in range(places.prize.size):
        for tour in permutations(numbers, size):
            try:
                best = max(best, orienteering.collected(places, tour))
            except ValueError:
                continue
    return best


@pytest.mark.parametrize("kind", ["scattered-narrow", "scattered-wide", "clustered-narrow"])
def test_the_best_plan_is_the_best_tour(kind: str) -> None:
    """The optimum of the mission is that of all orders, and PyVRP collects no more."""
    for seed in range(4):
        places = orienteering.draw(kind, seed, 6)
        places = places._replace(closes=np.minimum(places.closes, 150))
        places = places._replace(opens=np.minimum(places.opens, places.closes))
        instance = orienteering.instance_of(places)
        result = adr_opt.solve(instance, "exact", time_limit=60.0)
        best = best_by_enumeration(places)
        assert result.status == "optimal", seed
        assert result.objective == best, seed
        assert adr_opt.check(instance, result.plan) == (), seed
        pytest.importorskip("pyvrp")
        assert orienteering.by_pyvrp(places, 0.1) <= best, seed


def test_tours_that_are_none_are_told() -> None:
    """A place that is there twice, or is reached too late, is no tour."""
    places = orienteering.draw("scattered-narrow", 0, 6)
    with pytest.raises(ValueError, match="twice"):
        orienteering.collected(places, (1, 1))
    late = places._replace(closes=np.where(np.arange(7) == 2, 0, places.closes))
    with pytest.raises(ValueError, match="place 2 is reached too late"):
        orienteering.collected(late, (2,))


def test_the_table_keeps_the_best_known(tmp_path, monkeypatch, capsys) -> None:
    """What was known stays unless more was found, and what was planned is not planned again."""
    kept = tmp_path / "kept.csv"
    kept.write_text("instance,prizes\nclustered-wide-0-6,1e+06\nother,5\n", encoding="utf-8")
    words = {"kinds": ("clustered-wide",), "count": 1, "places": 6, "limits": (5.0,), "keep": kept}
    for _ in range(2):
        peers.windows(**words, rows=tmp_path / "rows.jsonl")
        monkeypatch.setattr(peers, "planned", None)
    printed = capsys.readouterr().out
    assert printed.count("1 of 1 proven") == 2
    assert "| clustered-wide-0-6 | 1e+06 |" in printed
    assert kept.read_text("utf-8") == "instance,prizes\nclustered-wide-0-6,1e+06\nother,5\n"
