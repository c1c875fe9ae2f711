"""Many rehearsals of a mission, in worlds of consecutive seeds, on one core or several."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

from ...common.clock import now_s
from ...common.errors import InputError
from ...common.stop import Proven, Stop
from ...judge.admit import AnyPlan, admit, admit_made
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...problem.support import refuse
from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from ...run.front import solve
from ...study import Place, Study, run
from .flight import FlownMission, rehearsed
from .intended import Intended, intended
from .mission_facts import FOLLOWS, MissionFacts
from .outcome import Rehearsal, outcome_of
from .policies import NEED_PLAN, policy_of
from .rehearsals import Rehearsals
from .worlds import InProcess, check_worlds, worlds_study

CHUNK = 50
"""Maximum number of rehearsals of a call to another process."""

PLANNING_S = 10.0
"""Time limit of the initial plan if none is given [s]."""

Told = Callable[[int, int], None]


class Setting(NamedTuple):
    """Common settings of all rehearsals.

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

    def study(self) -> Study[int, Rehearsal]:
        """The study whose rows are rehearsals, by the seeds of their worlds.

        Rows of policies that plan depend on the wall time of planners, too.
        """
        of = {
            "instance": self.instance.sha256,
            "plan": self.plan.legs_sha256,
            "uncertainty": self.uncertainty.to_json(),
            "policy": self.policy,
        }
        return worlds_study("rehearsals", _Flights(self).row, of, Rehearsal)


class _Flights(InProcess[Setting]):
    """Rehearsals flown in one process, with their shared data."""

    @cached_property
    def _planned(self) -> Intended:
        return intended(self.alone, self.setting.plan)

    def row(self, seed: int, place: Place) -> Rehearsal:
        """The rehearsal in the world of a seed."""
        return flown_in(self.facts(place), self._planned, self.setting, seed)[1]


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
        raise InputError(f"{path}: rehearsals in a file need a given plan; give one")
    began = now_s()
    setting = setting_of(instance, plan, uncertainty, policy)
    made = run(
        setting.study(),
        range(seed, seed + samples),
        path,
        jobs=jobs,
        cluster=cluster,
        stop=stop,
        told=told,
        most=CHUNK,
    )
    outcomes = tuple(made.values())
    return Rehearsals(
        instance, setting.plan, setting.uncertainty, policy, outcomes, now_s() - began
    )


def setting_of(
    instance: Instance, plan: AnyPlan | None, uncertainty: Uncertainty, policy: str
) -> Setting:
    """Common settings of all rehearsals, with an initial plan.

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
            raise InputError(f"policy {policy!r} follows a plan; give one")
        made = solve(instance, time_limit=PLANNING_S, stop=Proven()).plan
        if made is None:
            raise InputError(
                f"no plan of {instance.name!r} was found to start from; give one that 'solve' made"
            )
        begun = admit_made(instance, made)
    else:
        begun = admit(instance, plan)
    setting = Setting(instance, begun.plan, uncertainty, policy)
    intended(MissionFacts(instance), begun.plan)
    return setting


def flown_in(
    facts: MissionFacts, planned: Intended, setting: Setting, seed: int
) -> tuple[FlownMission, Rehearsal]:
    """One rehearsal, and its outcome."""
    world = DrawnWorld(setting.instance, setting.uncertainty, seed)
    policy = policy_of(setting.policy)(facts, planned, setting.uncertainty, 0)
    flown = rehearsed(facts, world, policy, planned.kits)
    keeps = setting.policy in NEED_PLAN
    return flown, outcome_of(facts, planned, flown, seed, keeps=keeps)
