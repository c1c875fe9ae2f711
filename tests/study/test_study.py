"""Studies: a row is made once, whoever makes it, and what is in the file is believed as it is."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from study_rows import Rows, asleep, squares, told, unsendable

from adr_opt.common.errors import InputError
from adr_opt.common.stop import Interrupted
from adr_opt.study import Place, Run, Study, WorkerDied, run
from adr_opt.study.file import StudyFile, head_of, line_of, read

WHOLE = {key: {"square": key * key} for key in range(4)}


@pytest.fixture
def rows(tmp_path: Path) -> Rows:
    """Rows that leave their marks in a folder."""
    return Rows(tmp_path)


def test_a_run_goes_on_wherever_its_file_was_cut_off(
    rows: Rows, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After any number of bytes the rest is made, and the file holds what an unbroken run wrote."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)
    path, study = tmp_path / "a.jsonl", squares(rows)
    assert run(study, WHOLE, path) == WHOLE
    content = path.read_bytes()
    assert content.count(b"\n") == 5
    for kept in range(len(content) + 1):
        path.write_bytes(content[:kept])
        before = [rows.made(key) for key in WHOLE]
        assert run(study, WHOLE, path) == WHOLE
        whole = max(content[:kept].count(b"\n") - 1, 0)
        assert [rows.made(key) for key in WHOLE] == [
            made + (key >= whole) for key, made in enumerate(before)
        ]
        assert [json.loads(line)["key"] for line in path.read_text().splitlines()[1:]] == [*WHOLE]


@pytest.mark.parametrize(
    "line",
    [
        "{}",
        "",
        "notes",
        '{"key":1,"value":1}',
        '{"key":1,"value":1,"seconds":-1}',
        '{"key":1,"value":1,"seconds":0,"x":0}',
        '{"key":1,"key":2,"value":1,"seconds":0}',
        '{"key":NaN,"value":1,"seconds":0}',
        '{"key":1,"value":[1e999],"seconds":0}',
        '{"key":1,"value":1,"seconds":Infinity}',
        "[" * 99_999,
    ],
)
def test_a_bad_line_is_refused_wherever_it_stands(rows: Rows, tmp_path: Path, line: str) -> None:
    """One sentence names the line, even of a key that is not asked for; the file stays."""
    path, study = tmp_path / "a.jsonl", squares(rows)
    run(study, [0, 1], path)
    lines = path.read_text().splitlines(keepends=True)
    for place in (2, 3, 4):
        text = "".join([*lines[: place - 1], line + "\n", *lines[place - 1 :]])
        path.write_text(text)
        with pytest.raises(InputError, match=rf"a\.jsonl: line {place}: "):
            run(study, [5], path)
        assert path.read_text() == text


@pytest.mark.parametrize(
    "content",
    [
        b"notes",
        b"notes\n",
        b"\n",
        b"\xff\n",
        b'{"format": "x"}\n',
        b'{"format": []}\n',
        b"[" * 99_999 + b"\n",
    ],
)
def test_other_files_are_refused_and_stay(rows: Rows, tmp_path: Path, content: bytes) -> None:
    """A file without the head, even one without the end of a line, is not written to."""
    path = tmp_path / "a.jsonl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.jsonl: not a file of a study \(squares\)"):
        run(squares(rows), WHOLE, path)
    assert path.read_bytes() == content


def test_files_of_other_work_are_refused(rows: Rows, tmp_path: Path) -> None:
    """Another protocol, version or setting, whole or cut off in the head, is told and stays."""
    path = tmp_path / "a.jsonl"
    run(squares(rows), [1], path)
    content = path.read_bytes()
    for study, said in (
        (squares(rows, version=2), "rows of 'squares', version 1, and not of 'squares', version 2"),
        (Study("cubes", 1, rows.row), "rows of 'squares', version 1, and not of 'cubes'"),
        (squares(rows, of="else"), "made with other settings; name another file"),
    ):
        with pytest.raises(InputError, match=said):
            run(study, [1], path)
        assert path.read_bytes() == content
        path.write_bytes(content[: content.index(b"\n") - 1])
        with pytest.raises(InputError, match="name another"):
            run(study, [1], path)
        path.write_bytes(content)


@pytest.mark.parametrize("head", ["designs", "scenario", "rehearsals"])
def test_files_of_the_first_version_are_told(rows: Rows, tmp_path: Path, head: str) -> None:
    """A file of 1.0 is refused by its name, not as damaged."""
    path = tmp_path / "a.jsonl"
    path.write_text(f'{{"format":"adr-opt-{head}/1"}}\n{{}}\n')
    with pytest.raises(InputError, match=r"a\.jsonl: a file of adr-opt 1\.0"):
        run(squares(rows), [1], path)


def test_a_row_that_is_none_of_the_study_is_refused(rows: Rows, tmp_path: Path) -> None:
    """What the study does not read as a row of its own is refused with its line."""

    def strict(key: int, value: dict[str, int]) -> dict[str, int]:
        if float(value["square"]) != key * key:
            raise InputError("no square")
        return value

    path = tmp_path / "a.jsonl"
    run(squares(rows), [1, 2], path)
    text = path.read_text()
    for other, said in (
        ('{"square":5}', "line 3: no square"),
        ("{}", "line 3: not a row of squares"),
        (f'{{"square":1{400 * "0"}}}', "line 3: not a row of squares"),
    ):
        path.write_text(text.replace('{"square":4}', other))
        with pytest.raises(InputError, match=said):
            run(squares(rows, from_json=strict), [1, 2], path)


def test_the_last_row_of_a_key_counts(rows: Rows, tmp_path: Path) -> None:
    """A row that is forgotten is made anew, and from then on the file says so."""
    path = tmp_path / "a.jsonl"
    failing = squares(Rows(tmp_path, raises=(1,)), failed=told)
    assert run(failing, [0, 1], path)[1] == {"failed": "InputError"}
    study = squares(rows, failed=told)
    assert run(study, [0, 1], path)[1] == {"failed": "InputError"}
    with Run(study, path) as again:
        again.forget(1)
        assert dict(again.rows([(0, 1)])) == {0: WHOLE[0], 1: WHOLE[1]}
    assert run(study, [0, 1], path)[1] == WHOLE[1]
    assert len(path.read_text().splitlines()) == 4


def test_an_error_ends_the_study_or_is_a_row(rows: Rows, tmp_path: Path) -> None:
    """A row that raises ends all, with the rows before it kept; a study may want it as a row."""
    path = tmp_path / "a.jsonl"
    broken = Rows(tmp_path, raises=(2,))
    for jobs in (1, 2):
        path.unlink(missing_ok=True)
        with pytest.raises(InputError, match="2 has no square"):
            run(squares(broken), [0, 1, 2], path, jobs=jobs)
        kept = read(path, squares(broken))
        assert set(kept) <= {"0", "1"}
        assert jobs == 2 or len(kept) == 2
    assert run(squares(broken, failed=told), [2, 3])[2] == {"failed": "InputError"}
    with pytest.raises(RuntimeError, match=r"Odd: \d is odd"):
        run(Study("odd", 1, unsendable), [1, 2], jobs=2)


def test_processes_make_the_rows_of_one(rows: Rows, tmp_path: Path) -> None:
    """Two processes make what one does; a process that is killed over a row tries it once more."""
    falling = Rows(tmp_path, dies=(1,), stumbles=(2,))
    path = tmp_path / "a.jsonl"
    found = run(squares(falling, failed=told), WHOLE, path, jobs=2)
    assert found == WHOLE | {1: {"failed": "WorkerDied"}}
    assert [falling.made(key) for key in WHOLE] == [1, 2, 2, 1]
    assert set(read(path, squares(rows))) == set(map(str, WHOLE))
    with pytest.raises(WorkerDied, match="its process died twice"):
        run(squares(falling, apart=True), [1])


def test_a_group_loses_only_the_row_that_kills(tmp_path: Path) -> None:
    """Of keys that are made one after the other, those before and after a killing one are made."""
    falling = Rows(tmp_path, dies=(1,))
    with Run(squares(falling, failed=told, apart=True)) as running:
        found = dict(running.rows([tuple(WHOLE)]))
    assert found == WHOLE | {1: {"failed": "WorkerDied"}}
    assert [falling.made(key) for key in WHOLE] == [1, 2, 1, 1]


def test_a_group_is_asked_for_when_it_can_be_made(rows: Rows) -> None:
    """The next keys may depend on all rows so far, as where the best ones are looked for."""
    found: dict[int, int] = {}

    def growing() -> object:
        while sum(found.values()) < 100:
            yield (len(found),)

    with Run(squares(rows)) as running:
        for key, row in running.rows(growing()):
            found[key] = row["square"]
    assert sum(found.values()) == 140


def test_a_stop_leaves_out_what_it_cuts_short(tmp_path: Path) -> None:
    """What is being made when the stop falls is not kept, in this process or another."""
    path, stop = tmp_path / "a.jsonl", Interrupted()

    def cut_short(key: int, place: Place) -> int:
        if key == 2:
            stop.interrupt()
        return key

    study = Study("stopped", 1, cut_short)
    assert run(study, range(5), path, stop=stop) == {0: 0, 1: 1}
    assert set(read(path, study)) == {"0", "1"}

    stop = Interrupted()
    began = time.monotonic()
    found = {}
    with Run(Study("asleep", 1, asleep), jobs=2, stop=stop) as running:
        for key, row in running.rows([(600,), (0,)]):
            found[key] = row
            stop.interrupt()
    assert found == {0: 0}
    assert time.monotonic() - began < 300.0


SCRIPT = """
import signal, sys, time
from adr_opt.study import Study, run
def slow(key, place):
    time.sleep(0.2 * (key > 0) + 60.0 * (key > 1))
    return key
