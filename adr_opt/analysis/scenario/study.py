"""Runs of a scenario over seeds, in this process or several (docs/scenarios.md)."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import datetime

from ...common.errors import InputError
from ...common.processors import usable_cores
from ...problem.instance import Instance
from ...run.method_call import spec_of
from ...sources.worth.bodies import Bodies
from .branch import Branch
from .campaign import campaign
from .futures import Future, Scenario, ScenarioStart
from .launches import Launch
from .offer import check_template
from .population import population_of
from .records import CASES, YearRecord
from .settings import ScenarioSettings
from .years_file import YearsFile

Show = Callable[[int, int], None]


def scenario(
    bodies: Bodies,
    template: Instance | None,
    settings: ScenarioSettings,
    *,
    launches: Sequence[Launch] = (),
    epoch: datetime | None = None,
    folder: str | os.PathLike[str] | None = None,
    jobs: int = 1,
    show: Show = lambda done, of: None,
) -> Scenario:
    """Futures of a catalogue with campaigns and without, over several seeds.

    Parameters
    ----------
    bodies : Bodies
        Objects of a catalogue, with masses and sizes.
    template : Instance or None
        Campaign that is repeated; of its targets only the kind of service counts. None for none.
    settings : ScenarioSettings
    launches : sequence of Launch
    epoch : datetime, optional
        Of year 0; by default the latest of the element sets.
    folder : path, optional
        Where each seed has a file of its years, from which a later call goes on, and a folder of
        instances and plans.
    jobs : int
        Number of processes, a seed in each; with one seed, of threads; 0 for all cores.
    show : callable
        Told of the numbers of finished years and of all.

    Raises
    ------
    InputError
        A value is out of range, the template cannot be repeated, or a file does not belong here.
    MissingExtra
        sgp4 is not installed.
    """
    if jobs < 0:
        raise InputError(f"--jobs {jobs}: must be at least 0, for all cores")
    if template is not None:
        check_template(template)
    spec_of(settings.method)
    if not len(bodies):
        raise InputError("0 objects in orbit: collisions take two; give a larger catalogue")
    epoch = epoch or max(record.epoch for record in bodies.records)
    population, left_out = population_of(bodies, epoch)
    start = ScenarioStart(population, epoch, template, tuple(launches), settings)
    digest = digest_of(start)
    files = [
        None if folder is None else YearsFile(folder, seed, digest)
        for seed in range(settings.seeds)
    ]
    of = settings.seeds * (settings.years + 1)
    jobs = jobs or usable_cores()
    if jobs == 1 or settings.seeds == 1:
        futures = []
        for seed, file in enumerate(files):
            done = seed * (settings.years + 1)

            def told(year: int, done: int = done) -> None:
                show(done + year, of)

            futures.append(future(start, seed, file, jobs, told))
    else:
        # A fork of a process with threads may wait for a lock that is never released.
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(jobs, settings.seeds), context) as pool:
            calls = [pool.submit(future, start, seed, file, 1) for seed, file in enumerate(files)]
            futures = []
            for seed, call in enumerate(calls):
                futures.append(call.result())
                show((seed + 1) * (settings.years + 1), of)
    return Scenario(start, tuple(futures), left_out)


def future(
    start: ScenarioStart,
    seed: int,
    file: YearsFile | None,
    jobs: int,
    told: Callable[[int], None] = lambda year: None,
) -> Future:
    """Both cases of one seed."""
    branches = {case: Branch.of(start, seed, campaign, removes=case == "with") for case in CASES}
    if file is not None:
        branches["with"].keep = file.keep
    made: Future = {case: [] for case in CASES}
    found = [] if file is None else file.found[: start.settings.years + 1]
    for year in range(start.settings.years + 1):
        known = found[year] if year < len(found) else None
        records, before = dict[str, YearRecord](), None
        for case, branch in branches.items():
            records[case] = branch.live(None if known is None else known[case], before, jobs)
            before = branch
        if file is not None and known is None:
            file.append(records)
        for case, record in records.items():
            made[case].append(record)
        told(year + 1)
    return made


def digest_of(start: ScenarioStart) -> str:
    """SHA-256 of all that futures depend on, but for the number of seeds and versions."""
    content = start.settings.to_dict()
    del content["seeds"]
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    digest.update(start.epoch.isoformat().encode())
    digest.update(b"" if start.template is None else start.template.sha256.encode())
    digest.update(repr(start.launches).encode())
    population = start.population
    for column in (
        population.numbers,
        population.orbits,
        population.bodies.masses,
        population.bodies.sizes,
        population.bodies.areas,
    ):
        digest.update(column.tobytes())
    digest.update(repr(population.bodies.kinds).encode())
    return digest.hexdigest()
