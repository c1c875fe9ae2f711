"""Uncertainty files, and draws that are functions of seed, kind, target and count alone."""

from __future__ import annotations

import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from pydantic import ValidationError

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.uncertainty import Delay, LognormalFactor, Uncertainty
from adr_opt.problem.world import DrawnWorld, uniform

INSTANCE = adr_opt.generate("tiny", seed=0)
NAMES = [target.name for target in INSTANCE.targets]

EVERYTHING = {
    "format": "adr-opt-uncertainty/1",
    "legs": {
        "delta_v_factor": {"lognormal_sigma": 0.1},
        "kinds": {"drift": {"lognormal_sigma": 0.2, "least": 0.8, "most": 1.5}},
    },
    "service_s": {
        "factor": {"lognormal_sigma": 0.3},
        "added": {"chance": 0.1, "mean_s": 3600.0, "most_s": 9000.0},
    },
    "capture": {"success": 0.8, "tries": 2},
    "gone": 0.05,
    "launches": {"slip_s": {"mean_s": 86400.0}},
    "tanks": {"least": 0.95},
    "targets": {NAMES[0]: {"success": 0.5, "tries": 1, "gone": 1.0}},
}


def read(content: dict[str, object]) -> Uncertainty:
    return Uncertainty.from_json(json.dumps(content))


def test_a_file_is_read_as_it_was_written(tmp_path: Path) -> None:
    """A file with every field is read, written and read again without a change."""
    made = read(EVERYTHING)
    made.save(tmp_path / "u.json")
    assert Uncertainty.load(tmp_path / "u.json") == made
    written = json.loads((tmp_path / "u.json").read_text())
    assert Uncertainty().model_dump(mode="json") == {"format": "adr-opt-uncertainty/1"}
    jsonschema.validate(EVERYTHING, Uncertainty.json_schema())
    jsonschema.validate(written, Uncertainty.json_schema())


def test_a_target_that_is_certain_stays_certain_in_the_file() -> None:
    """Times of services of a target without a distribution are written, and read again."""
    made = read(EVERYTHING | {"targets": {NAMES[0]: {"service_s": {}}}})
    again = Uncertainty.from_json(made.to_json())
    assert again == made
    assert again.to_json() == made.to_json() != read(EVERYTHING | {"targets": {}}).to_json()
    assert json.loads(made.to_json())["targets"] == {NAMES[0]: {"service_s": {}}}
    for world in (DrawnWorld(INSTANCE, each, 0) for each in (made, again)):
        assert world.service_s(NAMES[0], 5000.0) == 5000.0 != world.service_s(NAMES[1], 5000.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"capture": {"success": 1.2}},
        {"capture": {"tries": 0}},
        {"legs": {"delta_v_factor": {"lognormal_sigma": -0.1}}},
        {"legs": {"delta_v_factor": {"lognormal_sigma": 0.1, "least": 1.1}}},
        {"tanks": {"least": 0.9, "most": 0.8}},
        {"gone": "no"},
        {"unknown": 1},
        {"format": "adr-opt-uncertainty/2"},
    ],
)
def test_what_makes_no_sense_is_refused(wrong: dict[str, object]) -> None:
    """Chances beyond 1, bounds on one side of the median and unknown fields are refused."""
    with pytest.raises(ValidationError):
        read(EVERYTHING | wrong)


def test_names_that_the_instance_lacks_are_refused() -> None:
    """A target that is none, and a chaser that is not launched, are named in one sentence."""
    with pytest.raises(InputError, match="'nobody' is not a target"):
        Uncertainty(targets={"nobody": {"gone": 0.5}}).of(INSTANCE)
    launches = {"chasers": {"chaser": {"mean_s": 1.0}}}
    with pytest.raises(InputError, match="'chaser' is not a chaser"):
        Uncertainty(launches=launches).of(INSTANCE)


