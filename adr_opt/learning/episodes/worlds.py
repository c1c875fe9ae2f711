"""Uncertain worlds of episodes: the draws of rehearsals, in arrays that kernels take; practice."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S
from ...common.errors import InputError
from ...common.files import parse_content
from ...kernels.core.draws import late_try
from ...kernels.episodes import episodes as episode_kernels
from ...kernels.episodes import worlds as kernels
from ...kernels.episodes.choices import CERTAIN
from ...kernels.episodes.episodes import HOME, SERVICE, Episodes
from ...kernels.tables import timetable
from ...kernels.tables.stacked_timetables import listed_in
from ...legs.connection_finder import ConnectionFinder
from ...plan.leg_kinds import leg_kinds
from ...problem.instance import Instance
from ...problem.uncertainty import (
    CaptureUncertainty,
    Delay,
    LegUncertainty,
    LognormalFactor,
    ServiceUncertainty,
    Uncertainty,
)
from ...problem.world import OUTCOMES, draw_key
from ...run.warm_up import practice_mission
from .board import OBSERVATIONS, Board
from .pool import FieldPool, new_episodes, playing_time_s, start

LOSS_WORDS = OUTCOMES[-kernels.LOSSES :]
"""Reasons of losses, in the order of :attr:`.worlds.WorldStates.losses`."""


AnyUncertainty = Uncertainty | str | os.PathLike[str] | Mapping[str, Any]
"""A model of uncertainty, the path of its file, or the file's content as a dictionary."""


def models_of(given: Any) -> tuple[Uncertainty, ...]:
    """Models of uncertainty that were given as one or as several; none for None.

    Raises
    ------
    InputError
        Something else was given.
    """
    if given is None:
        return ()
    alone = isinstance(given, (Uncertainty, Mapping, str, os.PathLike))
    models = (given,) if alone else given
    if not isinstance(models, Sequence) or not models:
        raise InputError(
            f"uncertainty = {given!r}: must be an Uncertainty, or several in a sequence"
        )
    return tuple(_model_of(each) for each in models)


def _model_of(given: Any) -> Uncertainty:
    if isinstance(given, Uncertainty):
        return given
    if isinstance(given, (str, os.PathLike)):
        return Uncertainty.load(given)
    return parse_content(given, Uncertainty, "uncertainty")


