"""A study of designs goes on from its file, which may be edited, or of other work."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rated_fields import rated, worths_of_sets

from adr_opt.analysis import Axis, CampaignPrices, DesignPoint, DesignStudy, design_study
from adr_opt.common.errors import InputError

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
