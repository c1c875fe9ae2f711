"""Campaigns of made-up debris by the rules of GTOC9: planned, bounded and flown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from from_outside import BENCH
from outside.gtoc9.campaign import read_campaign
from outside.gtoc9.debris import read_debris
from outside.gtoc9.flown import read_flown
from outside.gtoc9.instance import contest
from outside.gtoc9.scoring import score

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.problem import Problem
from solvers.tours.least_expense import LeastExpense

assert BENCH.is_dir()


def made_up(path, count, spread_deg=6.0, epoch=22000.0, seed=4):
    """A file of debris whose planes are near at an epoch, in the form of the contest's."""
    random = np.random.default_rng(seed)
    lines = []
    for number in range(count):
        plane = math.radians(100.0 + random.uniform(-spread_deg, spread_deg))
        elements = [
            epoch + random.uniform(0.0, 1.0),
            7.1e6 + random.uniform(-5e4, 5e4),
            random.uniform(0.0, 0.01),
            math.radians(98.0 + spread_deg * random.uniform(-0.1, 0.1)),
            plane,
            random.uniform(0.0, math.tau),
            random.uniform(0.0, math.tau),
        ]
        lines.append(" ".join(repr(value) for value in (float(number), *elements)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def field(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("gtoc9") / "debris_data.txt", 7)


@pytest.mark.slow
def test_a_plan_is_legal_and_above_the_bound(field, tmp_path):
    """A campaign of solve keeps all rules of the contest, and J is no less than the bound."""
    rows = read_debris(field)
    result = adr_opt.solve(contest(rows, 0.5), seed=1, iterations=2, time_limit=math.inf)
    result.plan.save(tmp_path / "ours.json")
    missions = read_campaign(tmp_path / "ours.json")
    judged_so = score(missions, [mission.flown_m_s for mission in missions], len(rows))
    assert judged_so.violations == ()
    assert judged_so.total_meur == pytest.approx(result.plan.cost, rel=1e-9)
    below = LeastExpense(Problem(contest(rows, 0.5)))
    below.advance(math.inf)
    assert 30.0 < below.value <= judged_so.total_meur


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("missions", "campaign"),
        ("[[2, ", "[[2.5, "),
        ("[2, ", "[99, "),
        ('"legs": [', '"legs": [[], '),
        ('"legs": [\n   [[', '"legs": [\n   [["far", '),
    ],
)
def test_broken_flown_campaigns_are_refused(tmp_path, old, new):
    """A file of impulses that is not what it should be is refused with the file and the reason."""
    text = (
        '{"missions": [{"stops": [[2, 23595.0, 23600.0], [3, 23604.0, 23609.0]],\n'
        '  "legs": [\n   [[0.0, 1.0, 2.0, 3.0]]]}]}'
    )
    path = tmp_path / "flown.json"
    path.write_text(text)
    assert read_flown(path, 4)[0].flights[0].impulses_m_s.tolist() == [[1.0, 2.0, 3.0]]
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="not as published"):
        read_flown(path, 4)
