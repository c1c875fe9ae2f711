"""Interface between the coordinator and workers: tasks and messages."""

from __future__ import annotations

import queue
from dataclasses import dataclass, field
from typing import Any, Protocol

from .methods import Method
from .trials import BoundCall, Task

Messages = list[tuple[str, dict[str, Any]]]


@dataclass(frozen=True)
class Told:
    """Something was finished within a task; it will be in the task's :class:`Done` again."""

    message: tuple[str, dict[str, Any]]


@dataclass(frozen=True)
class Done:
    """A task came to its end, with all that it told."""

    task: Task
    messages: Messages


@dataclass(frozen=True)
class Died:
    """The worker of a task died, and the backend will not try the task again by itself."""

    task: Task


@dataclass(frozen=True)
class Broken:
    """The backend cannot go on; why, in one sentence."""

    why: str


Event = Told | Done | Died | Broken


class Backend(Protocol):
    """Workers. All that happens to them arrives in ``inbox``, from whatever thread."""

    inbox: queue.Queue[Event]
    workers: int

    def preflight(self, methods: tuple[Method | BoundCall, ...]) -> str | None:
        """Start the workers and load the methods; what input is wrong, if any."""
        ...

    def submit(self, task: Task) -> None:
        """Hand out a task."""
        ...

    def close(self) -> None:
        """End the workers, whatever they do."""
        ...


@dataclass
class Collected:
    """A ``tell`` that keeps all messages of a task, and passes them on at once."""

    pass_on: Any
    messages: Messages = field(default_factory=list)

    def __call__(self, kind: str, facts: dict[str, Any]) -> None:
        """Receive a finished item."""
        self.messages.append((kind, facts))
        if kind != "spent":
            self.pass_on((kind, facts))
