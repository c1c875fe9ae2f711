"""The planning process: it reads orders and writes progress as lines of JSON."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from dataclasses import asdict
from typing import Any, BinaryIO

from ...common.errors import InputError
from ...common.json_text import loaded
from ...plan.plan import Plan, load_plan
from ...problem.instance import Instance, load
from ...run import front
from ...run.methods import PLANNERS
from ...run.warm_up import PracticeKind
from .children import leave, settle_in
from .planning import PlannedRun, PlanningOrder
from .work import Work

PRACTICE_S = 1.0
"""Time limit of the practice run, without compiling [s]."""

PAUSE_S = 0.1
"""Interval between reports of progress [s]."""


class PlannerWorker:
    """Carries out orders until their pipe ends, as it does when the server is killed.

    Parameters
    ----------
    orders, answers : binary files
    """

    def __init__(self, orders: BinaryIO, answers: BinaryIO) -> None:
        self._orders, self._answers = orders, answers
        self._prepared = threading.Event()
        self._prepared.set()
        self._work = Work(self._done, self._found, self._prepared)
        self._writing = threading.Lock()
        self._stored = threading.Event()
        self._verdict: dict[str, Any] = {}
        self._runs: list[tuple[int, Instance]] = []
        self._count = 0

    def run(self) -> None:
        """Carry out orders, and exit at the end of the pipe even during a run."""
        threading.Thread(target=self._look, name="looks", daemon=True).start()
        for line in self._orders:
            order = loaded(line)
            kind = order.pop("kind")
            if kind == "begin":
                self._begin(**order)
            elif kind == "stop":
                self._work.stop()
            elif kind == "stored":
                self._verdict = order
                self._stored.set()
            elif kind == "prepare":
                self._prepared.clear()
                threading.Thread(target=self._prepare, kwargs=order, daemon=True).start()
        leave()

    def _begin(self, instance: str, known: str | None, order: dict[str, Any]) -> None:
        plan = None if known is None else load_plan(known)
        wanted = load(instance)
        self._count += 1
        self._runs.append((self._count, wanted))
        self._work.begin(wanted, PlanningOrder(**order), plan)

    def _prepare(self, method: str, drifts: bool) -> None:
        """Load or compile what a method needs before the first order comes."""
        try:
            practice = PracticeKind(drifts=drifts).problem()
            front.run(PLANNERS, practice, method, front.RunOptions(PRACTICE_S, 0))
        finally:
            self._prepared.set()

    def _done(self, instance: Instance, result: PlannedRun) -> str:
        """Hand a result over and wait until it is stored; returns the message about it."""
        plan = None if result.plan is None else result.plan.to_json()
        number = self._number(instance)
        self._runs = [each for each in self._runs if each[0] > number]
        self._stored.clear()
        self._tell("done", number=number, plan=plan, status=result.status, notes=list(result.notes))
        self._stored.wait()
        if not self._verdict["stored"]:
            raise InputError(self._verdict["said"])
        return str(self._verdict["said"])

    def _found(self, instance: Instance, plan: Plan | None) -> None:
        """Hand over the best plan so far."""
        content = None if plan is None else plan.to_json()
        self._tell("found", number=self._number(instance), plan=content)

    def _number(self, instance: Instance) -> int:
        """Number of the run of an instance: runs end in the order in which they began."""
        return next(number for number, each in self._runs if each is instance)

    def _look(self) -> None:
        last = None
        while True:
            progress = self._work.progress()
            if progress != last:
                last = progress
                # Infinities are no JSON, but Python reads what it writes.
                self._tell("progress", progress=asdict(progress))
            time.sleep(PAUSE_S)

    def _tell(self, kind: str, **content: Any) -> None:
        line = json.dumps({"kind": kind, **content}).encode() + b"\n"
        with self._writing:
            try:
                self._answers.write(line)
                self._answers.flush()
            except OSError:  # nobody listens
                leave()


def main() -> None:
    """Run the worker on standard input and output; prints of other code go to standard error."""
    settle_in()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    PlannerWorker(sys.stdin.buffer, answers).run()


if __name__ == "__main__":
    main()
