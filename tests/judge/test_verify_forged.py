"""Forged certificates: whatever is changed, what is accepted is true, and forgeries are refused."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from random_rules import falling
from varied_fields import variant

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.files import parse_model
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.plan.certificate import Certificate, sha256_of
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance

Draft = dict[str, Any]
FORGED = 216
"""Number of forged certificates."""


class Case:
    """A proven mission, its optimum, and its certificate as plain data."""

    def __init__(self, instance: Instance) -> None:
        result = adr_opt.solve(instance, "exact", time_limit=60.0)
        assert result.plan is not None
        self.instance, self.plan = instance, result.plan
        self.best = brute_force(Mission(instance))[0]
        self.certificate = certificate_of(instance, result)
        step = self.certificate.prize_step
        prizes = [prize for target in instance.targets for prize in target.prizes]
        positive = [prize for prize in prizes if prize > 0.0]
        self.step = step if step is not None else 0.01 * min(positive)

    @property
    def draft(self) -> Draft:
        """A copy of the certificate that can be changed."""
        return json.loads(self.certificate.to_json())


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    """Missions whose proofs rest on walks."""
    found = [Case(variant(seed)) for seed in range(20)]
    fallen = [Case(falling(variant(seed), seed)) for seed in range(40, 46)]
    kinds = ([case for case in each if case.certificate.walks] for each in (found, fallen))
    return [case for kind, most in zip(kinds, (10, 3), strict=True) for case in kind[:most]]


def lower_bound(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """The bound is lowered, and nothing else."""
    draft["upper_bound"] = max(0.0, draft["upper_bound"] - case.step * rng.integers(1, 3))


def lower_most(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Walks are said to collect less, and the bound that would follow is claimed."""
    less = case.step * int(rng.integers(1, 4))
    draft["walks"][0]["most"] -= less
    draft["upper_bound"] = max(0.0, draft["upper_bound"] - less)


