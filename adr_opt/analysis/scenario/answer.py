"""Results of a scenario: means over seeds as plain data, and tables for other programs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...problem.air import FLOAT
from ...sources.csv_table import csv_text
from .futures import CASES, Scenario, YearRecord
from .settings import FRAGMENTS, KINDS

SPECIES = {"payload": "S", "rocket body": "B", "debris": "N"}
"""Names of species in the table of removals by default, as pySSEM's own examples have them."""

SUMS = (
    "objects",
    "fragments",
    "encounters",
    "catastrophic",
    "expected_fragments",
    "fragment_encounters",
    "fragment_catastrophic",
    "collisions",
    "explosions",
    "removed",
    "void",
    "decayed",
    "launched",
)
"""Counts recorded for each year."""

RUNNING = {"catastrophic": "catastrophic_before", "expected_fragments": "expected_fragments_before"}
"""Expected counts of a year → names of their sums over all years before."""

TOLD = (*SUMS, *RUNNING.values())
"""Counts reported for each year."""

REMOVALS = (
    "year",
    "species",
    "shell",
    "shell_low_km",
    "shell_high_km",
    "removed",
    "standard_error",
    "control",
)

YEARLY = (
    "year",
    "case",
    "species",
    "shell",
    "shell_low_km",
    "shell_high_km",
    "number",
    "standard_error",
)


def numbers_of(record: YearRecord) -> tuple[float, ...]:
    """Counts of a year by the names of :data:`SUMS`."""
    return (
        float(np.sum(record.objects)),
        math.fsum(record.fragments),
        *record.rates,
        *record.took_place,
        len(record.removed),
        record.void,
        record.decayed,
        record.launched,
    )


def mean_and_error(values: FLOAT) -> tuple[FLOAT, FLOAT | None]:
    """Mean over the first axis, and its standard error; None of a single value."""
    count = len(values)
    # From the first value, so that equal ones have no error to the last bit.
    less = values - values[0]
    mean: FLOAT = values[0] + less.mean(axis=0)
    if count < 2:
        return mean, None
    error: FLOAT = less.std(axis=0, ddof=1) / math.sqrt(count)
    return mean, error


def table_of(made: Scenario, case: str) -> FLOAT:
    """Counts of all futures by the names of :data:`TOLD`, shape (seed, year + 1, count)."""
    table = np.array([[numbers_of(record) for record in each[case]] for each in made.futures])
    running = table[..., [SUMS.index(name) for name in RUNNING]]
    before = np.zeros_like(running)
    before[:, 1:] = np.cumsum(running, axis=1)[:, :-1]
    return np.concatenate((table, before), axis=2)


def scenario_answer(made: Scenario) -> dict[str, Any]:
    """The answer as plain data: each number as its mean over seeds and the standard error."""
    start, settings = made.start, made.start.settings
    tables = {case: table_of(made, case) for case in CASES}
    cases = {case: _told(tables[case]) for case in CASES}
    # Seeds in common: the differences scatter less than what they are differences of.
    less = _told(tables["with"] - tables["without"])
    removed = np.array([len(_removals(each)) for each in made.futures], dtype=float)
    return {
        "epoch": start.epoch.isoformat(),
        "objects": len(start.population),
        "left_out": made.left_out,
        "settings": settings.to_dict(),
        "campaign": None if start.template is None else start.template.name,
        "years": list(range(settings.years + 1)),
        "shells_km": settings.shells.edges_km.tolist(),
        "species": [*KINDS, FRAGMENTS],
        **cases,
        "difference": less,
        "sums": {case: _summed(tables[case]) for case in CASES}
        | {"difference": _summed(tables["with"] - tables["without"])},
        "removed": _pair(removed),
        "campaigns": [_campaigns(made, year) for year in range(settings.years)],
    }


def _told(table: FLOAT) -> dict[str, Any]:
    mean, error = mean_and_error(table)
    return {
        name: {
            "mean": mean[:, at].tolist(),
            "standard_error": None if error is None else error[:, at].tolist(),
        }
        for at, name in enumerate(TOLD)
    }


def _summed(table: FLOAT) -> dict[str, Any]:
    """Sums over the years, the final state excluded."""
    return {
        name: _pair(table[:, :-1, at].sum(axis=1))
        for at, name in enumerate(SUMS)
        if name not in ("objects", "fragments")
    }