def test_draws_are_functions_of_their_names_alone() -> None:
    """Draws do not depend on the order in which they are asked for, nor on other targets."""
    uncertainty = read(EVERYTHING)
    names = NAMES[1:]

    def asked(instance: adr_opt.Instance, order: list[str]) -> dict[str, tuple[object, ...]]:
        world = DrawnWorld(instance, uncertainty.replace(targets={}), 7)
        return {
            name: (
                world.is_gone(name),
                world.succeeds(name, 2),
                world.succeeds(name, 1),
                world.service_s(name, 5000.0),
                world.leg_factor("short", name),
                world.leg_factor("drift", name),
                world.leg_factor("short", name, 2),
            )
            for name in order
        }

    first = asked(INSTANCE, names)
    fewer = INSTANCE.replace(targets=INSTANCE.targets[:0:-1])
    assert asked(fewer, names[::-1]) == first
    assert len({each[4] for each in first.values()}) == len(names)
    world = DrawnWorld(INSTANCE, uncertainty, 7)
    visits = [world.station_factor("short", "chaser", "station", visit) for visit in (1, 2)]
    assert visits[0] != visits[1] != world.leg_factor("short", names[0])


def test_a_draw_of_a_leg_is_the_same_quantile_whatever_its_kind() -> None:
    """Which kind of leg leads to a target decides the spread of the factor, not its luck."""
    uncertainty = read(EVERYTHING | {"targets": {}})
    for seed in range(20):
        world = DrawnWorld(INSTANCE, uncertainty, seed)
        short, drift = (world.leg_factor(kind, NAMES[1]) for kind in ("short", "drift"))
        expected = min(max(2.0 * math.log(short), math.log(0.8)), math.log(1.5))
        assert math.log(drift) == pytest.approx(expected, abs=1e-12)


def test_uniform_numbers_are_uniform_and_independent_of_neighbours() -> None:
    """Means, spreads and correlations over seeds, counts and names are those of uniform numbers."""
    drawn = np.array(
        [[uniform(seed, "leg", name, 1) for name in ("a", "b")] for seed in range(4000)]
    )
    counts = np.array([uniform(0, "leg", "a", count) for count in range(4000)])
    for values in (drawn[:, 0], drawn[:, 1], counts):
        assert abs(values.mean() - 0.5) < 0.02
        assert abs(values.var() - 1.0 / 12.0) < 0.004
        assert abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 0.06
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 0.06


def test_factors_have_median_1_within_bounds_and_delays_their_chance() -> None:
    """The quantiles of a factor are lognormal up to its bounds; a delay has its chance and mean."""
    factor = LognormalFactor(lognormal_sigma=0.5, least=0.6, most=1.8)
    assert factor.at(0.5) == pytest.approx(1.0)
    assert factor.at(0.8413447) == pytest.approx(math.exp(0.5), rel=1e-6)
    assert (factor.at(1e-6), factor.at(1.0 - 1e-6)) == (0.6, 1.8)
    delay = Delay(chance=0.25, mean_s=1000.0, most_s=2500.0)
    drawn = np.array([delay.at((n + 0.5) / 40000) for n in range(40000)])
    assert (drawn > 0.0).mean() == pytest.approx(0.25, abs=1e-3)
    assert drawn.mean() == pytest.approx(250.0 * (1.0 - math.exp(-2.5)), rel=1e-2)
    assert drawn.max() == 2500.0


def test_a_target_of_its_own_overrides_the_rest_of_the_file() -> None:
    """Unset fields of a target are those of the file."""
    uncertainty = read(EVERYTHING)
    first, second = INSTANCE.targets[:2]
    assert uncertainty.success_of(first.name) == 0.5
    assert uncertainty.success_of(second.name) == 0.8
    assert (uncertainty.tries_of(first.name), uncertainty.tries_of(second.name)) == (1, 2)
    assert DrawnWorld(INSTANCE, uncertainty, 0).is_gone(first.name)
    assert uncertainty.service_of(first.name) == uncertainty.service_s


def test_chances_that_targets_state_count_where_the_file_says_nothing() -> None:
    """The file's chances of captures go before those of targets, which files need not state."""
    assert "success" not in INSTANCE.to_json()
    first, second, *others = INSTANCE.targets
    stated = INSTANCE.replace(
        targets=(first.replace(success=0.25), second.replace(success=0.5), *others)
    )
    mine = Uncertainty(targets={second.name: {"success": 0.75}}).of(stated)
    assert [mine.success_of(each.name) for each in stated.targets[:3]] == [0.25, 0.75, 1.0]
    assert Uncertainty(capture={"success": 0.9}).of(stated).success_of(first.name) == 0.9
    assert Uncertainty().of(INSTANCE) == Uncertainty()
