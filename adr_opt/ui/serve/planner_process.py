"""Planning in a child process, which stays loaded from one plan to the next."""

from __future__ import annotations

import json
import shutil
import subprocess
import threading
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ...common.errors import InputError
from ...common.json_text import loaded
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...run.run_options import DEFAULT_METHOD
from .children import end, started
from .planning import Done, Found, PlannedRun, PlanningOrder, PlanningProgress, ignored
from .project.private import passing, private_folder
from .work import check_order

WORKER = f"{__package__}.planner_worker"

LAST_WORDS_S = 2.0
"""Longest wait for an ended process [s]."""


class _Order(NamedTuple):
    """An unfinished order of a process, with the folder of its files."""

    instance: Instance
    folder: Path
    process: subprocess.Popen[bytes]


class PlannerProcess:
    """Plans one instance after another like :class:`.work.Work`, in a child process.

    A process that ends by itself is said in one sentence, and the next order starts another.

    Parameters
    ----------
    done : callable
        As of :class:`.work.Work`; called in a thread of this process.
    place : path
        Folder for files on their way to the process.
    found : callable, optional
        As of :class:`.work.Work`; called in the same thread as ``done``.
    """

    def __init__(self, done: Done, place: Path, found: Found = ignored) -> None:
        self._done, self._found, self._place = done, found, place
        self._changed = threading.Condition(threading.RLock())
        self._process: subprocess.Popen[bytes] | None = None
        self._listener: threading.Thread | None = None
        self._orders: dict[int, _Order] = {}
        self._look = PlanningProgress()
        self._count = 0
        self._closing = False

    def progress(self) -> PlanningProgress:
        """Progress of the last run."""
        return self._look

    def prepare(self, *, drifts: bool) -> None:
        """Start the process, and let it load what the default method needs."""
        with self._changed:
            self._start()
            self._tell("prepare", method=DEFAULT_METHOD, drifts=drifts)

    def begin(self, instance: Instance, order: PlanningOrder, known: Plan | None) -> int:
        """Plan, stopping any run in progress; returns the number of the run.

        Parameters
        ----------
        instance, order, known
            As of :meth:`.work.Work.begin`.

        Raises
        ------
        InputError
            The order is not valid, or the process cannot be started; what runs goes on.
        """
        check_order(order)
        with self._changed:
            folder = private_folder(passing(self._place))
            instance.save(folder / "instance.json")
            if known is not None:
                known.save(folder / "known.json")
            process = self._start()
            self._count += 1
            self._orders[self._count] = _Order(instance, folder, process)
            self._look = PlanningProgress(self._count, "waiting", limit_s=order.time_limit_s)
            self._tell(
                "begin",
                instance=str(folder / "instance.json"),
                order=order.model_dump(),
                known=None if known is None else str(folder / "known.json"),
            )
            return self._count

    def stop(self) -> None:
        """Ask the run for its best plan."""
        with self._changed:
            if self._process is not None and self._look.runs:
                self._tell("stop")

    def wait(self, seconds: float) -> bool:
        """Wait until nothing runs; returns whether that is the case."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._look.runs, seconds)

    def close(self) -> None:
        """End the process, finished or not."""
        with self._changed:
            self._closing = True
            process = self._process
        if process is not None:
            end(process)
            with suppress(subprocess.TimeoutExpired):
                process.wait(LAST_WORDS_S)
        for order in self._orders.values():
            shutil.rmtree(order.folder, ignore_errors=True)

    def _start(self) -> subprocess.Popen[bytes]:
        """The process, which is started unless it runs."""
        if self._process is not None and self._process.poll() is None:
            return self._process
        try:
            self._process = started(WORKER, (), stdout=subprocess.PIPE)
        except OSError as error:
            raise InputError(f"no planning process can be started ({error.strerror})") from None
        self._listener = threading.Thread(
            target=self._listen,
            args=(self._process, self._count, self._listener),
            name="planner",
            daemon=True,
        )
        self._listener.start()
        return self._process

    def _tell(self, kind: str, **content: Any) -> None:
        """Send a message to the started process."""
        assert self._process is not None
        assert self._process.stdin is not None
        with suppress(OSError):  # it has ended, as its listener will say
            self._process.stdin.write(json.dumps({"kind": kind, **content}).encode() + b"\n")
            self._process.stdin.flush()

    def _listen(
        self, process: subprocess.Popen[bytes], before: int, previous: threading.Thread | None
    ) -> None:
        """Receive messages of a process until it ends, and end the orders that it leaves.

        Parameters
        ----------
        process : Popen
        before : int
            Number of orders before its first one.
        previous : Thread, optional
            Listens to the process before this one, whose orders end first.
        """
        if previous is not None:
            previous.join(LAST_WORDS_S)
        assert process.stdout is not None
        for line in process.stdout:
            if not line.endswith(b"\n"):  # it has ended within a word
                break
            told = loaded(line)
            if told["kind"] == "progress":
                self._heard(process, before, told["progress"])
            elif told["kind"] == "found":
                plan = None if told["plan"] is None else Plan.from_json(told["plan"])
                self._pass_on(before + told["number"], plan)
            else:
                self._adopt(process, before, told)
        status = process.wait()
        with self._changed:
            if self._closing:
                return
            current = self._process is process  # unless another one was started meanwhile
            if current:
                self._process = None
            number = self._count
            left = [each for each, order in self._orders.items() if order.process is process]
        for each in left:
            self._pass_on(each, None)
        with self._changed:
            if current and self._look.runs and self._count == number:
                self._look = replace(self._look, phase="failed", said=_ended(status))
            self._forget(process, number)
            self._changed.notify_all()

    def _pass_on(self, number: int, plan: Plan | None) -> None:
        """Hand over the best plan so far; one that cannot be stored is lost only to a kill."""
        with self._changed:
            instance = self._orders[number].instance
        with suppress(InputError, OSError):
            self._found(instance, plan)

    def _heard(self, process: subprocess.Popen[bytes], before: int, told: dict[str, Any]) -> None:
        """Adopt a state of progress, unless it belongs to an earlier run."""
        points = tuple((at, incumbent, bound) for at, incumbent, bound in told.pop("points"))
        with self._changed:
            number = int(told.pop("number")) + before
            current = self._process is process and number == self._count
            if current and told["phase"] != "idle":
                self._look = PlanningProgress(number=number, points=points, **told)
                self._changed.notify_all()
            if told["phase"] in ("done", "failed"):  # and so are those before it
                self._forget(process, number)

    def _adopt(self, process: subprocess.Popen[bytes], before: int, told: dict[str, Any]) -> None:
        """Store a result, and confirm that to the waiting process."""
        plan = None if told["plan"] is None else Plan.from_json(told["plan"])
        result = PlannedRun(plan, told["status"], tuple(told["notes"]))
        with self._changed:
            instance = self._orders[before + told["number"]].instance
        try:
            said, stored = self._done(instance, result), True
        except InputError as error:
            said, stored = str(error), False
        except Exception as error:  # to be reported on the page
            said, stored = f"{type(error).__name__}: {error}", False
        with self._changed:
            if self._process is process:
                self._tell("stored", said=said, stored=stored)

    def _forget(self, process: subprocess.Popen[bytes], last: int) -> None:
        """Remove the files of the runs of a process up to one."""
        ended = [
            number
            for number, order in self._orders.items()
            if order.process is process and number <= last
        ]
        for number in ended:
            shutil.rmtree(self._orders.pop(number).folder, ignore_errors=True)


def _ended(status: int) -> str:
    how = f"by signal {-status}" if status < 0 else f"with status {status}"
    return (
        f"the planning process has died {how}, most likely for lack of memory; press Plan to start "
        "another"
    )
