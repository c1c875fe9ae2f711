"""Many missions at once, as a vectorised environment of Stable-Baselines3."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvStepReturn

from ...common.errors import InputError
from ...kernels.episodes import episodes as kernels
from ...kernels.episodes import worlds as world_kernels
from ...kernels.episodes.episodes import BODIES
from ...mission.mission import Mission
from ...problem.instance import AnyInstance, Instance, instance_of
from ..episodes import (
    AnyUncertainty,
    Board,
    Observation,
    UncertainPool,
    begin_in_worlds,
    models_of,
    new_episodes,
    new_worlds,
)
from .drawn import ready, work_out
from .fields import PUBLISHED, Alone, AnyFields, Fields, fields_of
from .last_words import last_words
from .played_world import LAST_WORLD
from .spaces import space

MOST_REDRAWS = 1000

FEW = 32
"""Number of missions up to which a second thread does not pay."""


class MissionVecEnv(VecEnv):
    """Hundreds of missions at once, stepped by kernels on a pool of timetables.

    The same rules, observations and rewards as ``adr_opt/Mission-v0``, and with ``uncertainty`` as
    ``adr_opt/UncertainMission-v0``. Fields with fewer targets
    than the largest leave the last target actions without use; the station is always the last
    action. An episode that ends is followed by a new one at once, as Stable-Baselines3 expects;
    ``info["terminal_observation"]`` holds what was seen last.

    Parameters
    ----------
    count : int
        Missions at once.
    fields : Fields, str, dict, or a sequence of Fields
        Where fields, budgets and durations are drawn from; of several distributions, slots of the
        pool have one each in turn. Missions with several chasers are played chaser by chaser: an
        episode is that of one, and the next one finds the targets that are left.
    instance : Instance, path or dict, optional
        Play this one, in a pool of one slot, in place of drawn ones.
    observation : str
        One of :data:`adr_opt.learning.episodes.OBSERVATIONS`.
    slots : int
        Fields in the pool.
    refresh_every : int
        One field is replaced after this number of steps of single missions, counted over
        all of them; 0 keeps the pool. A field leaves when the last mission on it is over, and one
        after the other, so it may take longer. The new one is worked out in the background while
        missions go on, and waited for if it is late, so that a seed determines everything.
    threads : int
        Threads that work out the pool and step the missions; nothing depends on their number.
    reward_scale : float
        Factor of every reward.
    seed : int
        Seed of all draws; fields and limits do not depend on the uncertainty.
    uncertainty : Uncertainty, path or dict, or a sequence of them, optional
        Missions are played in uncertain worlds of this model; of several, each draws one.

    Attributes
    ----------
    threads : int
        May be lowered at any time.
    pool : FieldPool
    episodes : Episodes
        The states of the missions, see :class:`adr_opt.kernels.episodes.episodes.Episodes`.
    worlds : Worlds or None
        Their worlds, where these are uncertain.

    Raises
    ------
    InputError
        A number out of range, or an unknown observation.
    """

    def __init__(  # noqa: PLR0913
        self,
        count: int = 256,
        fields: AnyFields | Sequence[Fields] = PUBLISHED,
        *,
        instance: AnyInstance | None = None,
        observation: str = "choices",
        slots: int = 64,
        refresh_every: int = 0,
        threads: int = 1,
        reward_scale: float = 1.0,
        seed: int = 0,
        uncertainty: AnyUncertainty | Sequence[AnyUncertainty] | None = None,
    ) -> None:
        for name, value, least in (
            ("count", count, 1),
            ("slots", slots, 2 if refresh_every else 1),
            ("refresh_every", refresh_every, 0),
            ("threads", threads, 1),
            ("seed", seed, 0),
        ):
            if not isinstance(value, (int, np.integer)) or value < least:
                raise InputError(f"{name} = {value!r}: must be a whole number from {least} on")
        if not math.isfinite(reward_scale):
            raise InputError(f"reward_scale = {reward_scale!r}: must be a finite number")
        self.kinds: tuple[Fields | Alone, ...]
        if isinstance(fields, str) or not isinstance(fields, Sequence):
            self.kinds = (fields_of(fields),)
        else:
            self.kinds = tuple(map(fields_of, fields))
        if instance is not None:
            self.kinds, slots, refresh_every = (Alone(instance_of(instance)),), 1, 0
        if not 1 <= len(self.kinds) <= slots:
            raise InputError(
                f"fields: {len(self.kinds)} distributions do not fit a pool of {slots} slots"
            )
        if len({each.drifts for each in self.kinds}) > 1:
            raise InputError("fields: give distributions that all have the same dynamics")
        self._models = models_of(uncertainty)
        self._targets = max(each.most_targets for each in self.kinds)
        self.render_mode = None
        super().__init__(
            count, space(observation, self._targets), spaces.Discrete(self._targets + 1)
        )
        # Two boards in turn: what a step returned stays as it is while the next step is taken.
        self._board = Board(observation, count, self._targets)
        self._other = Board(observation, count, self._targets)
        self._rewards = np.zeros(count, dtype=np.float32)
        self._scale = np.float32(reward_scale)
        self._refresh_every = refresh_every
        self._slots = slots
        self.threads = threads
        self._start_threads()
        self._actions: npt.NDArray[np.int64] | None = None
        self._coming: Future[Mission] | None = None
        self._awaited: Instance | None = None
        self._begin(seed)

    def _start_threads(self) -> None:
        self._workers = ThreadPoolExecutor(self.threads, thread_name_prefix="missions")
        self._builder = ThreadPoolExecutor(1, thread_name_prefix="fields")

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_workers": None, "_builder": None, "_coming": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._start_threads()
        if self._awaited is not None:
            self._coming = self._builder.submit(ready, self._awaited)

    def _begin(self, seed: int) -> None:
        """Draw the pool and all other data that depend on a seed."""
        if self._coming is not None:
            self._coming.result()
        field_seed, episode_seed, world_seed = np.random.SeedSequence(seed).spawn(3)
        self._field_rng = np.random.default_rng(field_seed)
        self._rng = np.random.default_rng(episode_seed)
        self._world_rng = np.random.default_rng(world_seed)
        instances = [self._draw_field(slot) for slot in range(self._slots)]
        self.pool = work_out(instances, self._targets + 1, self._workers)
        self.episodes = new_episodes(self.num_envs, self._targets + 1)
        self.episodes.slot[:] = -1
        self._next_chasers = np.zeros(self.num_envs, dtype=np.int64)
        self._uncertain: UncertainPool | None = None
        self.worlds: world_kernels.Worlds | None = None
        if self._models:
            self._uncertain = UncertainPool(self.pool, self._models)
            for slot in range(self._slots):
                self._uncertain.install(slot)
            self.worlds = new_worlds(self._uncertain, self.num_envs)
        self._users = np.zeros(self._slots, dtype=np.int64)
        self._retiring = -1
        self._next_slot = 0
        self._steps = 0
        self._coming = self._awaited = None
        self._fresh = True
        self._begun = False
        self._seed = seed

    def draw_anew(self, seed: int) -> None:
        """Seed the choice of fields of the pool, limits and worlds; the pool stays."""
        episode_seed, world_seed = np.random.SeedSequence(seed).spawn(2)
        self._rng = np.random.default_rng(episode_seed)
        self._world_rng = np.random.default_rng(world_seed)

    # -- what Stable-Baselines3 asks for ---------------------------------------------------------

    def reset(self) -> Observation:
        """Restart all missions; after :meth:`seed`, with another pool."""
        if any(self._options):
            self._reset_options()
            raise InputError("a MissionVecEnv takes no options; make it with other fields instead")
        seed = self._seeds[0]
        self._reset_seeds()
        if seed is not None and (seed != self._seed or not self._fresh):
            self._begin(int(seed))
        self._fresh = False
        self._actions = None
        self._next_chasers[:] = 0
        self._renew(np.arange(self.num_envs, dtype=np.int32))
        self._begun = True
        return self.observations()

    def step_async(self, actions: npt.NDArray[np.int64]) -> None:
        """Store the actions for :meth:`step_wait`.

        Raises
        ------
        InputError
            Not one whole number for each mission, or no mission has begun.
        """
        if not self._begun:
            raise InputError("no mission has begun; call reset before the first step")
        taken = np.asarray(actions)
        if taken.shape != (self.num_envs,) or taken.dtype.kind not in "iu":
            raise InputError(
                f"actions of shape {taken.shape} and type {taken.dtype}: give one whole number "
                f"for each of the {self.num_envs} missions"
            )
        self._actions = np.ascontiguousarray(taken, dtype=np.int64)

    def step_wait(self) -> VecEnvStepReturn:
        """Take the actions; finished missions restart.

        The observations are those arrays that the kernels write; the step after the next one
        overwrites them.
        """
        if self._actions is None:
            raise InputError("no actions are waiting; call step_async first")
        self._other.order = self._board.order
        self._board, self._other = self._other, self._board
        self._share(self._act, self.num_envs)
        self._actions = None
        rewards = self._rewards * self._scale
        done = (self._rewards < 0.0) | (self._board.legal == 0)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = np.flatnonzero(done).astype(np.int32)
        if ended.size:
            self._last_words(ended, infos)
            self._renew(ended)
        self._refresh()
        return self._board.arrays, rewards, done, infos

    def _share(self, work: Callable[[int, int], None], count: int) -> None:
        """Split work on 0 to ``count`` − 1 among threads."""
        bounds = [count * part // self.threads for part in range(self.threads + 1)]
        others = [
            self._workers.submit(work, *part) for part in pairwise(bounds[1:]) if part[0] < part[1]
        ]
        work(0, bounds[1])
        for other in others:
            other.result()

    def _act(self, first: int, last: int) -> None:
        """Act and observe, in the order of the fields."""
        board, pool = self._board, self.pool.arrays
        taken = first, last, self._actions, self._rewards, board.order
        if self.worlds is None:
            kernels.act(pool, self.episodes, *taken)
        else:
            world_kernels.act_in_worlds(pool, self.episodes, self.worlds, *taken)
        board.observe(pool, self.episodes, first, last, self.worlds)

    def _last_words(self, ended: npt.NDArray[np.int32], infos: list[dict[str, Any]]) -> None:
        """Add the information on ended episodes that Stable-Baselines3 expects."""
        episodes, seen = self.episodes, self._board.copy(ended)
        targets = self.pool.arrays.counts[episodes.slot[ended], BODIES] - 1
        told = last_words(episodes, self.worlds, ended, seen, self._rewards, targets)
        for index, said in zip(ended.tolist(), told, strict=True):
            infos[index] = said

    # -- fields ----------------------------------------------------------------------------------

    def _kind(self, slot: int) -> Fields | Alone:
        return self.kinds[slot % len(self.kinds)]

    def _draw_field(self, slot: int) -> Instance:
        """Another field for a slot, with the first of its chasers alone."""
        field = self._kind(slot).draw_field(self._field_rng)
        return field if len(field.chasers) == 1 else field.replace(chasers=field.chasers[:1])

    def _draw_limits(
        self, slots: npt.NDArray[np.int64]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Budgets [m/s] and durations [s] of missions on some slots."""
        budgets, durations = np.empty(slots.size), np.empty(slots.size)
        for number, kind in enumerate(self.kinds):
            of = slots % len(self.kinds) == number
            budgets[of], durations[of] = kind.draw_many_limits(self._rng, int(of.sum()))
        return budgets, durations

    def _hand_over(self, which: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
        """Begin with the next chasers of some missions; returns those that have no further one."""
        staying = which[self._next_chasers[which] > 0]
        if not staying.size:
            return which
        episodes = self.episodes
        self._next_chasers[staying] -= 1
        visited = episodes.visited[staying]
        begin = episodes.slot[staying], episodes.budget[staying], episodes.duration[staying]
        kernels.begin_many(self.pool.arrays, episodes, staying, *begin)
        if self.worlds is not None:
            states = self.worlds.states
            drawn = states.seed[staying], states.model[staying]
            begin_in_worlds(self.pool, episodes, self.worlds, staying, drawn)
        episodes.visited[staying] |= visited
        self._look(staying)
        return np.setdiff1d(which, staying[self._board.legal[staying] > 0])

    def _renew(self, which: npt.NDArray[np.int32]) -> None:
        """Restart missions on fields of the pool, drawn again if they have no legal first move."""
        board = self._board
        which = self._hand_over(which)
        for _ in range(MOST_REDRAWS):
            before = self.episodes.slot[which]
            np.subtract.at(self._users, before[before >= 0], 1)
            slots = self._rng.integers(self._slots, size=which.size)
            # No mission enters a field that is about to be replaced.
            slots[slots == self._retiring] = (self._retiring + 1) % self._slots
            np.add.at(self._users, slots, 1)
            budgets, durations = self._draw_limits(slots)
            chasers = np.array([each.chasers for each in self.kinds])
            self._next_chasers[which] = chasers[slots % len(self.kinds)] - 1
            kernels.begin_many(self.pool.arrays, self.episodes, which, slots, budgets, durations)
            if self.worlds is not None:
                seeds = self._world_rng.integers(LAST_WORLD, size=which.size)
                models = self._world_rng.integers(len(self._models), size=which.size)
                begin_in_worlds(self.pool, self.episodes, self.worlds, which, (seeds, models))
            self._look(which)
            which = which[board.legal[which] == 0]
            if not which.size:
                # Missions of one field side by side: their table is then in the cache.
                board.order = np.argsort(self.episodes.slot, kind="stable").astype(np.int32)
                return
        raise InputError("the drawn missions allow no move at all; raise delta_v_m_s or duration_s")

    def _look(self, which: npt.NDArray[np.int32]) -> None:
        """Write the observations of some missions."""
        if which.size < FEW:
            self._board.observe_these(self.pool.arrays, self.episodes, which, self.worlds)
            return
        in_order = which[np.argsort(self.episodes.slot[which], kind="stable")]

        def look(first: int, last: int) -> None:
            these = in_order[first:last]
            self._board.observe_these(self.pool.arrays, self.episodes, these, self.worlds)

        self._share(look, which.size)

    def _refresh(self) -> None:
        """Replace the oldest field when due and once no mission uses it."""
        if not self._refresh_every:
            return
        self._steps += self.num_envs
        if self._coming is None and self._steps >= self._refresh_every:
            self._steps -= self._refresh_every
            self._retiring = self._next_slot
            # Drawn here and now, worked out elsewhere: the order of the draws is certain.
            self._awaited = self._draw_field(self._retiring)
            self._coming = self._builder.submit(ready, self._awaited)
        if self._coming is not None and not self._users[self._retiring]:
            mission = self._coming.result()
            # A field with too many events for the pool is passed over.
            if self.pool.fits(mission):
                self.pool.install(self._retiring, mission)
                if self._uncertain is not None:
                    self._uncertain.install(self._retiring)
            self._next_slot = (self._retiring + 1) % self._slots
            self._retiring = -1
            self._coming = self._awaited = None

    def observations(self) -> Observation:
        """A copy of what is seen now of all missions."""
        return self._board.copy()

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Legal actions of all missions, shape (missions, actions)."""
        return self._board.mask.copy()

    # -- the rest of the protocol ----------------------------------------------------------------

    def close(self) -> None:
        """End the threads."""
        self._workers.shutdown(wait=True, cancel_futures=True)
        self._builder.shutdown(wait=True, cancel_futures=True)

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, common to all missions."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all missions at once.

        Raises
        ------
        InputError
            Only some missions are named: they have no attributes of their own.
        """
        if len(list(self._get_indices(indices))) != self.num_envs:
            raise InputError(
                f"attribute {attr_name!r} is one for all missions; set it without indices"
            )
        setattr(self, attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any
    ) -> list[Any]:
        """``action_masks`` of the missions; they have no other method of their own."""
        if method_name != "action_masks":
            raise AttributeError(f"missions of a MissionVecEnv have no method {method_name!r}")
        mask = self.action_masks()
        return [mask[index] for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No mission is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[Any]:
        """No pictures; ``adr_opt/Mission-v0`` draws them."""
        return [None] * self.num_envs