class UncertainPool:
    """What is uncertain about the fields of a pool.

    Parameters
    ----------
    fields : FieldPool
    models : sequence of Uncertainty
        An episode is played in a world of one of them.

    Attributes
    ----------
    fields : FieldPool
    models : tuple of Uncertainty
    tables : adr_opt.kernels.episodes.worlds.WorldTables
        Of a slot of the pool once :meth:`install` was called for it.
    """

    def __init__(self, fields: FieldPool, models: Sequence[Uncertainty]) -> None:
        self.models = tuple(models)
        self.fields = fields
        slots, bodies = fields.arrays.limits.shape[0], fields.arrays.is_station.size
        tries = max(
            max(model.capture.tries, *(each.tries or 1 for each in model.targets.values()), 1)
            for model in self.models
        )
        kinds, events = 1, 0
        if any(model.legs.kinds for model in self.models):
            if not timetable.is_regular(fields.arrays.tables):
                kinds, events = len(leg_kinds()), timetable.most_events(fields.arrays.tables)
        shape = slots, len(self.models)
        self.tables = kernels.WorldTables(
            target_keys=np.zeros((slots, bodies, kernels.FIRST_TRY_KEY + tries), dtype=np.uint64),
            own_keys=np.zeros((slots, 2, bodies + 1), dtype=np.uint64),
            models=np.zeros((*shape, bodies, kernels.ALL_TRIES_S + 1)),
            factors=np.zeros((*shape, kinds, bodies, len(CERTAIN))),
            tanks=np.array(
                [
                    (1.0, 1.0) if each.tanks is None else (each.tanks.least, each.tanks.most)
                    for each in self.models
                ]
            ),
            families=np.zeros((slots, bodies, events, bodies), dtype=np.int8),
        )
        self._installed: list[Instance | None] = [None] * slots

    def install(self, slot: int) -> None:
        """Prepare a slot for the field that stands in it, unless that is done.

        Raises
        ------
        InputError
            A model names a target that the field does not have.
        """
        instance = self.fields.instances[slot]
        assert instance is not None
        if self._installed[slot] is instance:
            return
        models = [model.of(instance) for model in self.models]
        self._write_keys(slot, instance)
        names = [kind.name for kind in leg_kinds()][: self.tables.factors.shape[2]]
        services = self.fields.arrays.limits[slot, SERVICE]
        for number, model in enumerate(models):
            factors = self.tables.factors[slot, number]
            for body, name in enumerate(instance.names):
                target = None if body == HOME else name
                for kind, kind_name in enumerate(names):
                    factors[kind, body] = leg_row(model.factor_of(kind_name, target))
                rows = self.tables.models[slot, number]
                rows[body] = stay_row(model, target, float(services[body]))
        if self.tables.families.shape[2]:
            self._write_families(slot, instance)
        self._installed[slot] = instance

    def _write_keys(self, slot: int, instance: Instance) -> None:
        keys, own = self.tables.target_keys[slot], self.tables.own_keys[slot]
        for body, name in enumerate(instance.names):
            if body == HOME:
                continue
            keys[body, : kernels.FIRST_TRY_KEY] = [
                draw_key("leg", name, 1),
                draw_key("service", name, 1),
                draw_key("service-delay", name, 1),
                draw_key("gone", name),
            ]
            for attempt in range(keys.shape[1] - kernels.FIRST_TRY_KEY):
                key = draw_key("capture", name, attempt + 1)
                keys[body, kernels.FIRST_TRY_KEY + attempt] = key
        chaser, station = instance.chaser.name, instance.names[HOME]
        for number in range(own.shape[1]):
            own[kernels.STATION_KEYS, number] = draw_key("station", chaser, station, number + 1)
            own[kernels.TANK_KEYS, number] = draw_key("tank", chaser, number + 1)

    def _write_families(self, slot: int, instance: Instance) -> None:
        """Kinds of the connections in the table of a slot."""
        finder, tables = ConnectionFinder(instance), self.fields.arrays.tables
        families = self.tables.families[slot]
        for i in range(len(instance.names)):
            for j in range(len(instance.names)):
                departures, arrivals = listed_in(tables, slot, i, j)
                if i == j or not departures.size:
                    continue
                found = finder.found(i, j)
                known = {
                    (departure, arrival): family
                    for departure, arrival, family in zip(
                        found.departure.tolist(),
                        found.arrival.tolist(),
                        found.family.tolist(),
                        strict=True,
                    )
                }
                families[i, : departures.size, j] = [
                    known[each] for each in zip(departures.tolist(), arrivals.tolist(), strict=True)
                ]


def leg_row(model: LognormalFactor | None) -> tuple[float, ...]:
    """A row of :attr:`.worlds.WorldTables.factors`."""
    if model is None:
        return CERTAIN
    return model.lognormal_sigma, model.least, model.most, *model.moments


def stay_row(model: Uncertainty, target: str | None, planned_s: float) -> tuple[float, ...]:
    """A row of :attr:`.worlds.WorldTables.models`; ``target`` is None for the station."""
    if target is None:
        return 1.0, 1.0, 0.0, *CERTAIN[:3], 0.0, 0.0, 0.0, 1.0, planned_s, planned_s, planned_s
    success, tries, gone = (model.success_of(target), model.tries_of(target), model.gone_of(target))
    stay = model.service_of(target)
    factor, delay, mean_s = CERTAIN[:3], (0.0, 0.0, 0.0), planned_s
    if stay.factor is not None:
        factor = stay.factor.lognormal_sigma, stay.factor.least, stay.factor.most
        mean_s *= stay.factor.moments[0]
    if stay.added is not None:
        delay = stay.added.chance, stay.added.mean_s, stay.added.at_most_s
        mean_s += stay.added.average_s
    failed = (1.0 - success) ** tries
    mean_tries = tries if success == 0.0 else (1.0 - failed) / success
    return (
        success,
        tries,
        gone,
        *factor,
        *delay,
        (1.0 - gone) * (1.0 - failed),
        mean_s,
        late_try(planned_s, factor, delay),
        (1.0 - gone) * mean_tries * mean_s,
    )


