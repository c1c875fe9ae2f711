"""Prizes that a tolerance would swallow: large beside small, fractions, and none alike."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from adr_opt.problem.instance import Instance

Draw = Callable[[np.random.Generator, int], list[float]]


def _whole(largest: float) -> Draw:
    """Integers up to a largest one, and a few small ones."""

    def draw(rng: np.random.Generator, number: int) -> list[float]:
        prizes = rng.integers(1, int(largest), number, endpoint=True).astype(float)
        small = rng.random(number) < 0.6
        return np.where(small, rng.integers(1, 4, number), prizes).tolist()

    return draw


def _mixed(rng: np.random.Generator, number: int) -> list[float]:
    """Powers of ten up to 10¹² and a little more, and one of 1."""
    large = [float(10 ** rng.integers(0, 13) + rng.integers(0, 3)) for _ in range(number - 1)]
    return [*large, 1.0]


def _quarters(rng: np.random.Generator, number: int) -> list[float]:
    prizes = 0.25 * rng.integers(1, 10, number)
    prizes[rng.integers(number)] += 1e9
    return prizes.tolist()


def _tenths(rng: np.random.Generator, number: int) -> list[float]:
    prizes = [float(rng.integers(1, 20)) / 10.0 for _ in range(number)]
    prizes[int(rng.integers(number))] = 7654321.3
    return prizes


def _irrational(rng: np.random.Generator, number: int) -> list[float]:
    return (10.0 ** rng.uniform(-3.0, 5.0, number)).tolist()


KINDS: dict[str, Draw] = {
    "1e3": _whole(1e3),
    "1e6": _whole(1e6),
    "1e9": _whole(1e9),
    "1e12": _whole(1e12),
    "mixed": _mixed,
    "quarters": _quarters,
    "tenths": _tenths,
    "irrational": _irrational,
}


def with_prizes(instance: Instance, kind: str, seed: int, required: int = 0) -> Instance:
    """An instance with prizes of a kind, of which the first few targets are required."""
    rng = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    prizes = KINDS[kind](rng, len(instance.targets))
    return instance.replace(
        targets=tuple(
            target.replace(prize=min(prize, 1e12), required=number < required)
            for number, (target, prize) in enumerate(zip(instance.targets, prizes, strict=True))
        )
    )
