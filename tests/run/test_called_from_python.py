"""What functions take from Python and refuse in a sentence, and what methods say of themselves."""

from __future__ import annotations

import inspect
import json
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import adr_opt
from adr_opt.analysis import price
from adr_opt.common.errors import InputError
from adr_opt.problem.chasers import Chaser, Tank, TankByMass
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, options_of, spec


def test_an_instance_is_taken_by_its_file_and_by_its_content(tmp_path: Path) -> None:
    """Paths and dictionaries give what the instance gives that they hold."""
    instance = adr_opt.generate("tiny", 0)
    path = tmp_path / "tiny.json"
    instance.save(path)
    result = adr_opt.solve(instance, "greedy-guarded")
    assert result.plan is not None
    for given in (str(path), path, json.loads(path.read_text())):
        solved = adr_opt.solve(given, "greedy-guarded")
        assert solved.routes == result.routes
        assert adr_opt.check(given, result.plan) == ()
        assert adr_opt.bound(given, "routing-bound", time_limit=1).upper_bound >= result.objective
        assert adr_opt.Mission(given).instance == instance
        assert adr_opt.Timetable(given).instance == instance
        assert price(given, result.plan).holds


WRONG: dict[str, Callable[[], Any]] = {
    "instance of type int: give an Instance, the path": lambda: adr_opt.solve(3),  # type: ignore[arg-type]
    "nowhere.json: no such file": lambda: adr_opt.solve("nowhere.json"),
    "instance: field name: missing": lambda: adr_opt.solve({}),
    "instance: cannot be written as JSON": lambda: adr_opt.Mission({"name": {1}}),
    "Tank: field propellant_kg: unknown.*a tank is Tank.*or TankByMass": lambda: Tank(
        delta_v_m_s=3.0, propellant_kg=4.0
    ),
    "Tank: field delta_v_m_s: missing.*or TankByMass": lambda: Tank(),
    "Tank: field delta_v_m_s = -1.0: must be": lambda: Tank(delta_v_m_s=-1.0),
    "TankByMass: field isp_s: missing": lambda: TankByMass(dry_mass_kg=1.0, propellant_kg=2.0),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_what_is_wrong_is_said_in_one_sentence(sentence: str) -> None:
    """A call that cannot be meant raises an InputError that names what is wrong."""
    with pytest.raises(InputError, match=sentence) as caught:
        WRONG[sentence]()
    assert "\n" not in str(caught.value)


def test_a_file_still_names_the_tank_at_fault() -> None:
    """The sentence about a tank in a file says where it stands there."""
    content = json.loads(adr_opt.generate("tiny", 0).to_json())
    content["chasers"][0]["tank"] = {"delta_v_m_s": -1.0}
    with pytest.raises(InputError, match=r"field chasers\[0\].tank.delta_v_m_s = -1.0"):
        adr_opt.solve(content)
    chaser = adr_opt.generate("tiny", 0).chaser
    assert isinstance(chaser.replace(tank={"delta_v_m_s": 2.0}).tank, Tank)
    assert Chaser(**chaser.model_dump()) == chaser


@pytest.mark.parametrize("body", [-1, 8, 1.5, None, "moon"])
def test_a_timetable_refuses_strange_bodies(body: Any) -> None:
    """A number beyond the bodies is no body, and neither is a negative one."""
    timetable = adr_opt.Timetable(adr_opt.generate("tiny", 0))
    assert len(timetable.names) == 8
    for call in (timetable.lookup, timetable.connections):
        for pair in ((0, body), (body, 0)):
            with pytest.raises(InputError, match="is not in 'tiny-000'"):
                call(*pair, 0.0)


@pytest.mark.parametrize("time_s", [math.nan, math.inf, -1.0, "soon"])
def test_a_timetable_refuses_strange_times(time_s: Any) -> None:
    """A time is a finite number of seconds since the epoch."""
    timetable = adr_opt.Timetable(adr_opt.generate("tiny", 0))
    for name, call in (("time_s", timetable.lookup), ("after", timetable.connections)):
        with pytest.raises(InputError, match=f"{name} = .*: must be a finite number ≥ 0"):
            call(0, 1, time_s)


METHODS = [(group, name) for group in (PLANNERS, BOUNDS) for name in names(group)]


def test_reading_specifications_imports_no_planner() -> None:
    """What all methods can do is known before numba, OR-Tools, torch or a planner is imported."""
    code = (
        "import sys; from adr_opt.run import methods as m;"
        "[m.spec(n, g) for g in (m.PLANNERS, m.BOUNDS) for n in m.names(g)];"
        "heavy = {'numba', 'ortools', 'torch', 'solvers.planners', 'solvers.bounds'};"
        "sys.exit(','.join(sorted(heavy & set(sys.modules))) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("group", "name"), METHODS)
def test_specifications_say_what_methods_take(group: str, name: str) -> None:
    """Start plans, cores, chasers and options that need a table are as the method has them."""
    known, method = spec(name, group), get(name, group)
    parameters = inspect.signature(method).parameters
    options = {each.name for each in fields(options_of(method))}
    assert known.name == name
    assert known.starts == ("start" in parameters)
    assert known.uses_cores == ("jobs" in options)
    assert known.several == (next(iter(parameters)) == "problem")
    assert set(known.table_options) <= options
    assert set(known.practice.options) <= options
