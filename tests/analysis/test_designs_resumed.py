"""A study of designs goes on from its file, which may be torn, edited, or of other work."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rated_fields import rated, worths_of_sets

from adr_opt.analysis import Axis, CampaignPrices, DesignPoint, DesignStudy, design_study
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxRuntime

AXES = [Axis("launches", (1.0,)), Axis("kits", (1.0, 2.0))]


def run(path: Path | None, **more: Any) -> tuple[DesignStudy, list[DesignPoint]]:
    """The study, and the points that were run for it."""
    ran: list[DesignPoint] = []
    field = rated(targets=2)
    settings: dict[str, Any] = {
        "worths": worths_of_sets(field),
        "prices": CampaignPrices(10.0, 2.0),
        "time_limit": 60.0,
    }
    made = design_study(
        field, AXES, path=path, told=lambda point, done, of: ran.append(point), **settings | more
    )
    return made, ran


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file of a study that is finished."""
    path = tmp_path_factory.mktemp("designs") / "d.jsonl"
    made, ran = run(path)
    assert len(made.points) == len(ran) == 2
    return path.read_bytes()


def told(study: DesignStudy) -> list[tuple[Any, ...]]:
    """What a study says, but for times."""
    return [
        (
            point.design,
            point.plan and point.plan.orders,
            point.floor,
            point.worth,
            point.bound,
            point.euros,
        )
        for point in study.points
    ]


def test_a_finished_file_is_not_run_again(tmp_path: Path, content: bytes) -> None:
    """A second call runs nothing, says the same, and leaves the file as it is."""
    path = tmp_path / "d.jsonl"
    path.write_bytes(content)
    made, ran = run(path)
    assert ran == []
    assert path.read_bytes() == content
    assert told(made) == told(run(None)[0])


@pytest.mark.parametrize("kept", [0.05, 0.5, 0.999])
def test_a_file_that_was_cut_off_goes_on(kept: float, tmp_path: Path, content: bytes) -> None:
    """Wherever the machine stopped, whole lines are kept and the others made anew."""
    path = tmp_path / "d.jsonl"
    cut = content[: math.floor(kept * len(content))]
    path.write_bytes(cut)
    made, ran = run(path)
    assert len(ran) == 2 - max(cut.count(b"\n") - 1, 0)
    assert len(made.points) == 2
    again, ran = run(path)
    assert ran == []
    assert told(again) == told(made)


def test_more_values_run_what_is_new(tmp_path: Path, content: bytes) -> None:
    """Points of the file count for other axes, too, as far as they are the same designs."""
    path = tmp_path / "d.jsonl"
    path.write_bytes(content)
    ran: list[DesignPoint] = []
    field = rated(targets=2)
    design_study(
        field,
        [AXES[0], Axis("kits", (2.0, 3.0))],
        path=path,
        worths=worths_of_sets(field),
        prices=CampaignPrices(10.0, 2.0),
        time_limit=60.0,
        told=lambda point, done, of: ran.append(point),
    )
    assert [point.design.value("kits") for point in ran] == [3.0]


def test_a_study_that_is_stopped_has_what_is_finished(tmp_path: Path) -> None:
    """Without time nothing is run and nothing written, and the number of designs is told."""
    path = tmp_path / "d.jsonl"
    made, ran = run(path, stop=MaxRuntime(1e-9))
    assert (made.points, made.wanted, ran) == ((), 2, [])
    assert path.read_bytes().count(b"\n") == 1


def dearer(line: dict[str, Any]) -> None:
    line["value"]["plan"]["routes"][0]["legs"][0]["delta_v_m_s"] += 1.0


def strange(line: dict[str, Any]) -> None:
    line["value"]["plan"]["instance"]["sha256"] = "0" * 64


def low(line: dict[str, Any]) -> None:
    line["value"]["bound"] = 1e-3


def wordy(line: dict[str, Any]) -> None:
    line["value"]["bound"] = "much"


def endless(line: dict[str, Any]) -> None:
    line["value"]["runtime_s"] = 10**400


def bare(line: dict[str, Any]) -> None:
    del line["value"]["plan"]


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (strange, "belongs to the instance"),
        (dearer, "the plan is not legal: leg 1"),
        (low, "avoids more than its bound"),
        (wordy, "not a row of designs"),
        (endless, "not a row of designs"),
        (bare, "not a row of designs"),
    ],
)
def test_lines_that_say_too_much_are_refused(
    spoil: Callable[[dict[str, Any]], None], said: str, tmp_path: Path, content: bytes
) -> None:
    """Plans are checked, and compared with their bounds; the sentence names the line."""
    path = tmp_path / "d.jsonl"
    head, first, *others = content.splitlines()
    line = json.loads(first)
    spoil(line)
    path.write_bytes(b"\n".join([head, json.dumps(line).encode(), *others]) + b"\n")
    before = path.read_bytes()
    with pytest.raises(InputError, match=said) as caught:
        run(path)
    assert f"{path}: line 2" in str(caught.value)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"time_limit": 59.0}, "other settings"),
        ({"seed": 1}, "other settings"),
        ({"prices": CampaignPrices(11.0)}, "other prices"),
        ({"worths": None}, "other worths"),
    ],
)
def test_files_of_other_work_are_refused(
    more: dict[str, Any], said: str, tmp_path: Path, content: bytes
) -> None:
    """Results of another instance, price, worth or setting are not mixed in."""
    path = tmp_path / "d.jsonl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=f"made with {said}"):
        run(path, **more)
    path.write_text("prize,cost\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"not a file of a study \(designs\)"):
        run(path)
