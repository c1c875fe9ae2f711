"""The synthetic population of the page on worth."""

from __future__ import annotations

from pathlib import Path

import population

from adr_opt.sources import catalogue, worth


def test_the_same_seed_gives_the_same_population(tmp_path: Path) -> None:
    """Both files depend on the seed and the number alone."""
    texts = []
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        (tmp_path / name).mkdir()
        paths = population.write_population(tmp_path / name, 300, seed)
        texts.append([path.read_text("utf-8") for path in paths])
    assert texts[0] == texts[1]
    assert texts[0][0] != texts[2][0]


def test_the_population_is_read_and_rated(tmp_path: Path) -> None:
    """Every object has an entry; some masses are uncertain, some unknown; stages lead the ranks."""
    path, satcat = population.write_population(tmp_path, 2000)
    bodies = worth.bodies_of(
        catalogue.read(path).records, worth.read_satcat(satcat), excluded=("*RELAY*",)
    )
    assert bodies.matched == len(bodies)
    assert len(bodies) + bodies.left_out["excluded"] == 2000
    told = worth.answer(worth.prizes_of(worth.worth_of(bodies, 50.0), 60), None)
    assert {"satcat", "satcat, uncertain", "default: payload"} <= set(told["masses"])
    first = told["best"][0]
    assert "HEAVY" in first["name"] or "GIANT" in first["name"]
    assert "encounters in 1,000 years" in first["reason"]
    ten, fifty = told["sets"]
    assert 0.0 < ten["share"] < fifty["share"] < 1.0
    for each in (ten, fifty):
        assert each["sum_floors"] <= each["worth"] * (1.0 + 1e-9)
        assert each["worth"] <= each["sum_alone"] * (1.0 + 1e-9)
