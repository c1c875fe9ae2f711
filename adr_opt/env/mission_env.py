"""One mission as a Gymnasium environment."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ..episodes import Board, FieldPool, Observation, new_episodes, playing_time_s, start
from ..errors import InputError
from ..instance import Instance
from ..kernels import episodes as kernels
from ..kernels.constants import SLACK_M_S
from ..mission import Mission
from .fields import PUBLISHED, Fields, check_kind
from .rendering import picture, sentence
from .spaces import space

MOST_REDRAWS = 100


class MissionEnv(gymnasium.Env[Observation, np.int64]):
    """Collect as much prize as possible before ΔV and time run out.

    ## Action Space

    ``Discrete(N + 1)``: the targets in the order of the instance, then the station (refuelling).
    :meth:`action_masks` and ``info["action_mask"]`` say which actions are legal; there is at least
    one until the episode ends.

    ## Observation Space

    By name, see :func:`adr_opt.env.space`: ``transfer``, ``lookahead``, ``published``, and with
    prizes ``transfer-prizes`` and ``lookahead-prizes``.

    ## Rewards

    The prize of a serviced target in mean prizes of the field (of those targets that have one), 0
    for refuelling, −1 for an illegal action. Equal prizes are rewards of +1, as published.

    ## Starting State

    Docked at the station at t = 0 with a full ΔV budget. Without an ``instance``, every reset
    draws a field, and a budget and a duration, from ``fields``; ``options`` change ``fields`` for
    one reset (``{"targets": (20, 30), "zones": (0, 6)}``) or give one ``{"instance": …}``. A field
    with fewer targets than the action space leaves the last target actions without use.

    ## Episode End

    ``terminated`` when no legal move is left, or by an illegal action. ``truncated`` never.

    ## Arguments

    ```python
    gymnasium.make("adr_opt/Mission-v0", observation="transfer", fields=adr_opt.env.VARIED)
    gymnasium.make("adr_opt/Mission-v0", instance=adr_opt.load("my.json"))
    ```

    ## Version History

    v0: first version.

    Parameters
    ----------
    instance : Instance, optional
        Play this one at every reset.
    fields : Fields
        Where missions are drawn from otherwise.
    observation : str
        One of :data:`adr_opt.episodes.OBSERVATIONS`.
    render_mode : {"ansi", "rgb_array"}, optional

    Attributes
    ----------
    sequence : list of int
        Bodies of the moves made so far, the station is 0: what
        :func:`adr_opt.result.certify` makes a plan of.

    Raises
    ------
    InputError
        Unknown observation or render mode, or at a reset a mission that episodes cannot play: see
        :func:`adr_opt.episodes.check_playable`.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 2}  # noqa: RUF012

    def __init__(
        self,
        instance: Instance | None = None,
        *,
        fields: Fields = PUBLISHED,
        observation: str = "transfer",
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            known = ", ".join(self.metadata["render_modes"])
            raise InputError(f"render_mode {render_mode!r} is unknown; use one of: {known}")
        _check_kind(instance)
        check_kind(fields)
        self.render_mode = render_mode
        self.fields = fields
        self._fixed = instance
        self._name = observation
        targets = fields.most_targets if instance is None else len(instance.targets)
        if instance is not None:
            _ = instance.chaser  # an episode is that of one; several are refused
        if targets == 0:
            raise InputError("the instance has no targets; there is nothing to decide")
        self.observation_space = space(observation, targets)
        self.action_space = spaces.Discrete(targets + 1)
        self._targets = targets
        self._mission: Mission | None = None
        self._pool: FieldPool | None = None
        self._over = True
        self.sequence: list[int] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a mission.

        Parameters
        ----------
        seed : int, optional
            Seeds the draws of this reset and of those after it.
        options : dict, optional
            ``instance``, or fields of :class:`adr_opt.env.Fields`.

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
        fixed = changes.pop("instance", self._fixed)
        fields = Fields.from_options(changes, self.fields)
        _check_kind(fixed)
        if fixed is not None and changes:
            raise InputError(
                f"option {next(iter(changes))!r} changes what missions are drawn from, but an "
                "instance is given"
            )
        for _ in range(MOST_REDRAWS):
            instance = fixed
            if instance is None:
                limits = fields.draw_limits(self.np_random)
                field = fields.draw_field(self.np_random)
                instance = field.with_limits(limits.duration_s, limits.delta_v_m_s)
            self._begin(instance)
            self._over = not self._board.legal[0]
            if not self._over:
                return self._board.copy(0), self._info()
            if fixed is not None:
                break
        raise InputError(
            f"{instance.name}: no move is legal at the start; it needs targets, more duration_s or "
            "delta_v_m_s, or fewer keep-out zones"
        )

    def _begin(self, instance: Instance) -> None:
        if len(instance.targets) > self._targets:
            raise InputError(
                f"{instance.name} has {len(instance.targets)} targets, more than the "
                f"{self._targets} of the action space; make the environment with this instance"
            )
        if self._mission is None or not self._mission.instance.same(instance):
            self._mission = Mission(instance)
            bodies = self._targets + 1
            self._pool = FieldPool.for_one(self._mission, bodies)
            self._pool.install(0, self._mission)
            self._episodes = new_episodes(1, bodies)
            self._board = Board(self._name, 1, self._targets)
        assert self._pool is not None
        budget = instance.chaser.tank.delta_v_m_s
        start(self._pool, self._episodes, 0, 0, budget, playing_time_s(instance))
        self._board.observe(self._pool.arrays, self._episodes, 0, 1)
        self.sequence = []

    def step(self, action: np.int64) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Make one move.

        Raises
        ------
        InputError
            The episode is over, or has not begun, or the action is not a whole number.
        """
        if self._over or self._pool is None:
            raise InputError("the episode is over; call reset before the next step")
        try:
            actions = np.array([operator.index(action)], dtype=np.int64)
        except (TypeError, OverflowError):
            raise InputError(
                f"action {action!r}: must be a whole number from 0 to {self._targets}"
            ) from None
        rewards = np.zeros(1, dtype=np.float32)
        kernels.act(self._pool.arrays, self._episodes, 0, 1, actions, rewards)
        reward = float(rewards[0])
        if reward >= 0.0:
            self.sequence.append(int(kernels.body_of(int(actions[0]), self._targets)))
        self._board.observe(self._pool.arrays, self._episodes, 0, 1)
        self._over = reward < 0.0 or not self._board.legal[0]
        return self._board.copy(0), reward, self._over, False, self._info()

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Legal actions, shape (actions,): what sb3-contrib asks for.

        Raises
        ------
        InputError
            None has begun.
        """
        _ = self.mission  # refuses where none has begun
        mask: npt.NDArray[np.bool_] = self._board.mask[0].copy()
        return mask

    def _info(self) -> dict[str, Any]:
        episodes = self._episodes
        return {
            "action_mask": self._board.mask[0].astype(np.int8),
            "serviced": int(episodes.serviced[0]),
            "refuelled": int(episodes.refuelled[0]),
            "collected": float(episodes.collected[0]),
            "time_s": float(episodes.time[0]),
            "delta_v_left_m_s": float(episodes.left[0] - SLACK_M_S),
        }

    @property
    def mission(self) -> Mission:
        """The mission that is played.

        Raises
        ------
        InputError
            None has begun.
        """
        if self._mission is None:
            raise InputError("no mission has begun; call reset first")
        return self._mission

    def render(self) -> Any:
        """The state as text (``ansi``) or as a picture (``rgb_array``)."""
        if self.render_mode is None or self._mission is None:
            return None
        state = {**self._info(), "body": int(self._episodes.body[0])}
        draw = sentence if self.render_mode == "ansi" else picture
        return draw(self._mission, state, self._episodes.visited[0])


def _check_kind(instance: Any) -> None:
    if instance is not None and not isinstance(instance, Instance):
        raise InputError(f"instance = {instance!r}: must be an adr_opt.Instance; load it first")
