"""Fields held back from training, and what a policy collects there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from ..kernels.episodes import episodes as kernels
from ..kernels.episodes import worlds as world_kernels
from ..mission.mission import Mission
from ..plan.plan import Plan
from ..problem.instance import Instance
from ..problem.uncertainty import Uncertainty
from ..sources.generator import family, generate
from .decoding import pick
from .episodes import (
    Board,
    FieldPool,
    UncertainPool,
    begin_in_worlds,
    new_episodes,
    new_worlds,
    start,
)

FAMILIES = ("nominal", "reduced-time", "reduced-fuel")

HELD_SEED, HELD_FIELDS = 900_000, 24
"""First seed and number of the fields by which trainings are watched."""


def chaser_by_chaser(instance: Instance, plans: Sequence[Plan]) -> Iterator[Mission]:
    """Missions of the chasers of an instance in turn, each with the targets that are left.

    Parameters
    ----------
    instance : Instance
    plans : sequence of Plan
        Of the missions so far, added to by who asks for the next one.
    """
    for chaser in instance.chasers:
        gone = {name for plan in plans for name in plan.destinations}
        left = tuple(target for target in instance.targets if target.name not in gone)
        if left:
            yield Mission(instance.replace(chasers=(chaser,), targets=left), threads=1)


class HeldFields:
    """Fields with their timetables, one pool for the three benchmark families, or of another one.

    Parameters
    ----------
    first, count : int
        First seed, and number.
    kind : str
        Family that fields are drawn from. Its chasers are alike, and play one after another.
    """

    def __init__(
        self, first: int = HELD_SEED, count: int = HELD_FIELDS, kind: str = "nominal"
    ) -> None:
        drawn = (generate(kind, first + at, chasers=1) for at in range(count))
        missions = [Mission(instance, threads=1) for instance in drawn]
        self._chasers = family(kind).chasers
        events = max(mission.timetable.most_events for mission in missions)
        self._first, self._bodies, self._count = first, len(missions[0].names), count
        self.pool = FieldPool(count, self._bodies, events)
        for slot, mission in enumerate(missions):
            self.pool.install(slot, mission)

    def visits(
        self,
        choose: Callable[[Board], npt.NDArray[np.int64]],
        observation: str = "choices",
        families: tuple[str, ...] = FAMILIES,
        model: Uncertainty | None = None,
    ) -> dict[str, npt.NDArray[np.int64]]:
        """Visits on each field in each family, with the moves that are chosen.

        Parameters
        ----------
        choose : callable
            Gives the actions for a board.
        observation : str
        families : tuple of str
            Families whose ΔV budget and duration the missions have.
        model : Uncertainty, optional
            Model of the uncertain worlds that they are played in, one for each field.
        """
        count = len(families) * self._count
        visited, serviced = np.zeros((count, self._bodies), dtype=np.bool_), np.zeros(count, int)
        for _ in range(self._chasers):
            episodes = new_episodes(count, self._bodies)
            for at, name in enumerate(np.repeat(families, self._count).tolist()):
                limits = family(name)
                given = limits.delta_v_m_s, limits.duration_s
                start(self.pool, episodes, at, at % self._count, *given)
            episodes.visited[:] |= visited
            worlds = None if model is None else self._worlds(model, episodes)
            serviced += self._played(choose, observation, episodes, worlds, visited)
        return dict(zip(families, serviced.reshape(len(families), -1), strict=True))

    def _played(
        self,
        choose: Callable[[Board], npt.NDArray[np.int64]],
        observation: str,
        episodes: kernels.Episodes,
        worlds: world_kernels.Worlds | None,
        visited: npt.NDArray[np.bool_],
    ) -> npt.NDArray[np.int32]:
        """Visits of one chaser in each episode; what is visited then is written."""
        running, serviced = np.arange(episodes.slot.size), np.zeros_like(episodes.serviced)
        while running.size:
            board = Board(observation, running.size, self._bodies - 1)
            board.observe(self.pool.arrays, episodes, 0, running.size, worlds)
            alive = board.legal > 0
            serviced[running], visited[running] = episodes.serviced, episodes.visited
            if alive.all():
                rewards = np.zeros(running.size, dtype=np.float32)
                taken = 0, running.size, choose(board), rewards
                if worlds is None:
                    kernels.act(self.pool.arrays, episodes, *taken)
                else:
                    world_kernels.act_in_worlds(
                        self.pool.arrays, episodes, worlds, *taken, board.order
                    )
            else:
                running, rows = running[alive], np.flatnonzero(alive)
                episodes = pick(episodes, rows)
                if worlds is not None:
                    worlds = worlds._replace(states=pick(worlds.states, rows))
        return serviced

    def _worlds(self, model: Uncertainty, episodes: kernels.Episodes) -> world_kernels.Worlds:
        uncertain, count = UncertainPool(self.pool, [model]), episodes.slot.size
        for slot in range(self._count):
            uncertain.install(slot)
        worlds, which = new_worlds(uncertain, count), np.arange(count, dtype=np.int32)
        drawn = self._first + episodes.slot, np.zeros(count, dtype=np.int32)
        begin_in_worlds(self.pool, episodes, worlds, which, drawn)
        return worlds

    def means(
        self, choose: Callable[[Board], npt.NDArray[np.int64]], observation: str = "choices"
    ) -> dict[str, float]:
        """Mean visits in each family."""
        return {name: float(of.mean()) for name, of in self.visits(choose, observation).items()}
