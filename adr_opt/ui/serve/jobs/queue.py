"""The queue of jobs: a few at a time, whose results are kept in the project."""

from __future__ import annotations

import math
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ....common.errors import InputError
from ....common.files import write_bytes
from ....common.json_text import loaded
from ....common.wording import counted
from ..forms.refusals import in_labels
from ..objects.dropped import DroppedObjects
from ..project.plan_files import INSTANCE, PLAN, load_kept, of_plan
from ..project.record import ResultRecord
from ..project.results import now
from ..requests import JobRequest
from ..session import EditingSession
from .commands import JobCommand, JobInputs
from .job import Job
from .verbs import VERBS


def figures_of(place: Path, answer: dict[str, Any]) -> dict[str, Any]:
    """Figures of a result, from its plan or else from the answer of the verb.

    Parameters
    ----------
    place : path
        The folder of the result.
    answer : dict
        What the verb has printed.
    """
    if (place / PLAN).is_file() and (place / INSTANCE).is_file():
        return of_plan(load_kept(place))
    found = {
        "objective": answer.get("objective"),
        "bound": answer.get("upper_bound"),
        "gap": answer.get("gap"),
        "delta_v_m_s": answer.get("flown_delta_v_m_s"),
    }
    figures: dict[str, Any] = {
        name: float(value)
        for name, value in found.items()
        if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    }
    status = answer.get("status")
    return figures | ({"status": status} if isinstance(status, str) else {})


def said_of(verb: str, answer: dict[str, Any], status: int) -> str:
    """An answer in a few words.

    Parameters
    ----------
    verb : str
    answer : dict
        What the verb has printed.
    status : int
        Its exit status, 1 where the answer is no.
    """
    if verb == "check":
        count = len(answer.get("violations") or ())
        return counted(count, "violation") if count else "no violations"
    if verb == "verify":
        reasons = answer.get("reasons") or ("refused",)
        return "verified" if answer.get("verified") else f"refused: {reasons[0]}"
    bound = answer.get("upper_bound")
    if verb == "bound" and isinstance(bound, (int, float)):
        return f"no plan collects more than {bound:.6g}"
    if verb == "screen":
        others = [each for each in answer["approaches"] if not each["own"]]
        nearest = min((each["miss_m"] for each in others), default=None)
        found = counted(len(others), "approach", "approaches")
        return found if nearest is None else f"{found}, the nearest by {nearest:,.0f} m"
    if verb == "windows":
        shares = [row["share"] for row in answer["targets"].values()]
        return f"open {100.0 * min(shares):.3g} to {100.0 * max(shares):.3g} % of the time"
    return NO.get(verb, "done, but the answer is no") if status else "done"


NO = {
    "bound": "infeasible",
    "compare": "a plan has violations",
    "dispose": "a rule is not met",
    "fly": "a leg misses, or a tank does not suffice",
    "refine": "a leg is missing",
    "rehearse": "no rehearsal services all required targets",
    "replan": "the rest has no plan",
    "report": "a tank does not suffice, or a leg misses",
    "solve": "the plan does not hold",
    "tradeoff": "a point has no plan",
}
"""Meaning of exit status 1, by verb."""


MOST_AT_ONCE = 2
"""Number of jobs that run side by side."""

MOST_WAITING = 50
"""Maximum number of jobs that run or wait."""

MOST_LISTED = 100
"""Number of jobs that are listed: those that run or wait, and the latest others."""

ANSWER = "answer.json"
"""File of a result with the answer of the verb."""


