"""Prizes of any size are planned and proven alike."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from seeds import over_seeds
from varied_fields import varied

from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.stop import MaxRuntime
from adr_opt.common.tolerance import check_prizes, common_step, meets, rounded_down, rounded_up
from adr_opt.mission.mission import Mission
from adr_opt.run.methods import get, spec

SCALES = (1e-7, 1.0, 1e7)


@pytest.mark.parametrize(
    "prizes",
    [
        (1.0,),
        pytest.param((3.0, 1.0, 2.0), marks=pytest.mark.slow),
        (0.7, 2.3, 0.0, 1.1),
        (0.317, 1.618),
    ],
)
@pytest.mark.parametrize("method", ["auto", "exact", pytest.param("mip", marks=pytest.mark.slow)])
@over_seeds(range(3), gate=1)
def test_scaled_prizes_change_nothing(method: str, prizes: tuple[float, ...], seed: int) -> None:
    """All prizes a ten-millionth, or ten million times: optimal plans and proofs of the same."""
    function = get(method)
    one_core = {"jobs": 1} if spec(method).uses_cores else {}
    for scale in SCALES:
        scaled = tuple(scale * prize for prize in prizes)
        mission = Mission(varied(seed, prizes=scaled, targets=6), threads=1)
        best, _, _ = brute_force(mission)
        try:
            result = call(function, mission, stop=MaxRuntime(60.0), **one_core)
        except MissingExtra as missing:
            pytest.skip(str(missing))
        assert result.status == "optimal"
        assert result.objective == pytest.approx(best, rel=1e-9, abs=0.0)
        assert best * (1.0 - 1e-9) <= result.upper_bound <= best * (1.0 + 1e-6)


def test_an_incumbent_meets_a_bound_but_for_rounding() -> None:
    """Where prizes are not known rounding alone is forgiven, for any bound; none meets infinity."""
    for scale in (1e-12, 1.0, 1e12):
        assert meets(0.1 * scale + 0.2 * scale, 0.3 * scale)
        assert meets(0.3 * scale, 0.1 * scale + 0.2 * scale)
        assert not meets(3.0 * scale, 3.00000000000003 * scale)
    assert meets(0.0, 0.0)
    assert not meets(-math.inf, 0.0)
    assert not meets(1.0, math.inf)


def test_steps_are_those_of_all_prizes() -> None:
    """The greatest common step is found at any scale, and none where prizes have none."""
    for scale in (1e-10, 1e-7, 1.0, 1e7):
        for prizes, step in (
            ([1.0, 1.0], 1.0),
            ([6.0, 0.0, 9.0], 3.0),
            ([1.5, 1.0], 0.5),
            ([0.7, 2.3, 1.1], 0.1),
            ([0.491, 2.823, 2.633], 0.001),
            ([1.0, 1e7], 1.0),
            ([math.pi, 1.0], 0.0),
            ([0.0], 0.0),
            ([], 0.0),
        ):
            found = common_step([scale * prize for prize in prizes])
            assert found == pytest.approx(scale * step, rel=1e-12, abs=0.0), prizes


def test_steps_of_prizes_as_they_are_written() -> None:
    """Whole numbers and decimals have a step however far apart they are, up to 2⁴⁶ of them."""
    for prizes, step in (
        ([1e12, 1.0], 1.0),
        ([1e12, 0.25], 0.25),
        ([7654321.3, 0.1], 0.1),
        ([1e-12, 3e-12], 1e-12),
        ([1e9, 1e-3], 1e-3),
        ([1e12, 1e-6], 0.0),
        ([math.pi * 1e9, math.e], 0.0),
    ):
        assert common_step(prizes) == step, prizes
    assert common_step([1e12, 0.25], required=100) == 0.0


@pytest.mark.parametrize(
    ("prizes", "required", "said"),
    [
        ((1e12, 1e-12, 3e11), 0, "prizes are multiples of 1e-12 and sum to 1.3e\\+12"),
        ((1e12, 0.25), 100, "and 100 required targets count as many each"),
        ((math.pi * 1e12, 1.0 / 3.0), 0, "a prize of 0.333333 is lost to rounding in the sum"),
    ],
)
def test_prizes_that_cannot_be_told_apart_are_refused(prizes, required: int, said: str) -> None:
    """Where no margin can be guaranteed one sentence says so; fewer targets are never refused."""
    with pytest.raises(ValueError, match=said):
        check_prizes(prizes, required)
    for scale in (1e-6, 1.0, 1e6):
        check_prizes([scale * prize for prize in (math.pi, math.e, 1.5, 2.25)], 2)


def test_an_instance_with_such_prizes_is_refused() -> None:
    """In files and in Python, in one sentence, and not only when somebody plans."""
    with pytest.raises(InputError, match="no more than 7e\\+13 can be told apart: round prizes"):
        varied(0, prizes=(1e12, 1e-12, 3e11), targets=4)


def test_bounds_are_rounded_to_steps_and_never_below_an_objective() -> None:
    """Sums of prizes stay where they are in any order; from between them a bound goes down."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        prizes = 10.0 ** rng.uniform(-9, 9) * np.round(rng.uniform(0.0, 3.0, 30), 2)
        step = common_step(prizes.tolist())
        assert step > 0.0
        objective = float(rng.permutation(prizes)[: int(rng.integers(1, 30))].sum())
        for near in (objective, np.nextafter(objective, 0.0), np.nextafter(objective, np.inf)):
            assert rounded_down(near, step) == pytest.approx(objective, rel=1e-12)
            assert rounded_up(near, step) == pytest.approx(objective, rel=1e-12)
        assert rounded_down(objective + 0.99 * step, step) == pytest.approx(objective, rel=1e-12)
    assert rounded_down(math.inf, 1.0) == math.inf
    assert rounded_down(0.3, 0.0) == rounded_up(0.3, 0.0) == 0.3
