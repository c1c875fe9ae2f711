"""``verify``, and ``--certificate`` of ``solve`` and ``bound``, on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Cli, refused
from drifting_plans import drifting_instance

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify.verdict import MOST_CONNECTIONS
from adr_opt.plan.certificate import load_certificate
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli import verify as verify_verb


@pytest.fixture
def instance(tmp_path: Path) -> Instance:
    """A mission in a file, of which a part of the targets can be visited."""
    made = adr_opt.generate("tiny", 3, targets=7).with_limits(delta_v_m_s=700.0)
    made.save(tmp_path / "i.json")
    return made


def test_a_proof_is_written_and_verified(cli: Cli, instance: Instance) -> None:
    """`solve` writes plan and certificate, and `verify` says what follows, also as JSON."""
    solved = cli("solve", "i.json", "--method", "exact", "--out", "p.json", "--certificate", "c.gz")
    assert solved.status == 0, solved.err
    assert "wrote c.gz: upper bound" in solved.err
    said = cli("verify", "i.json", "p.json", "c.gz", "--connections", 50)
    assert said.status == 0, said.out
    assert "c.gz: verified: no plan collects more than" in said.out
    assert "optimal" in said.out
    found = json.loads(cli("verify", "i.json", "p.json", "c.gz", "--json").out)
    assert found["verified"]
    assert found["gap"] == 0.0
    assert found["connections"] == 1000
    assert found["upper_bound"] == found["objective"]


def test_a_plan_may_be_flown_after_its_proof(cli: Cli) -> None:
    """The flight that `solve` writes into the plan leaves the certificate beside it valid."""
    drifting_instance().save("i.json")
    cli("solve", "i.json", "--method", "exact", "--out", "p.json", "--certificate", "c.json")
    assert adr_opt.load_plan("p.json").flown is not None
    said = cli("verify", "i.json", "p.json", "c.json", "--connections", 50)
    assert said.status == 0, said.out


def test_a_bound_alone_is_written_and_verified(cli: Cli, instance: Instance) -> None:
    """`bound` writes a certificate that needs no plan, and judges any."""
    made = cli("bound", "i.json", "--method", "lagrangian", "--certificate", "c.json")
    assert made.status == 0, made.err
    assert cli("verify", "i.json", "c.json").status == 0
    cli("solve", "i.json", "--method", "greedy", "--out", "p.json")
    said = cli("verify", "i.json", "p.json", "c.json")
    assert said.status == 0
    assert "the plan collects" in said.out


def test_a_false_certificate_is_refused(cli: Cli, instance: Instance) -> None:
    """Exit status 1, and why: another bound, another plan."""
    cli("solve", "i.json", "--method", "exact", "--out", "p.json", "--certificate", "c.json")
    content = json.loads(Path("c.json").read_text())
    content["upper_bound"] -= 1.0
    Path("c.json").write_text(json.dumps(content))
    said = cli("verify", "i.json", "p.json", "c.json")
    assert said.status == 1
    assert "refused: the certificate states" in said.out
    found = cli("verify", "i.json", "p.json", "c.json", "--json")
    assert found.status == 1
    assert not json.loads(found.out)["verified"]


def test_an_infeasible_mission_has_a_certificate(cli: Cli, tmp_path: Path) -> None:
    """Where there is no plan, the certificate of says so, and is verified."""
    made = adr_opt.generate("tiny", 3, targets=4).with_limits(delta_v_m_s=1.0)
    targets = (made.targets[0].replace(required=True), *made.targets[1:])
    made.replace(targets=targets).save(tmp_path / "i.json")
    for verb in ("bound", "solve"):
        assert cli(verb, "i.json", "--method", "exact", "--certificate", "c.json").status == 1
        said = cli("verify", "i.json", "c.json")
        assert said.status == 0
        assert "verified: no plan keeps all rules" in said.out
        Path("c.json").unlink()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--method", "beam"), "use one of: auto, exact"),
        (("--method", "exact", "--margin", "0.1"), "--margin"),
        (("--method", "exact", "--refine"), "--refine"),
        (("--method", "exact", "--certificate", "i.json"), "this is the input"),
        (("--method", "exact", "--out", "c.json"), "the name of another result, too"),
        (("--method", "exact", "--certificate", "none/c.json"), "does not exist"),
    ],
    ids=["method", "margin", "refine", "input", "plan", "folder"],
)
def test_what_can_have_no_certificate_is_said_before_any_work(
    cli: Cli, instance: Instance, arguments: tuple[str, ...], named: str
) -> None:
    """One sentence, and nothing is written."""
    refused(cli("solve", "i.json", "--certificate", "c.json", *arguments), named)
    assert sorted(path.name for path in Path().iterdir()) == ["i.json"]


def test_where_nothing_was_proven_there_is_no_certificate(cli: Cli, instance: Instance) -> None:
    """The plan is on standard output all the same."""
    said = cli(
        "solve i.json --method auto --option prove=false --iterations 1 --certificate c.json"
    )
    assert said.status == 2
    assert "has proven no bound" in said.err
    assert '"format": "adr-opt-plan/2"' in said.out
    assert not Path("c.json").exists()


def test_wrong_files_are_one_sentence(cli: Cli, instance: Instance) -> None:
    """Too few or too many files, a plan in place of a certificate, another instance."""
    refused(cli("verify", "i.json"), "give an instance, a certificate")
    refused(cli("verify", "i.json", "a", "b", "c"), "give an instance, a certificate")
    refused(cli("verify", "i.json", "i.json"), "i.json", "field")
    cli("bound", "i.json", "--method", "exact", "--certificate", "c.json")
    adr_opt.generate("tiny", 4).save("other.json")
    refused(cli("verify", "other.json", "c.json"), "c.json: the certificate belongs to")
    adr_opt.solve("other.json", method="greedy").plan.save("p.json")
    refused(cli("verify", "i.json", "p.json", "c.json"), "p.json: the plan belongs to")
    refused(cli("verify", "i.json", "c.json", "--labels", "l.npz"), "adr-opt: l.npz: no such file")


def test_there_are_only_so_many_connections(cli: Cli, instance: Instance) -> None:
    """A number of connections that would take days is refused, here and in Python."""
    solved = cli("solve", "i.json", "--method", "exact", "--out", "p.json", "--certificate", "c.gz")
    assert solved.status == 0, solved.err
    call = ("verify", "i.json", "p.json", "c.gz", "--connections")
    refused(cli(*call, "99999999999"), "--connections", "99999999999", "0<=x<=1000000")
    refused(cli(*call, "-1"), "--connections")
    certificate = load_certificate("c.gz")
    for number in (-1, MOST_CONNECTIONS + 1, 99999999999):
        with pytest.raises(InputError, match=f"connections = {number}: must be from 0 to 1000000"):
            adr_opt.verify(instance, None, certificate, connections=number)
    assert verify_verb.MOST_CONNECTIONS == MOST_CONNECTIONS