class JobQueue:
    """Runs verbs on the files of a project.

    Parameters
    ----------
    session : EditingSession
    dropped : DroppedObjects

    Attributes
    ----------
    revision : int
        Counts changes.
    """

    def __init__(self, session: EditingSession, dropped: DroppedObjects) -> None:
        self._session, self._inputs = session, JobInputs(session, dropped)
        self._lock = threading.Lock()
        self._jobs: list[Job] = []
        self._pool = ThreadPoolExecutor(MOST_AT_ONCE, "job")
        self._count = 0
        self.revision = 0

    def begin(self, request: JobRequest) -> int:
        """Put a job into the queue; returns its number.

        Raises
        ------
        InputError
            The request is not valid, or too many jobs wait.
        """
        self._inputs.check(request)
        with self._lock:
            if sum(job.runs for job in self._jobs) >= MOST_WAITING:
                raise InputError(f"{MOST_WAITING} jobs are running or waiting; stop some first")
            self._count += 1
            limit_s = request.options.get("time_limit_s")
            job = Job(
                self._count,
                request.verb,
                VERBS[request.verb].label,
                limit_s
                if isinstance(limit_s, (int, float)) and request.verb != "tradeoff"
                else None,
                self._changed,
            )
            self._jobs = _listed([*self._jobs, job])
        place: Path | None = None
        try:
            number, place = self._session.results.begin(request.verb)
            # The files are those of now, however long it waits.
            command = self._inputs.command(request, place)
        except BaseException as error:
            if place is not None:
                self._session.results.drop(place)
            job.settle("failed", str(error))
            raise
        self._changed()
        self._pool.submit(self._run, job, number, place, command)
        return job.number

    def stop(self, number: int) -> None:
        """Stop a job.

        Raises
        ------
        InputError
            There is no such job.
        """
        for job in self._jobs:
            if job.number == number:
                job.stop()
                return
        raise InputError("there is no such job")

    def rows(self) -> list[dict[str, Any]]:
        """All jobs as JSON data, the latest last."""
        return [job.row() for job in self._jobs]

    def close(self) -> None:
        """End all jobs at once."""
        for job in self._jobs:
            if job.runs:
                job.kill()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _changed(self) -> None:
        self.revision += 1

    def _run(self, job: Job, number: int, place: Path, command: JobCommand) -> None:
        results = self._session.results
        try:
            if not job.start():
                results.drop(place)
                return
            status, printed = job.run(command.words, self._session.folder.path)
            lines = job.messages.strip().splitlines()
            answer = _answer(printed) if status in (0, 1) else None
            if answer is None:
                results.drop(place)
                said = lines[-1].removeprefix("adr-opt: ") if lines else ""
                if job.stopping:
                    job.settle("stopped")
                else:
                    refused = in_labels(said, VERBS[job.verb].options)
                    job.settle("failed", refused or f"it ended with status {status}")
                return
            write_bytes(place / ANSWER, printed)
            page = VERBS[job.verb].page
            fields = {"instance_sha256": command.instance_sha256, **figures_of(place, answer)}
            record = results.done(
                ResultRecord(
                    number=number,
                    verb=job.verb,
                    label=job.label,
                    made_at=now(),
                    inputs=command.inputs,
                    command=tuple(command.words),
                    exit_status=status,
                    said="\n".join(lines),
                    page=page if page is not None and (place / page).is_file() else None,
                    **fields,
                )
            )
            job.result = record.number
            if job.verb == "worth":
                self._session.note(worth=record.number)
            said = said_of(job.verb, answer, status)
            if job.verb == "windows" and not self._session.take_windows(record.number):
                said = "the mission was edited meanwhile, and does not use them; find them again"
            job.settle("done", said)
        except Exception as error:  # to be reported on the page
            if job.result is None:
                results.drop(place)
            known = isinstance(error, (InputError, OSError))
            job.settle("failed", str(error) if known else f"{type(error).__name__}: {error}")


def _listed(jobs: list[Job]) -> list[Job]:
    """The jobs to list: without the earliest finished ones if there are too many."""
    over = [job for job in jobs if not job.runs]
    dropped = set(over[: max(len(jobs) - MOST_LISTED, 0)])
    return [job for job in jobs if job not in dropped]


def _answer(printed: bytes) -> dict[str, Any] | None:
    """The JSON object that a verb has printed; None if it has printed anything else."""
    try:
        content = loaded(printed)
    except ValueError:
        return None
    return content if isinstance(content, dict) else None
