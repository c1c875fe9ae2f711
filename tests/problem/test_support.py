"""Who follows which rules: nothing that is set is ignored, by anybody, however deep in the file."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from conftest import Cli, refused
from every_record import PLACES, rich
from random_rules import DRAWS

import adr_opt
from adr_opt.analysis.comparison import compare
from adr_opt.analysis.design.rating import rating_of
from adr_opt.analysis.priced import price
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.analysis.replan.replanning import replan
from adr_opt.analysis.robust.robust import robust
from adr_opt.analysis.scenario.campaign import check_template
from adr_opt.analysis.trade.axes import Axis
from adr_opt.analysis.trade.frontier import check_frontier
from adr_opt.analysis.trade.run import tradeoff
from adr_opt.analysis.windows import CaptureConditions, windows_of
from adr_opt.common.errors import InputError
from adr_opt.common.records import Record
from adr_opt.export.flights.write import write_plan
from adr_opt.export.tables.write import write_matrix
from adr_opt.fly.flight.fly import fly
from adr_opt.learning.environment import MissionEnv
from adr_opt.learning.episodes import FOLLOWS as PLAYED
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.problem import Problem
from adr_opt.plan.cargo import loads_of
from adr_opt.plan.certificate import Certificate
from adr_opt.plan.plan import Plan
from adr_opt.problem import support
from adr_opt.problem.instance import Instance
from adr_opt.problem.rules import (
    CAMPAIGNS,
    CARGO,
    CHANCES,
    FACTS,
    FIRST,
    RULES,
    TOGETHER,
    TOURS,
    Follower,
)
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.run.method_spec import MethodSpec
from adr_opt.run.methods import BOUNDS, PLANNERS, names, spec
from adr_opt.ui.cli.entry import VERBS, command
from adr_opt.ui.report import page

METHODS = [(group, name) for group in (PLANNERS, BOUNDS) for name in names(group)]


def with_new_field(record: Record, path: str) -> Any:
    """A copy of a record with a field that nobody knows, set in the first record of a path."""
    part, _, rest = path.partition(".")
    if not part:
        kind = type(record)
        newer = type(kind.__name__, (kind,), {"__annotations__": {"novel": "int"}, "novel": 0})
        values = {name: getattr(record, name) for name in kind.model_fields}
        return newer.model_construct(**values, novel=1)
    name = part.removesuffix("[]")
    value = getattr(record, name)
    if part != name:
        first, *others = value
        return record.model_copy(update={name: (with_new_field(first, rest), *others)})
    return record.model_copy(update={name: with_new_field(value, rest)})


@pytest.mark.parametrize("place", PLACES)
def test_a_new_field_is_found_at_every_depth(place: str) -> None:
    """A field that no table knows is named by its path, and only where it is set."""
    instance = rich()
    assert not list(support.unknown_fields(instance))
    path = f"{place}.novel".lstrip(".")
    changed = with_new_field(instance, place)
    assert list(support.unknown_fields(changed)) == [path]
    with pytest.raises(InputError, match="nor does any method; leave it out") as error:
        support.refuse(changed, Follower("check", frozenset(RULES)))
    assert path in str(error.value)


def facts_and_rules() -> set[str]:
    return set(FACTS).union(*(rule.fields for rule in RULES.values()))


def paths_of(kind: type[Record], path: str = "") -> Iterator[str]:
    """All fields of a record and of those in it, by their annotations."""
    for name, about in kind.model_fields.items():
        inner, many = _records_in(about.annotation), "[]" if _is_many(about.annotation) else ""
        yield path + name
        for each in inner:
            yield from paths_of(each, f"{path}{name}{many}.")


def _parts(annotation: Any) -> Iterator[Any]:
    yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _parts(part)


def _records_in(annotation: Any) -> list[type[Record]]:
    return [
        each for each in _parts(annotation) if inspect.isclass(each) and issubclass(each, Record)
    ]


def _is_many(annotation: Any) -> bool:
    return any(getattr(each, "__origin__", None) in (tuple, dict) for each in _parts(annotation))


def test_each_field_is_a_fact_or_of_a_rule() -> None:
    """The table and the file format have the same fields, and no fact belongs to a rule."""
    formed = {*paths_of(Instance)}
    holders = {path.rsplit(".", 1)[0].removesuffix("[]") for path in formed if "." in path}
    assert formed - facts_and_rules() == set(), "a new field is a fact or belongs to a rule"
    assert facts_and_rules() - formed == set(), "a field is gone"
    assert holders <= formed


def test_each_field_of_an_uncertainty_is_known_and_a_new_one_is_refused() -> None:
    """The table and the file of uncertainties have the same fields; others are named."""
    assert {*paths_of(Uncertainty)} == CHANCES
    instance = adr_opt.generate("tiny", 0, targets=2)
    certain = Uncertainty(tanks={"least": 0.9})
    assert certain.of(instance) is certain
    for place in ("", "legs", "capture", "tanks"):
        with pytest.raises(InputError, match=r"the field .*novel"):
            with_new_field(certain, place).of(instance)


def test_words_that_are_no_rules_are_refused() -> None:
    """Neither a follower nor a specification can name what is no rule."""
    with pytest.raises(ValueError, match="follows 'rain', which is no rule"):
        Follower("umbrella", frozenset({"rain"}))
    with pytest.raises(ValueError, match="method 'umbrella' follows 'rain'"):
        MethodSpec("umbrella", "a:b", follows=FIRST | {"rain"})


def test_each_rule_is_followed_by_a_planner_and_by_check() -> None:
    """No rule stands in the table that nobody plans with, but for those that cannot go together."""
    planned = set().union(*(spec(name, group).follows for group, name in METHODS))
    assert planned == RULES.keys() - TOGETHER
    from adr_opt.judge.check.verdict import FOLLOWS

    assert FOLLOWS.follows == RULES.keys()


def test_bundles_are_those_of_1_0() -> None:
    """A later rule is in no bundle, so that nobody follows it unasked."""
    assert len(FIRST) == 27
    assert len(CAMPAIGNS) == 7
    assert len(TOURS) == 2
    assert MethodSpec("of 1.0", "a:b").follows == FIRST


def test_policies_play_what_the_environment_does() -> None:
    """The specification of `ppo` and the environment name the same rules."""
    assert spec("ppo").follows == PLAYED.follows


@pytest.mark.parametrize("draw", DRAWS)
def test_cargo_counts_where_tanks_are_told_of_it(draw: str) -> None:
    """The rules of cargo bind an instance where some chaser of it has loads, and nowhere else."""
    for seed in range(40):
        instance = DRAWS[draw](seed)
        loads = [loads_of(instance, chaser, 0.0) for chaser in instance.chasers]
        assert any(each is not None for each in loads) == any(support.binding(instance, CARGO)), (
            seed
        )


@pytest.mark.parametrize(("group", "name"), METHODS)
def test_methods_refuse_a_new_field_and_a_rule_they_do_not_name(
    group: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each planner and bound, before anything is computed, in one sentence that names the field."""
    call = adr_opt.solve if group == PLANNERS else adr_opt.bound
    instance = adr_opt.generate("tiny", 0, targets=5)
    for place in ("mission", "targets[].orbit", "chasers[].tank"):
        with pytest.raises(InputError, match=f"{place}.novel".replace("[", r"\[")):
            call(with_new_field(instance, place), name, time_limit=1.0)
    known = spec(name, group).follows
    for word in sorted(RULES.keys() - known):
        monkeypatch.setitem(RULES, word, RULES[word]._replace(binds=lambda _: True))
        with pytest.raises(InputError, match=f"method '{name}' does not follow"):
            call(instance, name, time_limit=1.0)
        monkeypatch.undo()


