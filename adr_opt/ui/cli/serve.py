"""``serve``: the report page, live, for interactive planning."""

from __future__ import annotations

import signal
import sys
import threading
from contextlib import closing
from pathlib import Path

import click

from ...common.errors import MissingExtra
from . import complete, param
from .output import emit, emit_json, say
from .signals import Aborted, signals_to

PATIENCE_S = 60.0
"""Longest wait for a stopped planner [s]."""


PROJECT = "adr-opt-project"
"""Default project folder without INSTANCE and --folder."""


@click.command("serve", short_help="Plan interactively on a local web page.")
@click.argument(
    "instance_path", metavar="[INSTANCE]", required=False, shell_complete=complete.files
)
@click.argument("plan_path", metavar="[PLAN]", required=False, shell_complete=complete.files)
@param.count("--port", "N", "Port of 127.0.0.1; by default any free one.", default=0)
@param.word(
    "--folder",
    "DIR",
    f"Project folder; default INSTANCE-served, or {PROJECT} without INSTANCE, in this folder.",
)
@param.flag("--no-open", "Do not open a browser.")
@param.spoken
def command(
    instance_path: str | None,
    plan_path: str | None,
    port: int,
    folder: str | None,
    no_open: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Serve a page to edit and plan INSTANCE, beside the report of its plan.

    Without INSTANCE, it begins with a catalogue of objects, or resumes the project in the folder.
    The page is served to this machine only, and only at the printed address. Files are written
    only in the project folder, which is reopened as it was left. Ctrl-C ends it.
    """
    try:
        from ..serve.server import Server, listening
    except ImportError as error:
        package = (error.name or "").partition(".")[0]
        if package not in ("starlette", "uvicorn"):
            raise
        raise MissingExtra("serving a page", package, "serve") from None
    from ...problem.instance import load
    from ...problem.support import refuse
    from ..report.page import FOLLOWS
    from ..serve.backend import Backend
    from ..serve.children import private_files
    from ..serve.folder import Folder
    from ..serve.planner_process import PlannerProcess
    from ..serve.session import EditingSession
    from .parameters import admitted_plan

    instance = None if instance_path is None else load(instance_path)
    if instance is not None:
        refuse(instance, FOLLOWS)
    plan = None
    if instance_path is not None and plan_path is not None:
        plan = admitted_plan(instance_path, plan_path).plan
    usual = PROJECT if instance_path is None else f"{Path(instance_path).stem}-served"
    place = Folder(folder or usual, instance_path)
    with closing(listening(port)) as listener, private_files():
        place.make()
        with place.locked():
            session = EditingSession(
                instance, plan, place, lambda done, found: PlannerProcess(done, place.path, found)
            )
            backend = Backend(session)
            server, ended = Server(backend, listener), threading.Event()
            with signals_to(ended.set):
                server.start()
                if as_json:
                    emit_json({"url": server.url, "port": server.port, "folder": str(place.path)})
                else:
                    emit(server.url)
                sys.stdout.flush()
                said = "" if instance is None else f"{instance.name!r}, "
                say(f"serving {said}kept in {place.path}; Ctrl-C ends it", unless=quiet)
                session.prepare()
                if not no_open:
                    _open(server.launch(place.path))
                server.wait(ended)
                server.close()
                if not backend.close(PATIENCE_S):
                    raise Aborted(signal.SIGINT)
    return 0


def _open(address: str) -> None:
    """Open a file in the browser."""
    if click.launch(address) != 0:
        import webbrowser

        webbrowser.open(address)
