"""Many rehearsals of a mission, in worlds of consecutive seeds, on one core or several."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from ...common.clock import now_s
from ...common.errors import InputError
from ...common.stop import Stop
from ...judge.admit import AnyPlan, admit, admit_made
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...problem.support import refuse
from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from ...run.front import solve
from .elsewhere import check_worlds, elsewhere, is_over
from .flight import FlownMission, rehearsed
from .ground import FOLLOWS, Ground
from .intended import Intended, intended
from .outcome import Rehearsal, outcome_of
from .policies import NEED_PLAN, policy_of
from .rehearsals import Rehearsals
from .rows_file import RowsFile

CHUNK = 50
"""Maximum number of rehearsals of a call elsewhere."""

PLANNING_S = 10.0
"""Limit of the plan that a policy begins with where none is given [s]."""

Told = Callable[[int, int], None]


class Setting(NamedTuple):
    """What all rehearsals have in common.

    Attributes
    ----------
    instance : Instance
    plan : Plan
    uncertainty : Uncertainty
    policy : str
    """

    instance: Instance
    plan: Plan
    uncertainty: Uncertainty
    policy: str

    @property
    def digest(self) -> str:
        """SHA-256 of everything that the outcomes are asked to depend on.

        Those of policies that plan depend on the wall time of planners, too.
        """
        parts = (
            self.instance.sha256,
            self.plan.legs_sha256,
            self.uncertainty.to_json(),
            self.policy,
        )
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def rehearse(  # noqa: PLR0913
    instance: Instance,
    plan: AnyPlan | None,
    uncertainty: Uncertainty,
    *,
    policy: str = "follow",
    samples: int = 1000,
    seed: int = 0,
    jobs: int = 1,
    cluster: str | None = None,
    path: str | os.PathLike[str] | None = None,
    stop: Stop | None = None,
    told: Told = lambda done, of: None,
) -> Rehearsals:
    """Rehearse a mission in worlds of consecutive seeds.

    Parameters
    ----------
    instance : Instance
    plan : Plan, Admitted or None
        Of this instance, without violations; None for a policy that plans, which then begins with
        a plan of "auto".
    uncertainty : Uncertainty
    policy : str
        "follow", "skip", "replan", "beam", "learned" (or "ppo"), or one that an installed
        package brings.
    samples : int
        Number of worlds.
    seed : int
        Of the first world.
    jobs : int
        Processes; 0 for one per core.
    cluster : str, optional
        Address of a Dask scheduler whose workers fly them instead.
    path : path, optional
        File of outcomes; those that are in it are not flown again. It needs a plan.
    stop : Stop, optional
        Ends early, with the rehearsals so far.
    told : callable
        Called with the number of rehearsals done and wanted.

    Raises
    ------
    InputError
        Something does not fit the instance, or the file.
    """
    check_worlds(samples, seed, jobs, cluster)
    if path is not None and plan is None:
        # The plan of "auto" depends on the wall time: another call would find another one.
        raise InputError(f"{path}: rehearsals of a file begin with a plan that is given; give one")
    began = now_s()
    setting = setting_of(instance, plan, uncertainty, policy)
    found: dict[int, Rehearsal] = {}
    file = None if path is None else RowsFile(path, setting.digest, Rehearsal)
    if file is not None:
        found = {each.seed: each for each in file.found}
    wanted = range(seed, seed + samples)
    left = [number for number in wanted if number not in found]
    for outcomes in _outcomes(setting, left, jobs, cluster, stop):
        if file is not None:
            file.append(outcomes)
        found |= {each.seed: each for each in outcomes}
        told(sum(number in found for number in wanted), samples)
    made = tuple(found[number] for number in wanted if number in found)
    return Rehearsals(instance, setting.plan, setting.uncertainty, policy, made, now_s() - began)


def setting_of(
    instance: Instance, plan: AnyPlan | None, uncertainty: Uncertainty, policy: str
) -> Setting:
    """What all rehearsals have in common, with a plan to begin with.

    Raises
    ------
    InputError
        Something does not fit the instance.
    """
    refuse(instance, FOLLOWS)
    uncertainty = uncertainty.of(instance)
    policy_of(policy)
    if plan is None:
        if policy in NEED_PLAN:
            raise InputError(f"policy {policy!r} keeps to a plan; give one")
        made = solve(instance, time_limit=PLANNING_S).plan
        if made is None:
            raise InputError(
                f"no plan of {instance.name!r} was found to begin with; give one that 'solve' made"
            )
        begun = admit_made(instance, made)
    else:
        begun = admit(instance, plan)
    setting = Setting(instance, begun.plan, uncertainty, policy)
    intended(Ground(instance), begun.plan)
    return setting


def flown_in(
    ground: Ground, planned: Intended, setting: Setting, seed: int
) -> tuple[FlownMission, Rehearsal]:
    """One rehearsal, and its outcome."""
    world = DrawnWorld(setting.instance, setting.uncertainty, seed)
    policy = policy_of(setting.policy)(ground, planned, setting.uncertainty, 0)
    flown = rehearsed(ground, world, policy, planned.kits)
    keeps = setting.policy in NEED_PLAN
    return flown, outcome_of(ground, planned, flown, seed, keeps=keeps)


def _outcomes(
    setting: Setting, seeds: Sequence[int], jobs: int, cluster: str | None, stop: Stop | None
) -> Iterator[list[Rehearsal]]:
    """Outcomes of seeds, a few at a time."""
    if jobs == 1 and cluster is None:
        ground = Ground(setting.instance)
        planned = intended(ground, setting.plan)
        for seed in seeds:
            if is_over(stop):
                return
            yield [flown_in(ground, planned, setting, seed)[1]]
        return
    yield from elsewhere(_flown_there, setting, seeds, CHUNK, (jobs, cluster), stop)


_mine: tuple[str, Ground, Intended] | None = None
"""Digest of this process's latest work, and what its rehearsals share."""


def _flown_there(setting: Setting, seeds: tuple[int, ...]) -> list[Rehearsal]:
    global _mine
    if _mine is None or _mine[0] != setting.digest:
        ground = Ground(setting.instance, cores=1)
        _mine = setting.digest, ground, intended(ground, setting.plan)
    _, ground, planned = _mine
    return [flown_in(ground, planned, setting, seed)[1] for seed in seeds]
