"""The backend: editing session, dropped objects, jobs and results, as the page sees them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.files import read_text
from ...common.json_text import parse_json
from ...common.wording import counted
from ...run.methods import BOUNDS, PLANNERS, names
from ...run.run_options import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...sources.generator import generate
from .folder import archived
from .jobs.queue import ANSWER, JobQueue
from .jobs.verbs import VERBS
from .objects.dropped import DroppedObjects
from .objects.import_options import OPTIONS
from .project.points import points_of
from .project.private import passing, refuse_link
from .project.record import ResultRecord
from .requests import ChooseRequest, JobRequest, ShowRequest
from .session import EditingSession


def choices() -> dict[str, Any]:
    """Methods, bounds, options of an import, and verbs with theirs, as JSON data."""
    return {
        "methods": list(names(PLANNERS)),
        "bounds": list(names(BOUNDS)),
        "method": DEFAULT_METHOD,
        "time_limit_s": DEFAULT_TIME_LIMIT_S,
        "import": [option.to_dict() for option in OPTIONS],
        "verbs": {name: verb.to_dict() for name, verb in VERBS.items()},
    }


class Backend:
    """State shown and changed by the page.

    Parameters
    ----------
    session : EditingSession

    Attributes
    ----------
    session : EditingSession
    dropped : DroppedObjects
    queue : JobQueue
    """

    def __init__(self, session: EditingSession) -> None:
        self.session = session
        self.dropped = DroppedObjects(session)
        self.queue = JobQueue(session, self.dropped)

    def state(self) -> dict[str, Any]:
        """The state, as JSON data."""
        state = self.session.state()
        plan = state["plan"]
        return {
            **state,
            "stage": self._stage(state),
            "project": {"name": self.name, "folder": state["folder"]},
            "files": [
                {
                    "id": each.number,
                    "name": each.name,
                    "what": each.what,
                    "count": each.count,
                    "skipped": each.skipped,
                    "bad": list(each.bad),
                }
                for each in self.session.files
            ],
            "notes": [] if plan is None else plan["notes"],
        }

    def _stage(self, state: dict[str, Any]) -> str:
        if state["instance"] is not None:
            return "mission"
        return (
            "objects" if any(each.what == "catalogue" for each in self.session.files) else "empty"
        )

    def results(self) -> list[dict[str, Any]]:
        """All results, newest last, as JSON data."""
        return [record.row() for record in self.session.results.all()]

    def close(self, seconds: float) -> bool:
        """Stop all work; returns whether all is finished."""
        self.queue.close()
        return self.session.close(seconds)

    @property
    def name(self) -> str:
        """Name of the project, as that of a file."""
        return self.session.folder.path.name

    def page(self, number: str) -> str:
        """Page of a result, exactly as the verb wrote it.

        Raises
        ------
        InputError
            There is no such result, or it has no page.
        """
        record = self._record(number)
        if record.page is None:
            raise InputError(f"result {record.number} ({record.verb}) has no page")
        place = self.session.results.place(record.number)
        return read_text(refuse_link(place / record.page))

    def file(self, number: str, name: str) -> Path:
        """A file that a verb has made, to be downloaded.

        Raises
        ------
        InputError
            There is no such result, or it has no such file.
        """
        record = self._record(number)
        if name not in record.files:
            raise InputError(f"result {record.number} ({record.verb}) has no file {name[:40]!r}")
        return refuse_link(self.session.results.place(record.number) / name)

    def _record(self, number: str) -> ResultRecord:
        digits = number.isascii() and number.isdigit() and len(number) <= 6
        return self.session.results.record(int(number) if digits else 0)

    def archive(self) -> Path:
        """A temporary file with the whole project, zipped; the caller removes it.

        Raises
        ------
        InputError
            A file of the project is spoilt.
        OSError
            The archive cannot be written.
        """
        folder = self.session.folder
        return archived(folder.path, folder.own(), passing(folder.path, ".zip"))

    def choose(self, request: ChooseRequest) -> dict[str, Any]:
        """Make a mission of dropped objects; returns a record of the import, as JSON data."""
        made = self.dropped.mission(request.names, request.prizes, request.options)
        words = f"{counted(len(made.instance.targets), 'target')} chosen"
        self.session.begin_anew(made.instance, words)
        return made.to_dict()

    def sample(self) -> None:
        """Begin with the sample mission, drawn with a fixed seed."""
        self.session.begin_anew(generate("nominal", 0), "sample mission opened")

    def begin(self, request: JobRequest) -> dict[str, Any]:
        """Begin a job; returns its number as JSON data."""
        return {"job": self.queue.begin(request)}

    def points(self, number: str) -> dict[str, Any]:
        """Points of a trade-off, as JSON data.

        Raises
        ------
        InputError
            There is no such result, or it is none, or spoilt.
        """
        record = self._record(number)
        if record.verb != "tradeoff":
            raise InputError(f"result {record.number} ({record.verb}) is not a trade-off")
        place = self.session.results.place(record.number)
        where = f"the answer of result {record.number}"
        answer = parse_json(read_text(refuse_link(place / ANSWER)), where)
        try:
            return points_of(place, answer)
        except (ValueError, LookupError, TypeError, ArithmeticError):
            raise InputError(f"{where} is spoilt") from None

    def show(self, request: ShowRequest) -> None:
        """Show the plan of a result, or of a point of it."""
        if request.point is None:
            self.session.show(request.result)
        else:
            self.session.show_point(request.result, request.point)
