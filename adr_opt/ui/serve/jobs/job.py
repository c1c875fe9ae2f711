"""A job: a command line in a process of its own, watched and stopped."""

from __future__ import annotations

import signal
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from ....common.json_text import loaded
from ...watched import SIGN, VARIABLE
from ..children import end, started

CHILD = "adr_opt.ui.cli.attended"

PATIENCE_S = 10.0
"""Longest wait for a stopped verb to write its results; then it is killed [s]."""

MOST_SAID = 20_000
"""Maximum length of a verb's messages that is kept [characters]."""

State = Literal["waiting", "running", "done", "failed", "stopped"]


class Job:
    """A verb at work.

    Parameters
    ----------
    number : int
    verb, label : str
    limit_s : float or None
        Its time limit, from which its progress is estimated where it does not tell any [s].
    changed : callable
        Called when something has changed.
    """

    def __init__(
        self, number: int, verb: str, label: str, limit_s: float | None, changed: Callable[[], None]
    ) -> None:
        self.number, self.verb, self.label = number, verb, label
        self.state: State = "waiting"
        self.said = ""
        self.messages = ""
        self.result: int | None = None
        self.stopping = False
        self._limit_s, self._changed = limit_s, changed
        self._share: float | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._began: float | None = None
        self._ended: float | None = None

    @property
    def runs(self) -> bool:
        """Whether the job has not ended."""
        return self.state in ("waiting", "running")

    def start(self) -> bool:
        """Begin to run; returns False if the job was stopped while it waited."""
        with self._lock:
            self.state = "stopped" if self.stopping else "running"
            self._began = time.monotonic()
        self._changed()
        return self.state == "running"

    def settle(self, state: State, said: str = "") -> None:
        """Set the final state of a job."""
        self._ended = time.monotonic()
        self.state, self.said = state, said
        self._changed()

    def run(self, words: list[str], folder: Path) -> tuple[int, bytes]:
        """Run a command line in a folder; returns its exit status and what it printed.

        Parameters
        ----------
        words : list of str
            Verb, files and options.
        folder : path
        """
        with self._lock:
            if self.stopping:
                return -signal.SIGTERM, b""
            self._process = process = started(
                CHILD,
                words,
                {VARIABLE: "1"},
                cwd=folder,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
        hearing = threading.Thread(target=self._hear, args=(process,), daemon=True)
        hearing.start()
        assert process.stdout is not None
        printed = process.stdout.read()
        status = process.wait()
        hearing.join(PATIENCE_S)
        end(process)  # whatever it has left behind
        assert process.stdin is not None
        with suppress(OSError):
            process.stdin.close()
        return status, printed

    def stop(self) -> None:
        """Ask for the results so far, and end the process if that takes long."""
        with self._lock:
            if self.stopping or not self.runs:
                return
            self.stopping = True
            process = self._process
        self._changed()
        if process is not None:
            with suppress(OSError):
                process.terminate()
            late = threading.Timer(PATIENCE_S, end, (process,))
            late.daemon = True
            late.start()

    def kill(self) -> None:
        """End the process at once."""
        with self._lock:
            self.stopping = True
            process = self._process
        if process is not None:
            end(process)

    def row(self) -> dict[str, Any]:
        """The job as JSON data."""
        elapsed_s = 0.0
        if self._began is not None:
            elapsed_s = (self._ended or time.monotonic()) - self._began
        share = self._share
        if share is None and self._limit_s and self.state == "running":
            share = min(elapsed_s / self._limit_s, 1.0)
        return {
            "id": self.number,
            "verb": self.verb,
            "label": self.label,
            "state": self.state,
            "share": 1.0 if self.state == "done" else share,
            "said": self.said,
            "elapsed_s": round(elapsed_s, 1),
            "result": self.result,
            "stopping": self.stopping,
        }

    def _hear(self, process: subprocess.Popen[bytes]) -> None:
        """Hear progress and messages until the process ends."""
        assert process.stderr is not None
        for line in process.stderr:
            text = line.decode("utf-8", "replace").strip()
            if text.startswith(SIGN):
                with suppress(ValueError, KeyError, TypeError):
                    told = loaded(text.removeprefix(SIGN))
                    self.said = str(told["said"])
                    if told["share"] is not None:
                        self._share = float(told["share"])
                    self._changed()
            elif text:
                self.messages = (self.messages + text + "\n")[-MOST_SAID:]
