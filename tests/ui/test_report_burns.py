"""The burns in the report, and the CSV file that its reader makes."""

from __future__ import annotations

import csv
import io
import math
import re
from datetime import timedelta
from pathlib import Path

import browser
import numpy as np
import pytest
from drifting_plans import drifting_instance, drifting_plan
from two_chasers import campaign, planned

import adr_opt
from adr_opt.fly.trajectory import body_states
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.plot.strands import tracks
from adr_opt.ui.report import burns

pytest.importorskip("plotly")

MISSIONS = {"two chasers": (campaign, planned), "drift": (drifting_instance, drifting_plan)}


def of_kind(kind: str) -> tuple[Instance, Plan]:
    """An instance with its plan."""
    instance, plan = MISSIONS[kind]
    return instance(), plan()


@pytest.mark.parametrize("kind", MISSIONS)
def test_all_burns_are_there_in_the_frame_of_their_orbit(kind: str) -> None:
    """Each burn of each leg, as large in its local frame, which is right for those that are known.

    The first burn of a leg is made on the orbit of its origin. Those of the approach are radial,
    towards the Earth; the first is one vector with the stop.
    """
    instance, plan = of_kind(kind)
    found = burns.impulses(plan, tracks(instance, plan))
    every = [(n, burn) for n, leg in enumerate(plan.legs, start=1) for burn in leg.impulses]
    assert [(one.leg, one.time_s, one.delta_v_m_s) for one in found] == [
        (n, burn.time_s, burn.delta_v_m_s) for n, burn in every
    ]
    for one in found:
        assert one.local_m_s is not None
        assert math.hypot(*one.local_m_s) == pytest.approx(one.size_m_s, abs=1e-9)
        leg = plan.legs[one.leg - 1]
        if one.time_s == leg.leaves_s:
            position, velocity = (s[0] for s in body_states(instance, leg.origin, one.time_s))
            radial = np.array(one.delta_v_m_s) @ position / np.linalg.norm(position)
            across = np.cross(position, velocity)
            across = np.array(one.delta_v_m_s) @ across / np.linalg.norm(across)
            assert one.local_m_s[0] == pytest.approx(radial, abs=1e-6)
            assert one.local_m_s[2] == pytest.approx(across, abs=1e-6)
        if one.phase == "approach":
            (begins, _) = (burn for burn in leg.burns if burn.phase == "approach")
            assert one.local_m_s[0] == pytest.approx(-begins.size_m_s, rel=0.02)
            assert one.time_s == leg.standoff_s or abs(one.local_m_s[1]) < 1e-3


def test_refined_burns_are_told_beside_the_planned_ones() -> None:
    """As large in their local frame as in that of the elements, and as many as there are."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan)
    found = [one for one in burns.impulses(plan, (), refined) if one.of == burns.REFINED]
    assert len(found) == sum(len(leg.impulses) for leg in refined.legs)
    for one in found:
        assert one.local_m_s is not None
        assert math.hypot(*one.local_m_s) == pytest.approx(one.size_m_s, abs=1e-9)
    page = burns.section(instance, plan, burns.impulses(plan, (), refined))
    assert page.count("<tr data-of=") == len(found) + sum(len(leg.impulses) for leg in plan.legs)
    assert "<h3>Refined</h3>" in page


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.slow
def test_the_file_has_what_the_plan_has(tmp_path: Path) -> None:
    """Every burn in full precision with its times, and names as they are, whatever they hold."""
    from adr_opt.ui.report import write_report

    name = 'a "b", <i>&amp;</i>'
    instance = adr_opt.generate("tiny", 0)
    instance = instance.replace(
        targets=tuple(
            target.replace(name=f"{name} {at}") for at, target in enumerate(instance.targets)
        )
    )
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    write_report(instance, plan, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", options=("--disable-3d-apis",)) as tab:
        tab.open_report(tmp_path / "mission.html")
        tab.evaluate(
            "URL.createObjectURL = (blob) => { blob.text().then((text) => { window.file = text; });"
            " return '#'; };"
            "HTMLAnchorElement.prototype.click = function () { window.called = this.download; };"
            "document.getElementById('csv').click()"
        )
        text = tab.wait_for("window.file")
        assert tab.evaluate("window.called") == "tiny-000-burns.csv"
    header, *rows = csv.reader(io.StringIO(text, newline=""))
    assert tuple(header) == burns.COLUMNS
    every = [(n, leg, burn) for n, leg in enumerate(plan.legs, start=1) for burn in leg.impulses]
    assert len(rows) == len(every)
    for row, (number, leg, burn) in zip(rows, every, strict=True):
        assert row[:6] == [
            "planned",
            instance.chasers[0].name,
            str(number),
            leg.origin,
            leg.destination,
            burn.phase,
        ]
        assert float(row[6]) == burn.time_s
        said = (instance.epoch + timedelta(seconds=burn.time_s)).strftime("%Y-%m-%dT%H:%M:%S")
        assert re.sub(r"\.\d+Z$", "", row[7]) == said
        assert [float(value) for value in row[9:12]] == list(burn.delta_v_m_s)
        assert float(row[8]) == pytest.approx(burn.size_m_s, rel=1e-12)
