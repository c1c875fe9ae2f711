"""The coordinator: hands out what is missing, keeps what comes back, and survives dead workers."""

from __future__ import annotations

import queue
import time
from collections import Counter, deque
from dataclasses import dataclass, field

from .backend import Backend, Broken, Died, Done, Event, Messages, Told
from .display import Display
from .environment import environment
from .store import Store
from .trials import Protocol, Task, Trial
from .work import PARTS

LIFE_S = 5.0
"""Interval between a run's signs of life."""

AHEAD = 2
"""Tasks handed out per worker: one to do, one to go on with."""

DEATHS = 2
"""Number of worker deaths in a task that runs alone before the method at fault is given up."""


@dataclass
class Summary:
    """Summary of a run.

    Attributes
    ----------
    rows : int
        Kept by this run.
    wall_s : float
        From the first task handed out to the last one back.
    workers : int
    deaths : int
        Tasks whose worker died.
    spent : dict
        Seconds of all workers together, by what they did.
    broken : str or None
        Why the run had to end before its time.
    """

    rows: int = 0
    wall_s: float = 0.0
    workers: int = 1
    deaths: int = 0
    spent: dict[str, float] = field(default_factory=lambda: dict.fromkeys((*PARTS, "task"), 0.0))
    broken: str | None = None

    @property
    def overhead_s(self) -> float:
        """Seconds of workers that went into none of the parts of a task: the harness itself."""
        return max(0.0, self.workers * self.wall_s - sum(self.spent[part] for part in PARTS))


class Runner:
    """A run of a protocol.

    Parameters
    ----------
    protocol : Protocol
    store : Store
    backend : Backend
    display : Display
    run : int
        Number of the run in the store.
    """

    def __init__(
        self, protocol: Protocol, store: Store, backend: Backend, display: Display, run: int
    ) -> None:
        self._protocol = protocol
        self._store = store
        self._backend = backend
        self._display = display
        self._run = run
        self._waiting: deque[Trial] = deque()
        self._elsewhere: deque[Trial] = deque()
        self._suspects: deque[Trial] = deque()
        self._alone: Trial | None = None
        self._deaths: Counter[Trial] = Counter()
        self._out: dict[Trial, Task] = {}
        self.summary = Summary(workers=backend.workers)

    def run(self) -> Summary:
        """Bring about everything that is missing.

        KeyboardInterrupt goes through; what has arrived by then is kept.
        """
        self._waiting.extend(self._store.missing(self._protocol))
        begun = lived = time.monotonic()
        try:
            while self.summary.broken is None:
                self._hand_out()
                if not self._out and not self._elsewhere:
                    break
                self._hear(self._events())
                if time.monotonic() - lived > LIFE_S:
                    lived = time.monotonic()
                    self._store.sign_of_life(self._run)
                    if not self._out:
                        self._look_again()
                self._display.update(self._backend.workers)
        finally:
            self.summary.wall_s = time.monotonic() - begun
            self._backend.close()
            self._hear(self._left_over())
            self._store.end_run(self._run, self.summary.wall_s, self.summary.spent)
        return self.summary

    def _hand_out(self) -> None:
        """Keep the workers busy; a task that may have killed one runs alone."""
        while self._suspects:
            if self._out:
                return
            self._alone = self._suspects.popleft()
            self._submit(self._alone)
        if self._alone is not None:
            if self._alone in self._out:
                return
            self._alone = None
        most = AHEAD * self._backend.workers
        while self._waiting and len(self._out) < most:
            self._submit(self._waiting.popleft())

    def _submit(self, trial: Trial) -> None:
        task = self._store.claim(trial, self._protocol, self._run)
        if task is None:
            self._elsewhere.append(trial)
        elif task.methods or task.bound is not None:
            self._out[trial] = task
            self._backend.submit(task)

    def _look_again(self) -> None:
        """Trials claimed by another run may be finished by now, or that run dead."""
        missing = self._store.missing(self._protocol)
        self._waiting.extend(trial for trial in self._elsewhere if trial in missing)
        self._elsewhere.clear()

    def _events(self) -> list[Event]:
        """Messages that have arrived, after a short wait."""
        try:
            first = self._backend.inbox.get(timeout=0.25)
        except queue.Empty:
            return []
        return [first, *self._left_over()]

    def _left_over(self) -> list[Event]:
        events = []
        while True:
            try:
                events.append(self._backend.inbox.get_nowait())
            except queue.Empty:
                return events

    def _hear(self, events: list[Event]) -> None:
        messages: Messages = []
        died = []
        for event in events:
            if isinstance(event, Told):
                messages.append(event.message)
            elif isinstance(event, Done):
                messages.extend(event.messages)
                self._out.pop(event.task.trial, None)
            elif isinstance(event, Died):
                died.append(event.task)
            elif isinstance(event, Broken):
                self.summary.broken = event.why
        for kind, facts in messages:
            if kind == "spent":
                for part, seconds in facts.items():
                    self.summary.spent[part] += seconds
        rows = [message for message in messages if message[0] != "spent"]
        if rows:
            self._keep(rows)
        for event in events:
            if isinstance(event, Done):
                self._store.release(event.task.trial, self._run)
        for task in died:
            self._mourn(task)

    def _keep(self, messages: Messages) -> None:
        new = self._store.keep(messages, self._run)
        self.summary.rows += len(new)
        for facts in new:
            self._display.kept(facts)

    def _mourn(self, task: Task) -> None:
        """A worker died: of this task if it ran alone, else of one of several."""
        trial = task.trial
        self.summary.deaths += 1
        self._out.pop(trial, None)
        if trial == self._alone:
            self._deaths[trial] += 1
            if self._deaths[trial] >= DEATHS:
                self._deaths[trial] = 0
                self._give_up(trial)
        self._suspects.append(trial)

    def _give_up(self, trial: Trial) -> None:
        """Let a row say that the worker died: methods are done in order, so of the first missing.

        The others of the trial are tried again.
        """
        task = self._store.claim(trial, self._protocol, self._run)
        if task is None:
            return
        key = {
            "suite": trial.suite,
            "field": trial.field,
            "iteration": trial.iteration,
            "zones": trial.zones,
            "message": f"its worker process died, {DEATHS} times",
            "environment": environment(),
        }
        if task.methods:
            row = {**key, "method": task.methods[0].key, "seed": task.seed, "outcome": "died"}
            self._keep([("row", row)])
        elif task.bound is not None:
            bound = {**key, "method": task.bound.name, "limit_s": task.bound.limit_s}
            self._keep([("bound", bound)])
