"""Runs of a scenario over seeds, in this process or several (docs/scenarios.md).

The rows are years of futures. A killed run goes on from its file: plans, rates and draws of its
years are taken from there, and all that follows from them is worked out again and has to agree.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from datetime import datetime
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

from ...common.errors import InputError
from ...common.files import write_both
from ...common.processors import usable_cores
from ...problem.instance import Instance
from ...run.method_call import spec_of
from ...sources.worth.bodies import Bodies
from ...study import Place, Run, Study
from .branch import Branch
from .campaign import campaign, check_template
from .futures import CASES, Scenario, ScenarioStart, YearRecord, records_of
from .launches import Launch
from .population import population_of
from .settings import ScenarioSettings

PLANS = "plans"
"""Subfolder of campaigns' instances and plans."""

FILE = "years.jsonl"
"""Name of the file with all years of all seeds."""

Records = dict[str, YearRecord]
"""The records of a year, by case."""


class Year(NamedTuple):
    """A year of the futures of a seed."""

    seed: int
    year: int


class Years:
    """Years of a scenario, each computed after the previous ones.

    Parameters
    ----------
    start : ScenarioStart
    folder : path, optional
        For instances and plans of campaigns.
    threads : int
        Where no other years are lived beside these.
    known : dict of int to sequence of records
        Years of each seed from an earlier run, from the first one.
    """

    def __init__(
        self,
        start: ScenarioStart,
        folder: str | os.PathLike[str] | None,
        threads: int,
        known: dict[int, Sequence[Records]] | None = None,
    ) -> None:
        self._start, self._folder, self._threads = start, folder, threads
        self.known = known or {}
        self._at: Year | None = None
        self._branches: dict[str, Branch] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        # Another process lives through the years before its own.
        return Years, (self._start, self._folder, self._threads, self.known)

    def study(self) -> Study[Year, Records]:
        """The study whose rows are these years."""
        return Study(
            "scenario",
            1,
            self.row,
            digests_of(self._start),
            key=Year._asdict,
            to_json=lambda year: {case: record.to_dict() for case, record in year.items()},
            from_json=lambda year, row: records_of(json.dumps(row).encode()),
        )

    def row(self, key: Year, place: Place) -> Records:
        """The records of a year in both cases."""
        self.go_to(key, place)
        return self._live(None, place)

    def go_to(self, key: Year, place: Place) -> None:
        """Simulate all years of a seed before a given one.

        Raises
        ------
        InputError
            A known year is not of this scenario.
        """
        if self._at is None or self._at.seed != key.seed or self._at.year > key.year:
            self._at = Year(key.seed, 0)
            self._branches = {
                case: Branch.of(self._start, key.seed, campaign, removes=case == "with")
                for case in CASES
            }
            self._branches["with"].keep = self._keep
        known = self.known.get(key.seed, ())
        while self._at.year < key.year:
            at = self._at.year
            self._live(known[at] if at < len(known) else None, place)

    def _live(self, known: Records | None, place: Place) -> Records:
        assert self._at is not None
        records, before = Records(), None
        for case, branch in self._branches.items():
            threads = self._threads if place.alone else 1
            records[case] = branch.live(None if known is None else known[case], before, threads)
            before = branch
        self._at = Year(self._at.seed, self._at.year + 1)
        return records

    def _keep(self, year: int, instance: str, plan: str) -> None:
        """Write the instance of a campaign and its first plan, for other verbs.

        Raises
        ------
        InputError
            They cannot be written.
        """
        if self._folder is None or self._at is None:
            return
        folder = Path(self._folder) / PLANS
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{folder}: cannot be created ({error.strerror or error}); name another folder"
            ) from error
        stem = f"seed-{self._at.seed}-year-{year}"
        write_both(folder / f"{stem}.plan.json", plan, folder / f"{stem}.json", instance)


def file_in(folder: str | os.PathLike[str]) -> Path:
    """The file of years in a folder, which is created if missing.

    Raises
    ------
    InputError
        It cannot be made, or has files of adr-opt 1.0.
    """
    path = Path(folder) / FILE
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({error.strerror or error}); name another folder"
        ) from error
    if not path.exists() and (path.parent / "seed-0.jsonl").exists():
        raise InputError(
            f"{folder}: has files of adr-opt 1.0, which this version cannot resume; name another "
            "folder"
        )
    return path


def digests_of(start: ScenarioStart) -> dict[str, str | None]:
    """SHA-256 of everything on which futures depend, except the number of seeds and versions."""
    settings = start.settings.to_dict()
    del settings["seeds"]
    population, template = start.population, start.template
    bodies = population.bodies
    columns = population.numbers, population.orbits, bodies.masses, bodies.sizes, bodies.areas
    catalogue = [column.tobytes() for column in columns]
    return {
        "settings": _digest(json.dumps(settings, sort_keys=True).encode()),
        "campaign": None if template is None else template.sha256,
        "launches": _digest(repr(start.launches).encode()),
        "catalogue": _digest(
            start.epoch.isoformat().encode(), *catalogue, repr(bodies.kinds).encode()
        ),
    }


def _digest(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


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
        For a file of years, from which a later call resumes, and for instances and plans.
    jobs : int
        Number of processes, a seed in each; with one seed, of threads; 0 for all cores.
    show : callable
        Called with the numbers of finished years and of all.

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
        raise InputError("0 objects in orbit: a collision needs two; give a larger catalogue")
    epoch = epoch or max(record.epoch for record in bodies.records)
    population, left_out = population_of(bodies, epoch)
    start = ScenarioStart(population, epoch, template, tuple(launches), settings)
    jobs = jobs or usable_cores()
    wanted = [
        [Year(seed, year) for year in range(settings.years + 1)] for seed in range(settings.seeds)
    ]
    years = Years(start, folder, jobs)
    path = None if folder is None else file_in(folder)
    beside = 1 if settings.seeds == 1 else min(jobs, settings.seeds)
    found, of = dict[Year, Records](), sum(map(len, wanted))
    with Run(years.study(), path, jobs=beside) as running:
        for each in wanted:
            known = takewhile(lambda year: year is not None, map(running.known, each))
            years.known[each[0].seed] = [year for year in known if year is not None]
            years.go_to(each[0]._replace(year=len(years.known[each[0].seed])), Place())
        for key, records in running.rows(map(tuple, wanted)):
            found[key] = records
            show(len(found), of)
    futures = [{case: [found[key][case] for key in each] for case in CASES} for each in wanted]
    return Scenario(start, tuple(futures), left_out)
