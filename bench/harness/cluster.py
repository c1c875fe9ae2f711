"""Workers anywhere: a Dask scheduler.

Workers need adr-opt; the modules of this folder are sent to them. Dask runs the task of a worker
that died elsewhere, and gives it up (``KilledWorker``) after several deaths.
"""

from __future__ import annotations

import contextlib
import queue
import secrets
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

from adr_opt.common.cluster import client_of, count_of

from .backend import Broken, Collected, Died, Done, Event, Messages, Told
from .methods import Method
from .trials import BoundCall, Task
from .work import preflight, work

HERE = Path(__file__).parent


class Cluster:
    """The workers of a Dask scheduler.

    Parameters
    ----------
    address : str
        As :func:`adr_opt.common.cluster.client_of` takes it, and refuses it.
    """

    def __init__(self, address: str) -> None:
        self._client = client_of(address)
        import distributed

        self._killed = distributed.KilledWorker
        self.inbox: queue.Queue[Event] = queue.Queue()
        self._topic = f"adr-opt-{secrets.token_hex(8)}"
        self._futures: set[Any] = set()
        self._closing = False

    @property
    def workers(self) -> int:
        """Number of tasks that the cluster runs at once, now."""
        return count_of(self._client)

    def preflight(self, methods: tuple[Method | BoundCall, ...]) -> str | None:
        """Send the modules, and load the methods on every worker; what input is wrong, if any."""

        def forget() -> None:
            """Drop the modules of an earlier run."""
            for name in list(sys.modules):
                if name.split(".")[0] in ("harness", "machine"):
                    del sys.modules[name]

        self._client.run(forget)
        with tempfile.TemporaryDirectory() as folder:
            archive = Path(folder) / f"harness-{self._topic}.zip"
            with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
                file.write(HERE.parent / "machine.py", "machine.py")
                for path in sorted(HERE.glob("*.py")):
                    file.write(path, f"harness/{path.name}")
            self._client.upload_file(str(archive))
        self._client.subscribe_topic(self._topic, lambda event: self.inbox.put(Told(event[1])))
        try:
            said = self._client.run(preflight, methods)
        except ImportError as error:
            return f"--cluster: a worker lacks a module ({error}); install adr-opt there"
        except OSError:
            return None  # a method killed a worker; its rows will say so
        return next((wrong for wrong in said.values() if wrong is not None), None)

    def submit(self, task: Task) -> None:
        """Hand out a task."""
        future = self._client.submit(_work, task, self._topic, pure=False)
        self._futures.add(future)
        future.add_done_callback(lambda future: self._ended(task, future))

    def _ended(self, task: Task, future: Any) -> None:
        self._futures.discard(future)
        if self._closing:
            return
        if future.status == "finished":
            self.inbox.put(Done(task, future.result()))
            return
        if future.status == "error":
            error = future.exception()
            if isinstance(error, self._killed):
                self.inbox.put(Died(task))
            else:
                self.inbox.put(
                    Broken(f"a worker of the cluster cannot work: {type(error).__name__}: {error}")
                )
            return
        self.inbox.put(Broken("the scheduler of the cluster is gone; what is finished is kept"))

    def close(self) -> None:
        """Take back what was handed out, and leave the cluster as it was."""
        self._closing = True
        with contextlib.suppress(Exception):
            self._client.cancel(list(self._futures), force=True)
            self._client.unsubscribe_topic(self._topic)
        with contextlib.suppress(Exception):
            self._client.close(timeout=5)


def _work(task: Task, topic: str) -> Messages:
    from distributed import get_worker

    worker = get_worker()
    collected = Collected(lambda message: worker.log_event(topic, message))
    work(task, collected)
    return collected.messages
