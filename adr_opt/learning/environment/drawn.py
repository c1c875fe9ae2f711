"""Fields with their timetables: drawn ahead and shared by the environments of a process, or one.

Both are read-only once made, so copies of an environment share them; a pickle holds what they are
made of, and makes them again.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Self
from weakref import WeakValueDictionary

import numpy as np

from ...common.processors import usable_cores
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...mission.mission import Mission
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from ..episodes import FieldPool, UncertainPool
from .fields import Fields, Limits


def ready(instance: Instance) -> Mission:
    """A mission with everything an episode needs, computed on one thread."""
    mission = Mission(instance, threads=1)
    _ = mission.rules
    # What the table was chosen from takes many times its memory and is not needed here.
    mission.connecting.kept.limit(0.0)
    return mission


def _revolutions(instance: Instance) -> float:
    """Revolutions of the lowest body in a mission, but for a factor common to all."""
    lowest_m = float(elements.radii(instance.orbits(), EPOCH_S).min())
    return float(instance.mission.duration_s * lowest_m**-1.5)


def work_out(instances: Sequence[Instance], bodies: int, workers: ThreadPoolExecutor) -> FieldPool:
    """A pool with one field per slot, and spare capacity for fields with more departure events.

    Parameters
    ----------
    instances : sequence of Instance
        All with the same dynamics.
    bodies : int
        Room for this many bodies in each slot, the station included.
    workers : ThreadPoolExecutor
        Works out the timetables.
    """
    regular = not Mission(instances[0]).connecting.is_listed
    missions = workers.map(ready, instances)
    if regular:
        # The lowest body has the most departure events; fields drawn later may be a little lower.
        lowest = ready(max(instances, key=_revolutions))
        events = lowest.timetable.most_events
        events += 4 + events // 32
    else:
        # One field does not tell how many events another one has.
        made = list(missions)
        events = max(mission.timetable.most_events for mission in made)
        events += 4 + events // 4
        missions = iter(made)
    pool = FieldPool(len(instances), bodies, events, regular=regular)
    for slot, mission in enumerate(missions):
        pool.install(slot, mission)
    return pool


class PlayedFields(ABC):
    """Fields that episodes are played on.

    Attributes
    ----------
    pool : FieldPool
        Nothing is installed in it any more.
    """

    pool: FieldPool

    def __init__(self) -> None:
        self._uncertain: dict[tuple[str, ...], UncertainPool] = {}

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @abstractmethod
    def __reduce__(self) -> tuple[Any, ...]:
        """What a pickle makes the same fields of."""

    @abstractmethod
    def mission(self, slot: int, delta_v_m_s: float, duration_s: float) -> Mission:
        """The mission of an episode on the field of a slot."""

    def uncertain(self, models: Sequence[Uncertainty]) -> UncertainPool:
        """What is uncertain about the fields by some models, shared like the pool."""
        key = tuple(model.to_json() for model in models)
        if key not in self._uncertain:
            self._uncertain[key] = UncertainPool(self.pool, models)
        return self._uncertain[key]


class OwnField(PlayedFields):
    """The field of one instance, for its own limits.

    Parameters
    ----------
    instance : Instance
    bodies : int
        Room for this many bodies.
    """

    def __init__(self, instance: Instance, bodies: int) -> None:
        super().__init__()
        self.instance, self._bodies, self._mission = instance, bodies, Mission(instance)
        self.pool = FieldPool.for_one(self._mission, bodies)
        self.pool.install(0, self._mission)

    def __reduce__(self) -> tuple[Any, ...]:
        return OwnField, (self.instance, self._bodies)

    def mission(self, slot: int, delta_v_m_s: float, duration_s: float) -> Mission:
        """The mission of the instance."""
        return self._mission


class DrawnFields(PlayedFields):
    """Fields drawn from a distribution with their timetables, reproducible by seed.

    Where planes drift, connections depend on the tank, so each field comes with a budget and a
    duration of its own. Otherwise it is worked out for the longest mission, and every episode
    draws both.

    Parameters
    ----------
    fields : Fields
    slots : int
        Number of fields.
    seed : int
    """

    def __init__(self, fields: Fields, slots: int, seed: int) -> None:
        super().__init__()
        self._key = fields, slots, seed
        rng = np.random.default_rng(seed)
        instances = [fields.draw_field(rng) for _ in range(slots)]
        self._fixed_limits = Mission(instances[0]).connecting.is_listed
        if self._fixed_limits:
            instances = [_limited(each, fields.draw_limits(rng)) for each in instances]
        with ThreadPoolExecutor(usable_cores(), thread_name_prefix="fields") as workers:
            self.pool = work_out(instances, fields.most_targets + 1, workers)

    def __reduce__(self) -> tuple[Any, ...]:
        return shared, self._key

    def mission(self, slot: int, delta_v_m_s: float, duration_s: float) -> Mission:
        """A mission that works out a timetable of its own when it is first planned with."""
        return Mission(self._field(slot).with_limits(duration_s, delta_v_m_s))

    def _field(self, slot: int) -> Instance:
        field = self.pool.instances[slot]
        assert field is not None
        return field

    def draw(self, rng: np.random.Generator) -> tuple[int, Instance, Limits]:
        """Draw a slot of the pool, with its field and the limits of a mission on it."""
        slot = int(rng.integers(len(self.pool.instances)))
        field = self._field(slot)
        if self._fixed_limits:
            tank = field.chaser.tank
            return slot, field, Limits(tank.delta_v_m_s, field.mission.duration_s)
        return slot, field, self._key[0].draw_limits(rng)


def _limited(instance: Instance, limits: Limits) -> Instance:
    return instance.with_limits(limits.duration_s, limits.delta_v_m_s)


_known: WeakValueDictionary[tuple[Fields, int, int], DrawnFields] = WeakValueDictionary()
_drawing = threading.Lock()


def shared(fields: Fields, slots: int, seed: int) -> DrawnFields:
    """The drawn fields shared by all environments of this process, computed on first use.

    They are dropped with the last environment that plays on them.
    """
    key = fields, slots, seed
    with _drawing:
        drawn = _known.get(key)
        if drawn is None:
            drawn = _known[key] = DrawnFields(*key)
        return drawn
