"""Every study of the package goes on from its file, stops, and is the same in several processes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from drawn_worlds import drawn_uncertainty
from hand_made import hand_made
from rated_fields import rated, worths_of_sets

import adr_opt
from adr_opt.analysis import Axis, CampaignPrices, design_study, rehearse, tradeoff
from adr_opt.analysis.rehearse.bounds import bounds
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxRuntime
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance


@cache
def tiny() -> tuple[Instance, Plan]:
    instance = adr_opt.generate("tiny", 0)
    return instance, adr_opt.solve(instance, "beam").plan


def traded(**more: Any) -> Any:
    made = tradeoff(hand_made(), [Axis("delta-v", (130.0, 270.0, 420.0, 700.0))], **more)
    return [(point.prize, point.upper_bound) for point in made.points if point.routes]


def designed(**more: Any) -> Any:
    field = rated(targets=2)
    axes = [Axis("launches", (1.0,)), Axis("kits", (1.0, 2.0))]
    settings = {"worths": worths_of_sets(field), "prices": CampaignPrices(10.0, 2.0)}
    points = design_study(field, axes, time_limit=60.0, **settings, **more).points
    return [(at.design, at.plan and at.plan.orders, at.floor, at.bound, at.euros) for at in points]


def rehearsed(**more: Any) -> Any:
    instance, plan = tiny()
    return rehearse(instance, plan, drawn_uncertainty(instance, 1), samples=8, **more).outcomes


def bounded(**more: Any) -> Any:
    instance, _ = tiny()
    return bounds(instance, drawn_uncertainty(instance, 3), samples=2, **more).worlds


every_study = pytest.mark.parametrize("study", [traded, designed, rehearsed, bounded])

Study = Callable[..., Any]


@every_study
def test_it_goes_on_wherever_it_was_cut_off(study: Study, tmp_path: Path) -> None:
    """Whole rows of the file are not made again, the others are, and all is as without a file."""
    path = tmp_path / "s.jsonl"
    alone = study(path=path)
    whole = path.read_bytes()
    for kept in (0.05, 0.6, 0.999, 1.0):
        cut = whole[: int(kept * len(whole))]
        path.write_bytes(cut)
        assert study(path=path) == alone
        rows = path.read_bytes()
        assert rows.startswith(cut[: cut.rfind(b"\n") + 1])
        assert rows.count(b"\n") == whole.count(b"\n")


@every_study
def test_a_stop_leaves_what_is_finished(study: Study, tmp_path: Path) -> None:
    """Without time no row is made, and the file has its head alone."""
    path = tmp_path / "s.jsonl"
    study(path=path, stop=MaxRuntime(1e-9))
    assert path.read_bytes().count(b"\n") == 1


@every_study
def test_a_table_is_no_file_of_a_study(study: Study, tmp_path: Path) -> None:
    """A file that is something else is refused, and stays."""
    path = tmp_path / "s.jsonl"
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="not a file of a study"):
        study(path=path)
    assert path.read_text(encoding="utf-8") == "a,b\n1,2\n"


@pytest.mark.slow
@every_study
def test_processes_make_the_same(study: Study) -> None:
    """Two processes come to what one does."""
    assert study(jobs=2) == study()