def new_worlds(pool: UncertainPool, count: int) -> kernels.Worlds:
    """Storage for the worlds of ``count`` episodes; :func:`begin_in_worlds` begins them."""
    states = kernels.WorldStates(
        seed=np.zeros(count, dtype=np.uint64),
        state=np.zeros(count, dtype=np.uint64),
        model=np.zeros(count, dtype=np.int32),
        outcome=np.full(count, kernels.ILLEGAL, dtype=np.int8),
        tries=np.zeros(count, dtype=np.int32),
        losses=np.zeros((count, kernels.LOSSES), dtype=np.int32),
    )
    return kernels.Worlds(pool.tables, states)


def begin_in_worlds(
    pool: FieldPool,
    episodes: Episodes,
    worlds: kernels.Worlds,
    which: npt.NDArray[np.int32],
    drawn: tuple[npt.NDArray[Any], npt.NDArray[Any]],
) -> None:
    """Begin some episodes, whose fields and limits are set, in worlds.

    Parameters
    ----------
    drawn : (starts,) int, (starts,) int
        Seeds of the worlds, and numbers of their models.
    """
    seeds, models = drawn
    kernels.begin_worlds(
        pool.arrays, episodes, worlds, which, seeds.astype(np.uint64), models.astype(np.int32)
    )


def practise() -> None:
    """Compile the kernels called by both environments, with every observation."""
    for drifts in (False, True):
        mission = practice_mission(drifts)
        bodies, budget = len(mission.names), mission.chaser.tank.delta_v_m_s
        duration_s = playing_time_s(mission.instance)
        pool, episodes = FieldPool.of(mission), new_episodes(1, bodies)
        which, slots = np.zeros(1, dtype=np.int32), np.zeros(1, dtype=np.int64)
        rewards = np.zeros(1, dtype=np.float32)
        uncertain = UncertainPool(pool, [Uncertainty(capture=CaptureUncertainty(success=0.5))])
        uncertain.install(0)
        worlds = new_worlds(uncertain, 1)
        for name in OBSERVATIONS:
            board = Board(name, 1, bodies - 1)
            start(pool, episodes, 0, 0, budget, duration_s)
            board.observe(pool.arrays, episodes, 0, 1)
            actions = board.mask.argmax(axis=1)
            episode_kernels.act(pool.arrays, episodes, 0, 1, actions, rewards)
            episode_kernels.act(pool.arrays, episodes, 0, 1, actions, rewards, board.order)
            episode_kernels.body_of(int(actions[0]), bodies - 1)
            limits = np.array([budget]), np.array([duration_s])
            episode_kernels.begin_many(pool.arrays, episodes, which, slots, *limits)
            board.observe_these(pool.arrays, episodes, which)
            if name != "published":
                begin_in_worlds(pool, episodes, worlds, which, (slots, slots))
                board.observe(pool.arrays, episodes, 0, 1, worlds)
                board.observe_these(pool.arrays, episodes, which, worlds)
                taken = 0, 1, actions, rewards, board.order
                kernels.act_in_worlds(pool.arrays, episodes, worlds, *taken)


def troubled(spread: float, success: float, delayed: float) -> Uncertainty:
    """A model of uncertainty by three numbers.

    Parameters
    ----------
    spread : float
        Of the lognormal factor on the ΔV of a leg.
    success : float
        Chance that a try at a target succeeds, of two; a quarter of the others are gone.
    delayed : float
        Chance that a service takes 4 hours more on average, at three times that spread.
    """
    return Uncertainty(
        legs=LegUncertainty(delta_v_factor=LognormalFactor(lognormal_sigma=spread)),
        service_s=ServiceUncertainty(
            factor=LognormalFactor(lognormal_sigma=3.0 * spread),
            added=Delay(chance=delayed, mean_s=4.0 * HOUR_S),
        ),
        capture=CaptureUncertainty(success=success, tries=2),
        gone=0.25 * (1.0 - success),
    )


TROUBLED = troubled(0.1, 0.8, 0.1)
"""Legs of spread 0.1, services of spread 0.3 of which one in ten is delayed, captures that succeed
with a chance of 0.8 in each of two tries, and one target in twenty gone."""

TROUBLES = tuple(
    troubled(*each) for each in product((0.0, 0.05, 0.1, 0.2), (1.0, 0.9, 0.8, 0.6), (0.0, 0.1))
)
"""Models from none to twice the trouble, of which each episode draws one."""