if __name__ == "__main__":
    # Shells have it ignored in what they start in the background.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    done = lambda done, of: print(done, flush=True)
    run(Study("slow", 1, slow), range(9), sys.argv[1], jobs=int(sys.argv[2]), told=done)
"""


@pytest.mark.parametrize("jobs", ["1", "2"])
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL])
def test_an_end_from_outside_leaves_a_file_to_go_on_from(
    tmp_path: Path, sign: signal.Signals, jobs: str
) -> None:
    """Ctrl-C and a kill leave all finished rows, and no process that goes on."""
    script, path = tmp_path / "slow.py", tmp_path / "a.jsonl"
    script.write_text(SCRIPT)
    child = subprocess.Popen(
        [sys.executable, str(script), str(path), jobs],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert child.stdout is not None
    assert [child.stdout.readline() for _ in range(2)] == ["1\n", "2\n"]
    os.kill(child.pid, sign)
    child.communicate(timeout=300)
    assert set(read(path, Study("slow", 1, asleep))) == {"0", "1"}
    for _ in range(3000):
        try:
            os.killpg(child.pid, 0)
        except ProcessLookupError:
            break
        time.sleep(0.1)
    else:
        pytest.fail("processes are left")


def test_one_writer_at_a_time(rows: Rows, tmp_path: Path) -> None:
    """A second run on a file is refused as long as the first goes on; readers are not."""
    path, study = tmp_path / "a.jsonl", squares(rows)
    with Run(study, path) as first:
        dict(first.rows([(0,)]))
        with pytest.raises(InputError, match=r"a\.jsonl: another call is writing to it"):
            run(study, [1], path)
        assert set(read(path, study)) == {"0"}
    assert set(run(study, [0, 1], path)) == {0, 1}


def test_progress_is_told(rows: Rows, tmp_path: Path) -> None:
    """Each row that is made is told with the number of all, those of the file among them."""
    path, heard = tmp_path / "a.jsonl", []
    run(squares(rows), [0, 1], path)
    run(squares(rows), [0, 1, 2, 1], path, told=lambda done, of: heard.append((done, of)))
    assert heard == [(3, 3)]


@pytest.mark.parametrize(("jobs", "cluster"), [(-1, None), (2, "dask://a:1")])
def test_impossible_numbers_of_processes_are_refused(
    rows: Rows, tmp_path: Path, jobs: int, cluster: str | None
) -> None:
    """Fewer than no processes, or processes beside a cluster: one sentence, before any file."""
    with pytest.raises(InputError, match="jobs"):
        run(squares(rows), [1], tmp_path / "a.jsonl", jobs=jobs, cluster=cluster)
    assert not (tmp_path / "a.jsonl").exists()


@pytest.mark.parametrize("kept", [0, 1, 2])
def test_a_row_that_cannot_be_written_leaves_nothing(rows: Rows, tmp_path: Path, kept: int) -> None:
    """On a full disk nothing of a row is left, and rows before it are."""
    path, study = tmp_path / "a.jsonl", squares(rows)
    before = b"".join([line_of(head_of(study)), line_of({"key": 0, "value": 1, "seconds": 0.0})])
    path.write_bytes(b"".join(before.splitlines(keepends=True)[:kept]))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    file = StudyFile(path, study)
    whole = path.read_bytes()
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(InputError, match="cannot be written"):
            file.append([(1, "x" * 8192, 0.0)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        file.close()
    assert path.read_bytes() == whole


def test_a_number_that_is_not_finite_is_not_written(rows: Rows, tmp_path: Path) -> None:
    """JSON has no infinity: such a row is an error of the program, and nothing of it is written."""
    file = StudyFile(tmp_path / "a.jsonl", squares(rows))
    with pytest.raises(ValueError, match="JSON"):
        file.append([(1, float("inf"), 0.0)])
    file.close()
    assert read(tmp_path / "a.jsonl", squares(rows)) == {}
