"""Runs of a scenario over seeds, in this process or several (docs/scenarios.md)."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from datetime import datetime
from itertools import takewhile

from ...common.errors import InputError
from ...common.processors import usable_cores
from ...problem.instance import Instance
from ...run.method_call import spec_of
from ...sources.worth.bodies import Bodies
from ...study import Place, Run
from .futures import Scenario, ScenarioStart
from .launches import Launch
from .offer import check_template
from .population import population_of
from .records import CASES
from .settings import ScenarioSettings
from .years import Records, Year, Years, file_in

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
        Of a file of years, from which a later call goes on, and a folder of instances and plans.
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
