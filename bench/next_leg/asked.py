"""The rest of a mission as kernels of planners see it: where a chaser is, and beams from there."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.analysis.rehearse.flying_chasers import FlyingChaser
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import ANY, Resources
from adr_opt.mission.mission import Mission
from solvers.beams.beams import beam_kernel, usual_settings
from solvers.beams.levels import Weights
from solvers.walks.completion_times import no_latest

BoolArray = npt.NDArray[np.bool_]
State = rule_kernels.State


def state_of(craft: FlyingChaser, left_m_s: float) -> State:
    """Where a chaser is, with a tank that may be less than full for a reserve."""
    has = Resources(
        float(craft.free_s),
        float(left_m_s),
        np.int64(craft.since),
        np.int64(craft.serviced),
        np.int64(craft.kits),
    )
    return State(np.int64(craft.body), has)


def beam_from(
    mission: Mission,
    state: State,
    done: BoolArray,
    width: int,
    *,
    noise: float = 0.0,
    seed: int = 0,
) -> tuple[npt.NDArray[np.int64], float]:
    """What a beam goes on with from a state, and the prizes of that."""
    usual, has = usual_settings(mission, width), state.resources
    weights = Weights(
        width,
        usual.time_weight / 3600.0,
        usual.delta_v_weight / 1000.0,
        usual.crowding,
        noise,
        usual.guarded,
        seed,
    )
    first = (
        int(state.body),
        int(has.since),
        np.array([has.kits]),
        np.array([has.time]),
        np.array([has.left]),
        np.zeros(1),
        np.zeros(1),
    )
    halt = np.zeros(1, dtype=np.bool_)
    # Kernels take all that is done for the work of one chaser, of which only its own counts.
    others = max(int(done.sum()) - int(has.serviced), 0)
    rules = mission.rules._replace(
        limits=mission.rules.limits._replace(
            targets=min(mission.rules.limits.targets + others, ANY)
        )
    )
    sequence, prize = beam_kernel(rules, done.copy(), first, no_latest(), False, weights, halt)[:2]
    return sequence, float(prize) - float(mission.rules.prize[done].sum())
