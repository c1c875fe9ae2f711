"""``serve``: the report page, live, for interactive planning."""

from __future__ import annotations

import signal
import sys
import threading
from contextlib import closing
from pathlib import Path

import click

from ...common.errors import MissingExtra
from . import complete, take
from .output import emit, emit_json, say
from .signals import Aborted, signals_to

PATIENCE_S = 60.0
"""Longest wait for a stopped planner [s]."""


@click.command("serve", short_help="Plan interactively on a local web page.")
@take.instance
@click.argument("plan_path", metavar="[PLAN]", required=False, shell_complete=complete.files)
@take.count("--port", "N", "Port of 127.0.0.1; any free one.", default=0)
@take.word("--folder", "DIR", "Working folder; INSTANCE-served, beside this call.")
@take.flag("--no-open", "Open no browser.")
@take.as_json
@take.quiet
def command(
    instance_path: str,
    plan_path: str | None,
    port: int,
    folder: str | None,
    no_open: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Serve a page to edit and plan INSTANCE, beside the report of its plan.

    The page is served to this machine only, and only at the printed address. Files are written only
    in the working folder: the latest plan and its instance. Ctrl-C ends it.
    """
    try:
        from ..serve.server import Server, listening
    except ImportError as error:
        package = (error.name or "").partition(".")[0]
        if package not in ("starlette", "uvicorn"):
            raise
        raise MissingExtra("serving a page", package, "serve") from None
    from ...plan.plan import load_plan
    from ...problem.instance import load
    from ..serve.desk import Desk
    from ..serve.folder import Folder
    from ..serve.session import EditingSession

    instance = load(instance_path)
    plan = None if plan_path is None else load_plan(plan_path)
    place = Folder(folder or f"{Path(instance_path).stem}-served", instance_path)
    with closing(listening(port)) as listener:
        session = EditingSession(instance, plan, place)
        server, ended = Server(Desk(session), listener), threading.Event()
        with signals_to(ended.set):
            server.start()
            if as_json:
                emit_json({"url": server.url, "port": server.port, "folder": str(place.path)})
            else:
                emit(server.url)
            sys.stdout.flush()
            say(f"serving {instance.name!r}, kept in {place.path}; Ctrl-C ends it", unless=quiet)
            if not no_open:
                click.launch(server.url)
            server.wait(ended)
            server.close()
            if not session.close(PATIENCE_S):
                raise Aborted(signal.SIGINT)
    return 0