def test_a_refusal_names_methods_of_the_same_kind() -> None:
    """A planner that is refused names planners, and a bound bounds, each once."""
    instance = adr_opt.generate("tiny", 0, targets=3)
    chaser = instance.chaser.replace(max_visits_between_refuels=1)
    limited = instance.replace(chasers=(chaser,))
    for call, name, others in (
        (adr_opt.solve, "local-search", PLANNERS),
        (adr_opt.bound, "mip", BOUNDS),
    ):
        with pytest.raises(InputError, match="does not follow visits between") as error:
            call(limited, name, time_limit=1.0)
        told = str(error.value).partition("use one of: ")[2].partition(", or ")[0].split(", ")
        able = [
            each
            for each in names(others)
            if "visits between refuellings" in spec(each, others).follows
        ]
        assert told == able


def test_files_of_transfers_refuse_several_chasers_as_all_do(tmp_path: Path) -> None:
    """The sentence is that of the table of rules, with its field and what to do."""
    instance = rich().replace(keep_out_zones=())
    with pytest.raises(InputError, match=r"does not follow several chasers \(field chasers\)"):
        write_matrix(instance, tmp_path / "out.npz", [0.0])


NESTED = ("mission", "targets[].orbit", "chasers[].tank")
"""Places of the fields that tools are tried with."""


@pytest.fixture(scope="module")
def planned() -> tuple[Instance, Plan, Certificate]:
    """An instance with its plan and a certificate."""
    instance = adr_opt.generate("tiny", 0, targets=4)
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    assert result.plan is not None
    return instance, result.plan, certificate_of(instance, result)


