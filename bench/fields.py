"""Missions that several experiments measure on: drawn, changed, imported, and made ready."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

import adr_opt
from adr_opt import Instance, Plan
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_rows
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings

ROOT = Path(__file__).resolve().parents[1]
INSTANCES = ROOT / "instances"


def ready(instance: Instance) -> Problem:
    """The problem of an instance with all its timetables."""
    problem = problem_of(instance)
    for mission in problem.missions:
        mission.rules  # noqa: B018  builds the timetable
    return problem


def falling(instance: Instance, prizes: Sequence[float]) -> Instance:
    """The same with these prizes of each target, one after the other in equal parts of the time."""
    if not prizes:
        return instance
    part_s = instance.mission.duration_s / len(prizes)
    levels = tuple((part_s * (n + 1), prize) for n, prize in enumerate(prizes[:-1])) or None
    targets = (target.replace(prize=prizes[-1], prize_until=levels) for target in instance.targets)
    return instance.replace(targets=tuple(targets))


def numbers(text: str) -> list[float]:
    """Numbers as typed: ``2,1``; none of an empty text."""
    return [float(each) for each in text.split(",") if each]


def eccentric(instance: Instance, most: float, seed: int | Sequence[int]) -> Instance:
    """The field with eccentricities drawn up to some value, and perigees anywhere."""
    rng = np.random.default_rng(seed)
    targets = tuple(
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=most * float(rng.random()),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            )
        )
        for target in instance.targets
        if target.orbit is not None
    )
    return instance.replace(targets=targets)


def on_rows(targets: int, near: int = 30, seed: int = 0) -> Instance:
    """A day among scattered places, by given connections every twenty minutes to the nearest."""
    rng = np.random.default_rng([seed, targets])
    points = rng.uniform(0.0, np.sqrt(targets), (targets + 1, 2))
    leaves = np.arange(0.0, 86_400.0, 1200.0)
    parts = []
    for body, point in enumerate(points):
        apart = np.hypot(*(points - point).T)
        there = np.argsort(apart, kind="stable")[1 : near + 1]
        there = there[there > 0]
        takes = np.repeat(600.0 + 3000.0 * apart[there], leaves.size)
        departs = np.tile(leaves, there.size)
        ends = np.full(departs.size, body), np.repeat(there, leaves.size)
        parts.append((*ends, departs, departs + takes, takes / 100.0))
    names = ["depot", *(f"place-{place}" for place in range(1, targets + 1))]
    columns = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    rows = dict(zip(columns, map(np.concatenate, zip(*parts, strict=True)), strict=True))
    opens = rng.uniform(0.0, 60_000.0, targets)
    instance = Instance(
        name=f"rows-{targets}-{seed}",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="depot"),),
        targets=tuple(
            Target(name=name, prize=float(rng.integers(1, 51)), window_s=(at, at + 20_000.0))
            for name, at in zip(names[1:], opens.tolist(), strict=True)
        ),
        chasers=(
            Chaser(name="van", start=AtStation(station="depot"), tank=Tank(delta_v_m_s=5000.0)),
        ),
        mission=MissionSettings(duration_s=86_400.0, service_s=300.0, refuel_revolutions=0.0),
        transfer=TransferSettings(given=GivenFile(file="rows.parquet")),
    )
    return instance.with_given(of_rows(rows, names))


def like(what: str, seed: int) -> Instance:
    """A drawn field under J2 that is like objects of one origin.

    ``Cosmos 2251``: the other cloud of the collision that the family ``cloud`` is drawn from, of
    the same shape and 12.4° less inclined. ``SL-8``: stages of 930 to 990 km with eccentricities up
    to 0.004, their planes as wide.
    """
    field, rng = adr_opt.generate("cloud", seed), np.random.default_rng(seed)

    def moved(orbit: Orbit) -> Orbit:
        if what == "Cosmos 2251":
            return orbit.replace(inclination_deg=orbit.inclination_deg - 12.4)
        return orbit.replace(
            semi_major_axis_m=EARTH_RADIUS_M + 1e3 * float(rng.uniform(930.0, 990.0)),
            inclination_deg=float(rng.uniform(82.9, 83.0)),
            eccentricity=0.004 * float(rng.random()),
        )

    (station,) = field.stations
    home = station.orbit.replace(inclination_deg=74.04 if what == "Cosmos 2251" else 82.95)
    return field.replace(
        name=f"{what}-like {seed}",
        dynamics="j2",
        stations=(station.replace(orbit=home),),
        targets=tuple(
            target.replace(orbit=moved(target.orbit))
            for target in field.targets
            if target.orbit is not None
        ),
    )


def imported(catalogue: Path, options: str) -> Instance:
    """An instance that the verb ``import`` makes of a catalogue."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "instance.json"
        command = [sys.executable, "-m", "adr_opt", "import", str(catalogue), "--quiet"]
        subprocess.run([*command, *options.split(), "--out", str(out)], check=True)
        return adr_opt.load(out)


def external(*patterns: str) -> list[Path]:
    """Files of the folder that the variable ADR_OPT_EXTERNAL_DATA names, by patterns.

    Raises
    ------
    InputError
        The variable names no folder.
    """
    folder = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ""))
    if folder == Path() or not folder.is_dir():
        raise InputError("ADR_OPT_EXTERNAL_DATA names no folder of catalogues")
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


def best_known() -> dict[str, dict[str, str]]:
    """The rows of ``instances/best-known.csv`` by instance."""
    with (INSTANCES / "best-known.csv").open(newline="", encoding="utf-8") as file:
        return {each["instance"]: each for each in csv.DictReader(file)}


def best_plan(name: str, limit_s: float = 60.0) -> Plan:
    """The plan of a committed instance that is kept whole, or one by ``auto`` of a drawn one."""
    path = INSTANCES / "best-known" / f"{name}.json"
    if path.exists():
        return adr_opt.load_plan(path)
    family, _, seed = name.rpartition("-")
    return planned(adr_opt.generate(family, int(seed)), "auto", limit_s)


def planned(instance: Instance, method: str = "greedy-guarded", limit_s: float = 100.0) -> Plan:
    """The plan of a method; there must be one."""
    plan = adr_opt.solve(instance, method, time_limit=limit_s, seed=0).plan
    assert plan is not None
    return plan
