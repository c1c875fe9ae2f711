"""One mission as a Gymnasium environment."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ...common.constants import SLACK_M_S
from ...common.errors import InputError
from ...kernels.episodes import episodes as kernels
from ...mission.mission import Mission
from ...problem.instance import AnyInstance, Instance, instance_of
from ...problem.uncertainty import Uncertainty
from ..episodes import AnyUncertainty, Board, Observation, allowed, models_of, new_episodes, start
from .drawn import DrawnFields, OwnField, PlayedFields, shared
from .fields import PUBLISHED, Alone, AnyFields, Fields, fields_of
from .plain import SpecHolder
from .played_world import PlayedWorld, world_number
from .rendering import picture, sentence
from .spaces import space

MOST_REDRAWS = 100

POOL = 32
"""Default number of fields drawn in advance."""

NONE_BEGUN = "no mission has begun; call reset first"


class MissionEnv(SpecHolder, gymnasium.Env[Observation, np.int64]):
    """Collect as much prize as possible before ΔV and time run out.

    ## Action Space

    ``Discrete(N + 1)``: the targets in the order of the instance, then the station (refuelling).
    :meth:`action_masks` and ``info["action_mask"]`` say which actions are legal. When no move is
    left they allow the station, as vectorised environments that reset at the next step draw an
    action that they ignore.

    ## Observation Space

    By name, see :func:`.space`: ``choices`` or ``published``.

    ## Rewards

    The prize of a serviced target in mean prizes of the field (of those targets that have one), 0
    for refuelling and for what is lost, −1 for an illegal action. Equal prizes are rewards of +1,
    as published.

    ## Uncertain Worlds

    With ``uncertainty`` each episode is played in a world of its own, that of ``rehearse`` with the
    seed ``info["world"]``. Actions are legal by what is planned of them; then a leg costs what the
    world says, a service takes so long, a capture is tried until it succeeds or no try is left, and
    a target may be gone. ``info["outcome"]`` says what became of the latest action, and
    ``info["losses"]`` what was lost and why. ``options={"world": 7}`` chooses the world.

    ## Starting State

    Docked at the station at t = 0 with a full ΔV budget. Without an ``instance``, every reset
    draws one of ``pool`` fields that were themselves drawn from ``fields``, and a budget and a
    duration. The first reset works out their timetables, and all environments of a process share
    them. ``options`` change ``fields`` for one reset (``{"targets": (20, 30), "zones": (0, 6)}``),
    which then works out a field of its own, or give one ``{"instance": …}``. A field with fewer
    targets than the action space leaves the last target actions without use.

    ## Episode End

    ``terminated`` when no legal move is left, or by an illegal action; in an uncertain world also
    when the tank runs dry or a service ends late. ``truncated`` never.

    ## Arguments

    ```python
    fields = adr_opt.learning.environment.VARIED
    gymnasium.make("adr_opt/Mission-v0", observation="choices", fields=fields)
    gymnasium.make("adr_opt/Mission-v0", instance=adr_opt.load("my.json"))
    ```

    ## Copies

    ``copy.deepcopy`` and ``pickle`` give an environment in the middle of the same episode, with the
    same draws to come, and independent of this one. Copies share timetables; a pickle works them
    out again unless its process has them.

    ## Version History

    v0: first version.

    Parameters
    ----------
    instance : Instance, path or dict, optional
        Play this one at every reset.
    fields : Fields, str or dict
        Where missions are drawn from otherwise: a distribution, the name of a family, or the fields
        of :class:`Fields` by name.
    pool : int
        Number of fields drawn in advance; with 0 every reset draws another one and works out its
        timetable.
    pool_seed : int
        Seed of these fields; the seed of :meth:`reset` determines which of them is played.
    observation : str
        One of :data:`adr_opt.learning.episodes.OBSERVATIONS`.
    render_mode : {"ansi", "rgb_array"}, optional
    uncertainty : Uncertainty, path or dict, or a sequence of them, optional
        Episodes are played in uncertain worlds of this model; of several, each draws one.

    Attributes
    ----------
    sequence : list of int
        Bodies of the moves made so far, the station is 0: what
        :func:`adr_opt.mission.certified.certify` makes a plan of.

    Raises
    ------
    InputError
        Unknown observation or render mode, no uncertainty, or at a reset a mission that episodes
        cannot play: see :func:`adr_opt.learning.episodes.check_playable`.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 2}  # noqa: RUF012

    def __init__(
        self,
        instance: AnyInstance | None = None,
        *,
        fields: AnyFields = PUBLISHED,
        pool: int = POOL,
        pool_seed: int = 0,
        observation: str = "choices",
        render_mode: str | None = None,
        uncertainty: AnyUncertainty | Sequence[AnyUncertainty] | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            known = ", ".join(self.metadata["render_modes"])
            raise InputError(f"render_mode {render_mode!r} is unknown; use one of: {known}")
        self._fixed = None if instance is None else instance_of(instance)
        self.fields = fields_of(fields)
        for name, value in (("pool", pool), ("pool_seed", pool_seed)):
            if not isinstance(value, (int, np.integer)) or value < 0:
                raise InputError(f"{name} = {value!r}: must be a whole number from 0 on")
        self.render_mode = render_mode
        self._models = models_of(uncertainty)
        self._world: PlayedWorld | None = None
        if self._fixed is None:
            targets = self.fields.most_targets
        else:
            targets = Alone(self._fixed).most_targets
        self.observation_space = space(observation, targets)
        self.action_space = spaces.Discrete(targets + 1)
        self._targets = targets
        self._ahead = int(pool), int(pool_seed)
        self._drawn: DrawnFields | None = None
        self._played: PlayedFields | None = None
        self._own: OwnField | None = None
        self._mission: Mission | None = None
        self._episodes = new_episodes(1, targets + 1)
        self._board = Board(observation, 1, targets)
        self._chosen_world: int | None = None
        self._over = True
        self.sequence: list[int] = []

    def __getstate__(self) -> dict[str, Any]:
        # The mission is made again from the fields and the state when it is asked for.
        return {**self.__dict__, "_mission": None}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a mission.

        Parameters
        ----------
        seed : int, optional
            Seeds the draws of this reset and of those after it.
        options : dict, optional
            ``instance``, as an object, a path or a dictionary, or fields of :class:`.Fields`;
            ``world`` besides, where worlds are uncertain.

        Raises
        ------
        InputError
            Unknown option, an option beside an instance, more targets than the action space has, or
            no legal first move.
        """
        super().reset(seed=seed)
        if not isinstance(options or {}, Mapping):
            raise InputError(f"options = {options!r}: must be a dictionary")
        changes = dict(options or {})
        given = changes.pop("instance", None)
        fixed = self._fixed if given is None else instance_of(given)
        self._chosen_world = None
        if self._models and "world" in changes:
            self._chosen_world = world_number(changes.pop("world"))
        fields = Fields.from_options(changes, self.fields)
        if fixed is not None and changes:
            raise InputError(
                f"option {next(iter(changes))!r} changes the distribution of missions, but an "
                "instance is given"
            )
        for _ in range(MOST_REDRAWS):
            if fixed is not None:
                name = self._begin(fixed)
            elif changes or not self._ahead[0]:
                limits = fields.draw_limits(self.np_random)
                field = fields.draw_field(self.np_random)
                name = self._begin(field.with_limits(limits.duration_s, limits.delta_v_m_s))
            else:
                name = self._begin_drawn()
            self._over = not self._board.legal[0]
            if not self._over:
                return self._board.copy(0), self._info()
            if fixed is not None and (not self._models or self._chosen_world is not None):
                break
        raise InputError(
            f"{name}: no move is legal at the start; it needs targets, more duration_s or "
            "delta_v_m_s, or fewer keep-out zones"
        )

    def _begin(self, instance: Instance) -> str:
        """Begin a mission with its own timetable; returns the name of its instance."""
        if len(instance.targets) > self._targets:
            raise InputError(
                f"{instance.name} has {len(instance.targets)} targets, more than the "
                f"{self._targets} of the action space; make the environment with this instance"
            )
        if self._own is None or not self._own.instance.same(instance):
            self._own = OwnField(instance, self._targets + 1)
        self._start(self._own, 0, *Alone(instance).limits)
        return instance.name

    def _begin_drawn(self) -> str:
        """Begin a mission on one of the drawn fields; returns the name of the field."""
        if self._drawn is None:
            self._drawn = shared(self.fields, *self._ahead)
        slot, field, limits = self._drawn.draw(self.np_random)
        self._start(self._drawn, slot, limits.delta_v_m_s, limits.duration_s)
        return field.name

    def _start(
        self, played: PlayedFields, slot: int, delta_v_m_s: float, duration_s: float
    ) -> None:
        self._played, self._mission = played, None
        start(played.pool, self._episodes, 0, slot, delta_v_m_s, duration_s)
        if self._models:
            if self._world is None or self._world.played is not played:
                self._world = PlayedWorld(played, self._models)
            self._world.begin(self._episodes, self.np_random, self._chosen_world)
        self._observe(played)
        self.sequence = []

    def _observe(self, played: PlayedFields) -> None:
        worlds = None if self._world is None else self._world.worlds
        self._board.observe(played.pool.arrays, self._episodes, 0, 1, worlds)

    def step(
        self, action: int | np.integer[Any]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Make one move.

        Raises
        ------
        InputError
            The episode is over, or has not begun, or the action is not a whole number.
        """
        if self._over or self._played is None:
            raise InputError("the episode is over; call reset before the next step")
        try:
            actions = np.array([operator.index(action)], dtype=np.int64)
        except (TypeError, OverflowError):
            raise InputError(
                f"action {action!r}: must be a whole number from 0 to {self._targets}"
            ) from None
        rewards = np.zeros(1, dtype=np.float32)
        if self._world is None:
            kernels.act(self._played.pool.arrays, self._episodes, 0, 1, actions, rewards)
        else:
            self._world.act(self._episodes, actions, rewards)
        reward = float(rewards[0])
        if reward >= 0.0:
            self.sequence.append(int(kernels.body_of(int(actions[0]), self._targets)))
        self._observe(self._played)
        self._over = reward < 0.0 or not self._board.legal[0]
        return self._board.copy(0), reward, self._over, False, self._info()

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Legal actions, shape (actions,), as required by sb3-contrib; at least one.

        When no move is left, the station: see the action space.

        Raises
        ------
        InputError
            None has begun.
        """
        if self._played is None:
            raise InputError(NONE_BEGUN)
        return allowed(self._board.mask[0])

    def _info(self) -> dict[str, Any]:
        episodes = self._episodes
        of_world = {} if self._world is None else self._world.info()
        return {
            "action_mask": allowed(self._board.mask[0]).astype(np.int8),
            "serviced": int(episodes.serviced[0]),
            "refuelled": int(episodes.refuelled[0]),
            "collected": float(episodes.collected[0]),
            "time_s": float(episodes.time[0]),
            "delta_v_left_m_s": self._left_m_s(),
            **of_world,
        }

    def _left_m_s(self) -> float:
        left_m_s = float(self._episodes.left[0] - SLACK_M_S)
        # A tank that ran dry has less than nothing left, so that no move is legal.
        return left_m_s if self._world is None else max(left_m_s, 0.0)

    @property
    def uncertainty(self) -> Uncertainty | None:
        """The model that the world of the episode is drawn from; None where all goes as planned."""
        return None if self._world is None else self._world.uncertainty

    @property
    def mission(self) -> Mission:
        """The current mission, with its budget and duration.

        For an episode on a field that was drawn ahead it is made when it is first asked for, and
        works out a timetable of its own when it is first planned with.

        Raises
        ------
        InputError
            None has begun.
        """
        if self._played is None:
            raise InputError(NONE_BEGUN)
        if self._mission is None:
            episodes = self._episodes
            self._mission = self._played.mission(
                int(episodes.slot[0]), float(episodes.budget[0]), float(episodes.duration[0])
            )
        return self._mission

    def render(self) -> Any:
        """The state as text (``ansi``) or as a picture (``rgb_array``)."""
        if self.render_mode is None or self._played is None:
            return None
        state = {**self._info(), "body": int(self._episodes.body[0])}
        draw = sentence if self.render_mode == "ansi" else picture
        return draw(self.mission, state, self._episodes.visited[0])