def _calls(instance: Instance, plan: Plan, certificate: Certificate) -> dict[str, Any]:
    """Whatever in Python reads an instance, by name."""
    return {
        "Mission": lambda: adr_opt.Mission(instance),
        "Problem": lambda: Problem(instance),
        "Timetable": lambda: adr_opt.Timetable(instance),
        "check": lambda: adr_opt.check(instance, plan),
        "verify": lambda: adr_opt.verify(instance, plan, certificate),
        "plan_of": lambda: adr_opt.plan_of(instance, plan.destinations),
        "price": lambda: price(instance, plan.destinations),
        "replan": lambda: replan(instance, plan, 0.0),
        "compare": lambda: compare(instance, {"one": plan, "two": plan}),
        "refine": lambda: adr_opt.refine(instance, plan),
        "solve_refined": lambda: adr_opt.solve_refined(instance),
        "fly": lambda: fly(instance, plan),
        "write_plan": lambda: write_plan(instance, plan, "out.oem"),
        "write_matrix": lambda: write_matrix(instance, "out.npz", [0.0]),
        "report": lambda: page(instance, plan),
        "tradeoff": lambda: tradeoff(instance, [Axis("duration", (86400.0,))]),
        "rehearse": lambda: rehearse(instance, plan, Uncertainty(), samples=1),
        "robust": lambda: robust(instance, Uncertainty(), 0.9),
        "environment": lambda: MissionEnv(instance).reset(),
        "designs": lambda: rating_of(instance, None),
        "scenario": lambda: check_template(instance),
        "frontier": lambda: check_frontier(instance),
        "windows": lambda: windows_of(instance, CaptureConditions(light=True)),
    }


@pytest.mark.parametrize("place", NESTED)
def test_whatever_reads_an_instance_refuses_a_new_field(
    planned: tuple[Instance, Plan, Certificate],
    place: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each function of the package names the field, and computes nothing."""
    monkeypatch.chdir(tmp_path)
    changed = with_new_field(planned[0], place)
    for name, call in _calls(changed, *planned[1:]).items():
        with pytest.raises(InputError) as error:
            call()
        assert f"does not know the field {place}.novel" in str(error.value), name


CLI_CALLS = {
    "windows": "--light",
    "solve": "",
    "bound": "",
    "check": "plan.json",
    "verify": "plan.json certificate.json",
    "price": "debris-001",
    "compare": "plan.json other.json",
    "tradeoff": "--vary duration=1:1:1",
    "replan": "plan.json --at 0",
    "rehearse": "plan.json --uncertainty uncertainty.json",
    "fly": "plan.json",
    "refine": "plan.json --out r.json",
    "dispose": "plan.json",
    "matrix": "--at 0 --out m.npz",
    "export": "plan.json --out a.oem",
    "report": "plan.json --out a.html",
    "serve": "--port 0",
}
"""What follows the instance in a call of each verb that reads one."""


def test_verbs_refuse_a_new_field(
    planned: tuple[Instance, Plan, Certificate], cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each verb that takes an instance says in one sentence that it does not know the field."""
    instance, plan, certificate = planned
    reading = {verb for verb in VERBS if _takes_instance(verb)}
    assert reading == CLI_CALLS.keys() | {"screen"}  # which reads refined plans alone, see below
    instance.save("my.json")
    plan.save("plan.json")
    plan.save("other.json")
    certificate.save("certificate.json")
    Uncertainty().save("uncertainty.json")
    changed = with_new_field(instance, "targets[]")
    monkeypatch.setattr("adr_opt.problem.instance.load", lambda path: changed)
    for verb, more in CLI_CALLS.items():
        refused(cli(verb, "my.json", *more.split()), "does not know the field targets[].novel")


def test_verbs_that_read_refined_plans_refuse_a_new_field(
    planned: tuple[Instance, Plan, Certificate], cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same of a refined plan, whose instance has a field that nobody knows."""
    instance, plan, _ = planned
    instance.save("my.json")
    plan.save("plan.json")
    adr_opt.refine(instance, plan).save("refined.json")
    changed = with_new_field(instance, "targets[]")
    monkeypatch.setattr("adr_opt.problem.instance.load", lambda path: changed)
    for call in (
        "check my.json refined.json",
        "fly my.json refined.json",
        "export my.json refined.json --out a.oem",
        "screen my.json refined.json my.json",
        "report my.json plan.json --refined refined.json --out a.html",
    ):
        refused(cli(*call.split()), "does not know the field targets[].novel")


def _takes_instance(verb: str) -> bool:
    found = command.get_command(click.Context(command), verb)
    return found is not None and any(each.name == "instance_path" for each in found.params)


def test_an_instance_is_taken_by_who_says_what_it_follows() -> None:
    """Only `followed` makes an instance of what a caller passes, and who asks a judge or episodes.

    The gate hands on to judges, each of which refuses; environments refuse as they begin to play.
    """
    root = Path(adr_opt.__file__).parent
    found = {
        path.relative_to(root).as_posix()
        for path in root.rglob("*.py")
        if re.search(r"(?<![\w.])instance_of\((?!self)", path.read_text(encoding="utf-8"))
    }
    assert found == {
        "problem/instance.py",
        "problem/support.py",
        "judge/admit.py",
        "learning/environment/mission_env.py",
        "learning/environment/vector.py",
    }