def no_plan(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """It is said that there is no plan at all."""
    draft["walks"][0]["most"] = -1.0 - math.fsum(draft["multipliers"].values())
    draft["upper_bound"] = None


def remember_all(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Walks remember all, and are said to collect less than the best plan does."""
    names = list(case.instance.names)
    draft["walks"][0]["neighbourhoods"] = {name: names for name in names}
    lower_most(draft, plan, case, rng)


def change_multipliers(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Multipliers are others, and the bound is one that no multipliers give."""
    for target in case.instance.targets:
        if rng.random() < 0.5:
            draft["multipliers"][target.name] = float(rng.uniform(0.0, 2.0))
    total = math.fsum(draft["multipliers"].values())
    draft["walks"][0]["most"] = case.best - total - 0.5 * case.step
    draft["upper_bound"] = max(0.0, case.best - case.step)


def lower_a_multiplier(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """A multiplier is less than nothing, which would make any bound follow."""
    name = str(rng.choice([target.name for target in case.instance.targets]))
    draft["multipliers"][name] = -float(rng.uniform(0.1, 5.0))


def no_walks(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Nothing is said of walks."""
    draft["walks"], draft["multipliers"] = [], {}


def other_step(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Bounds are rounded down to steps that prizes do not have."""
    draft["prize_step"] = 1.7 * sum(target.prize for target in case.instance.targets)
    draft["upper_bound"] = 0.0


def other_required(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Another chaser's walks, or one twice, or none of a chaser there is."""
    draft["walks"][0]["chasers"] = [["nobody"], ["chaser", "chaser"], []][int(rng.integers(3))]


def strange_name(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """A multiplier or a memory of a body that is not there."""
    if rng.random() < 0.5:
        draft["multipliers"]["Vanguard 1"] = 1.0
    else:
        draft["walks"][0]["neighbourhoods"]["Vanguard 1"] = []


def drawn_cut(case: Case, rng: np.random.Generator) -> Draft:
    """A cut with any memory and multiplier."""
    names = list(case.instance.names)
    targets = [target.name for target in case.instance.targets]
    return {
        "targets": [str(name) for name in rng.choice(targets, 3, replace=False)],
        "memory": [name for name in names if rng.random() < 0.8],
        "multiplier": float(rng.uniform(0.0, 1.5)),
    }


def paid_for_nothing(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """Walks are said to pay for cuts more than those count."""
    draft["cuts"] = [drawn_cut(case, rng) for _ in range(3)]
    paid = math.fsum(cut["multiplier"] for cut in draft["cuts"])
    draft["walks"][0]["most"] -= paid + case.step
    draft["upper_bound"] = max(0.0, draft["upper_bound"] - case.step)


def false_cut(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """A cut that is none: of one target thrice, of a station, paid back, or of strange bodies."""
    cut = drawn_cut(case, rng)
    draft["cuts"] = [cut]
    kind = int(rng.integers(5))
    if kind == 0:
        cut["targets"][1] = cut["targets"][0]
    elif kind == 1:
        cut["targets"][2] = case.instance.names[0]
    elif kind == 2:
        cut["multiplier"] = -1.0
    elif kind == 3:
        cut["memory"].append("Vanguard 1")
    else:
        cut["targets"].pop()


def other_instance(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """It is the certificate of another instance."""
    digits = list(draft["instance"]["sha256"])
    at = int(rng.integers(64))
    digits[at] = "0" if digits[at] != "0" else "1"
    draft["instance"]["sha256"] = "".join(digits)


def other_plan(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """It was written beside another plan."""
    draft["plan_sha256"] = "0" * 64


def changed_leg(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """A leg of the plan is changed, and the certificate says that it belongs to it."""
    leg = plan["routes"][0]["legs"][int(rng.integers(len(plan["routes"][0]["legs"])))]
    field = str(rng.choice(["departure_s", "arrival_s", "delta_v_m_s", "end_s", "destination"]))
    leg[field] = leg["origin"] if field == "destination" else leg[field] * 1.01 + 1.0
    draft["plan_sha256"] = sha256_of(Plan.from_json(json.dumps(plan)))


def better_plan(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """The plan states less than the bound that follows, and that it has less to gain."""
    del plan["routes"][0]["legs"][-1]
    gone = {leg["destination"] for leg in plan["routes"][0]["legs"]}
    prizes = {target.name: target.prize for target in case.instance.targets}
    plan["unvisited"] = [
        {"target": name, "reason": "delta-v"} for name in prizes if name not in gone
    ]
    plan["objective"] = sum(prizes.get(name, 0.0) for name in gone)
    plan["upper_bound"], plan["gap"], plan["status"] = plan["objective"], 0.0, "optimal"
    plan["cost"] = sum(leg["delta_v_m_s"] for leg in plan["routes"][0]["legs"])
    draft["plan_sha256"] = sha256_of(Plan.from_json(json.dumps(plan)))
    draft["upper_bound"] = plan["objective"]


def unknown_key(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """There is an unknown key."""
    place = draft if rng.random() < 0.5 else draft["walks"][0]
    place["trust_me"] = True


def truncated(draft: Draft, plan: Draft, case: Case, rng: np.random.Generator) -> None:
    """The file ends early."""
    draft["truncated"] = float(rng.uniform(0.05, 0.98))


FORGERIES: list[Callable[[Draft, Draft, Case, np.random.Generator], None]] = [
    lower_bound,
    lower_most,
    no_plan,
    remember_all,
    change_multipliers,
    lower_a_multiplier,
    no_walks,
    other_step,
    other_required,
    strange_name,
    other_instance,
    other_plan,
    changed_leg,
    better_plan,
    unknown_key,
    truncated,
    paid_for_nothing,
    false_cut,
]


def is_refused(case: Case, draft: Draft, plan: Draft) -> bool:
    """Whether what was made of a certificate and a plan is refused, in words."""
    share = draft.pop("truncated", 1.0)
    text = json.dumps(draft)
    try:
        certificate = read(text[: int(share * len(text))])
        verdict = verify(
            case.instance, Plan.from_json(json.dumps(plan)), certificate, connections=5
        )
    except InputError as error:
        return str(error) != ""
    return len(verdict.reasons) > 0


def read(text: str) -> Certificate:
    """As a file is read."""
    return parse_model(text, Certificate, "forged.json")


@pytest.mark.parametrize(
    "draws", [2, pytest.param(FORGED // len(FORGERIES), marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("forge", FORGERIES, ids=lambda forge: forge.__name__)
def test_forgeries_are_refused(cases, forge, draws):
    """Certificates, each made false or at odds with itself, are refused."""
    for number in range(draws):
        case = cases[number % len(cases)]
        rng = np.random.default_rng([FORGERIES.index(forge), number])
        draft, plan = case.draft, json.loads(case.plan.to_json())
        forge(draft, plan, case, rng)
        assert is_refused(case, draft, plan), (number, draft)


def test_the_cases_are_good_ones(cases):
    """Unchanged all are verified, also as changed as makes no difference; some need labels."""
    remembering = 0
    for case in cases:
        draft, plan = case.draft, json.loads(case.plan.to_json())
        assert not is_refused(case, dict(draft), plan)
        draft["delta_v_slot_m_s"] *= 3.0
        draft["walks"][0]["most"] += 1e-9
        assert not is_refused(case, draft, plan)
        remembering += bool(draft["walks"][0]["neighbourhoods"])
    assert len(cases) > 10
    assert remembering > 0


@pytest.mark.parametrize("draws", [50, pytest.param(150, marks=pytest.mark.slow)])
def test_whatever_is_changed_what_is_accepted_is_true(cases, draws):
    """Numbers and memories are changed at random: a bound that is verified is no less than best."""
    accepted = 0
    for number in range(draws):
        case = cases[number % len(cases)]
        rng = np.random.default_rng([99, number])
        draft, names = case.draft, list(case.instance.names)
        for target in case.instance.targets:
            if rng.random() < 0.3:
                draft["multipliers"][target.name] = float(rng.uniform(0.0, 3.0))
        if rng.random() < 0.5:
            draft["walks"][0]["neighbourhoods"] = {
                name: [other for other in names if rng.random() < 0.5] for name in names
            }
        draft["walks"][0]["most"] += float(rng.normal(0.0, 1.0))
        if rng.random() < 0.5:
            draft["cuts"] = [drawn_cut(case, rng) for _ in range(int(rng.integers(1, 6)))]
        draft["upper_bound"] = max(0.0, draft["upper_bound"] + float(rng.normal(0.0, 1.0)))
        draft["prize_step"] = None if rng.random() < 0.5 else draft["prize_step"]
        draft["required_worth"] = float(rng.uniform(0.0, 5.0))
        draft["delta_v_slot_m_s"] = float(rng.uniform(1.0, 300.0))
        verdict = verify(case.instance, None, read(json.dumps(draft)), connections=0)
        assert verdict.upper_bound >= case.best - 1e-9, (number, draft)
        if verdict.verified:
            accepted += 1
            off = 1e-9 + max(1e-6 * case.best, 0.5 * (draft["prize_step"] or 0.0))
            assert draft["upper_bound"] >= case.best - off, (number, draft)
    assert accepted > draws / 30


@pytest.mark.parametrize("number", [1e-300, 1e-9, 1e17, 1e99, 1e101])
def test_absurd_numbers_are_no_trouble(cases, number):
    """However large or small numbers are, a bound that holds comes out, or one sentence."""
    case = cases[0]
    for field in ("multipliers", "most", "required_worth", "delta_v_slot_m_s", "prize_step"):
        for sign in (1.0, -1.0) if field == "most" else (1.0,):
            draft = case.draft
            if field == "multipliers":
                draft[field] = {target.name: number for target in case.instance.targets}
            elif field == "most":
                draft["walks"][0][field] = sign * number
            else:
                draft[field] = max(number, 0.1) if field == "delta_v_slot_m_s" else number
            try:
                verdict = verify(case.instance, None, read(json.dumps(draft)), connections=0)
            except InputError:
                continue
            assert verdict.upper_bound >= case.best - 1e-9, (field, sign)


def test_a_packed_file_that_is_cut_short_is_one_sentence(cases, tmp_path):
    """A file that is cut short, or was never packed, is one sentence."""
    path = tmp_path / "c.json.gz"
    cases[0].certificate.save(path)
    whole = path.read_bytes()
    for content in (whole[:-20], b"{}", gzip.compress(b"\xff\xfe")):
        path.write_bytes(content)
        with pytest.raises(InputError, match="not a complete gzip file"):
            adr_opt.load_certificate(path)
    with pytest.raises(InputError, match="no such file"):
        adr_opt.load_certificate(tmp_path / "none.json.gz")
