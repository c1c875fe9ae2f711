"""Trade-offs and refined legs by the workers of a Dask cluster."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused
from study_rows import Rows, squares, told

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations
from adr_opt.fly.refine import refine
from adr_opt.study import Run, cluster, run

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="needs distributed")


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler on this machine, with two workers of one thread each."""
    import distributed  # two seconds that other processes of the tests are spared

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    ) as workers:
        yield workers.scheduler_address


@pytest.mark.slow
def test_a_cluster_refines_as_threads_do(address: str) -> None:
    """The legs of a plan are led by workers to where threads lead them."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded", stop=MaxIterations(1)).plan
    assert plan is not None
    here = refine(instance, plan, gravity="j2")
    there = refine(instance, plan, gravity="j2", cluster=address.replace("tcp://", "dask://"))
    assert there.status == here.status == "complete"
    for one, other in zip(here.legs, there.legs, strict=True):
        assert other.burns == one.burns


def test_a_cluster_that_is_not_there_is_one_sentence(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No address, no answer there, or processes as well: exit code 2 before any work."""
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.5)
    assert cli("generate", "tiny", "--out", "tiny.json").status == 0
    call = ["tradeoff", "tiny.json", "--vary", "delta-v=300:900:300", "--cluster"]
    for address, said in (
        ("127.0.0.1:1", "is not an address; write dask://HOST:PORT"),
        ("dask://127.0.0.1:1", "no Dask scheduler answers at dask://127.0.0.1:1"),
    ):
        refused(cli(*call, address), said)
    refused(cli(*call, "dask://127.0.0.1:1", "--jobs", "2"), "exclude each other")


def test_what_workers_lack_is_said(address: str) -> None:
    """A call that needs what a worker lacks is refused with what to do."""
    with cluster.Cluster(address) as workers:
        assert workers.count == 2
        with pytest.raises(InputError, match="install adr-opt there"):
            workers.submit(__import__, "no_such_module").result()


def test_a_cluster_makes_the_rows_of_one_process(address: str, tmp_path: Path) -> None:
    """Rows of groups and of single keys are those of this process, and go on from one file."""
    rows, path = Rows(tmp_path), tmp_path / "a.jsonl"
    run(squares(rows), [0], path)
    found = run(squares(rows), range(9), path, cluster=address, most=2)
    assert found == {key: {"square": key * key} for key in range(9)}
    assert [rows.made(key) for key in range(9)] == [1] * 9
    failing = squares(Rows(tmp_path, raises=(1,)), failed=told)
    assert run(failing, [1], cluster=address) == {1: {"failed": "InputError"}}


class Deadly(ThreadPoolExecutor):
    """A cluster whose workers die over a key, as far as can be told from outside."""

    def __init__(self, address: str) -> None:
        super().__init__(2)
        self.count = 2

    def submit(self, call: Any, /, token: str, row: bytes, keys: bytes) -> Future[Any]:  # type: ignore[override]
        """Make the rows, or die."""
        if 1 not in pickle.loads(keys):
            return super().submit(call, token, row, keys)
        dead: Future[Any] = Future()
        dead.set_exception(cluster.WorkerDied("workers died over a call"))
        return dead


def test_the_row_at_fault_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a group that kills its workers only that row is, and the others are made."""
    monkeypatch.setattr(cluster, "Cluster", Deadly)
    with Run(squares(Rows(tmp_path), failed=told), cluster="dask://a:1") as running:
        found = dict(running.rows([(0, 1, 2), (3,)]))
    assert found == {
        0: {"square": 0},
        1: {"failed": "WorkerDied"},
        2: {"square": 4},
        3: {"square": 9},
    }