def _pair(values: FLOAT) -> dict[str, float | None]:
    mean, error = mean_and_error(values)
    return {"mean": float(mean), "standard_error": None if error is None else float(error)}


def _campaigns(made: Scenario, year: int) -> dict[str, Any]:
    """Campaigns launched in a year: sums over seeds, and the objects of the first seed."""
    every = [each["with"][year].campaign for each in made.futures]
    flown = [each for each in every if each is not None]
    first = every[0]
    return {
        "year": year,
        "flown": len(flown),
        "failed": sum(each.failed for each in flown),
        "replanned": sum(each.replanned for each in flown),
        "captured": sum(attempt.succeeded for each in flown for attempt in each.attempts),
        "missed": sum(not attempt.succeeded for each in flown for attempt in each.attempts),
        "avoided": sum(
            attempt.prize for each in flown for attempt in each.attempts if attempt.succeeded
        ),
        "of_first_seed": []
        if first is None
        else [
            {
                "object": each.name,
                "day": each.time_s / 86400.0,
                "succeeded": each.succeeded,
                "fragment_years": each.prize,
            }
            for each in first.attempts
        ],
    }


def _removals(each: Mapping[str, Sequence[YearRecord]]) -> list[tuple[int, int, int]]:
    """Year, kind and shell of all removals of a future."""
    return [
        (year, kind, shell)
        for year, record in enumerate(each["with"])
        for _, kind, shell in record.removed
    ]


def removals_csv(made: Scenario, species: Mapping[str, str] = SPECIES) -> str:
    """Removals by year, species and shell, as input to a shell-based environment model.

    Parameters
    ----------
    made : Scenario
    species : mapping of str to str
        Kind of object → name of the species there, which may be that of several kinds.

    Returns
    -------
    str
        CSV under :data:`REMOVALS`, a line for each year, species and shell of which something is
        removed; shells are numbered from 1, and ``control`` is the name of pySSEM's control of
        that species and shell. Removals outside all shells are not in it.
    """
    settings = made.start.settings
    count = len(made.futures)
    names = list(dict.fromkeys(species[kind] for kind in KINDS))
    found = np.zeros((count, settings.years + 1, len(names), settings.shells.count + 2))
    for seed, each in enumerate(made.futures):
        for year, kind, shell in _removals(each):
            found[seed, year, names.index(species[KINDS[kind]]), shell] += 1.0
    mean, error = mean_and_error(found[..., 1:-1])
    edges = settings.shells.edges_km
    rows: list[tuple[object, ...]] = []
    for year, at, shell in zip(*np.nonzero(mean), strict=True):
        name = names[at]
        rows.append(
            (
                year,
                name,
                shell + 1,
                f"{edges[shell]:g}",
                f"{edges[shell + 1]:g}",
                f"{mean[year, at, shell]:.8g}",
                "" if error is None else f"{error[year, at, shell]:.3g}",
                f"u_r_{name}{shell + 1}",
            )
        )
    return csv_text(REMOVALS, rows)


def outside(made: Scenario) -> int:
    """Number of removals outside all shells, summed over seeds."""
    last = made.start.settings.shells.count + 1
    every = [row for each in made.futures for row in _removals(each)]
    return sum(shell in (0, last) for _, _, shell in every)


def yearly_csv(made: Scenario) -> str:
    """Objects and fragments at the beginning of each year, by case, species and shell.

    Returns
    -------
    str
        CSV under :data:`YEARLY`; the shell 0 is all below the first, and the last one all above.
    """
    shells = made.start.settings.shells
    edges = ["", *(f"{edge:g}" for edge in shells.edges_km), ""]
    rows: list[tuple[object, ...]] = []
    for case in CASES:
        counts = np.array(
            [
                [[*record.objects, record.fragments] for record in each[case]]
                for each in made.futures
            ],
            dtype=float,
        )
        mean, error = mean_and_error(counts)
        for year, kind, shell in np.ndindex(*mean.shape):
            if mean[year, kind, shell] > 0.0:
                rows.append(
                    (
                        year,
                        case,
                        (*KINDS, FRAGMENTS)[kind],
                        shell,
                        edges[shell],
                        edges[shell + 1],
                        f"{mean[year, kind, shell]:.8g}",
                        "" if error is None else f"{error[year, kind, shell]:.3g}",
                    )
                )
    return csv_text(YEARLY, rows)
