"""Addresses of the server, as a Starlette application."""

from __future__ import annotations

import asyncio
import gzip
import json
import secrets
import threading
from collections.abc import AsyncIterator, Callable
from importlib import resources
from typing import Any

from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    Response,
    StreamingResponse,
)
from starlette.routing import Route

from ...common.errors import InputError
from ..cli.output import plain_data
from ..report import page, plain
from ..report.assets import asset
from .backend import Backend, choices
from .drafts import read_edit
from .forms.fields import form_fields
from .forms.refusals import in_labels
from .guard import UPLOAD, Guard, cookie_name
from .planning import PlanningOrder
from .requests import (
    ChooseRequest,
    JobRequest,
    RemoveRequest,
    ShowRequest,
    StopRequest,
    read_request,
)
from .session import EditingSession
from .uploads import not_written, uploaded


class ShownReport:
    """Report of the plan that a session shows.

    Parameters
    ----------
    session : EditingSession
    """

    def __init__(self, session: EditingSession) -> None:
        self._session = session
        self._made: tuple[int, str] | None = None

    def text(self) -> str | None:
        """The page; None without a plan.

        Raises
        ------
        InputError
            There can be none, as where plotly is not installed.
        """
        shown = self._session.shown()
        if shown is None:
            return None
        number, instance, plan = shown
        made = self._made
        if made is None or made[0] != number:
            made = self._made = number, page(instance, plan)
        return made[1]


def to_json(content: Any) -> str:
    """JSON data as ASCII text, with null for each number that is not finite.

    Parameters
    ----------
    content : JSON data
    """
    try:
        return json.dumps(content, allow_nan=False)
    except ValueError:
        return json.dumps(plain_data(content), allow_nan=False)


PAUSE_S, BREATH_S = 0.2, 15.0
"""Intervals between checks of the backend, and between keep-alive messages [s]."""


async def event_stream(backend: Backend, closing: threading.Event) -> AsyncIterator[str]:
    """Server-sent events: state, results and jobs after every change, and the planner's progress.

    Parameters
    ----------
    backend : Backend
    closing : Event
        Ends it.
    """
    parts: tuple[tuple[str, Callable[[], int], Callable[[], Any]], ...] = (
        ("state", lambda: backend.session.revision, backend.state),
        ("results", lambda: backend.session.results.revision, backend.results),
        ("jobs", lambda: backend.queue.revision, backend.queue.rows),
    )
    revisions, last, silent_s = dict.fromkeys((name for name, *_ in parts), -1), "", 0.0
    while not closing.is_set():
        silent_s += PAUSE_S
        # Looked at before the state: what the planner is done with is in the state that follows.
        progress = to_json(backend.session.progress().to_dict())
        for name, revision, content in parts:
            now = revision()
            if now != revisions[name]:
                revisions[name] = now
                try:
                    text = to_json(await run_in_threadpool(content))
                    yield f"event: {name}\ndata: {text}\n\n"
                except InputError as error:
                    yield f"event: trouble\ndata: {to_json(str(error))}\n\n"
                silent_s = 0.0
        if progress != last:
            last = progress
            yield f"event: work\ndata: {progress}\n\n"
            silent_s = 0.0
        if silent_s >= BREATH_S:
            yield ": still here\n\n"
            silent_s = 0.0
        await asyncio.sleep(PAUSE_S)


PACKAGE = "adr_opt.ui.serve"
"""Folder of the page's files."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "worker-src 'self'; img-src 'self' data:; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page: everything comes from this server."""

FRAMED = "sandbox allow-scripts allow-downloads allow-modals; frame-ancestors 'self'"
"""Policy of the report, which is shown only within the page, and cannot query this server."""


def application(
    backend: Backend,
    token: str,
    port: int,
    closing: threading.Event,
    opened: Callable[[], None] = lambda: None,
) -> Starlette:
    """The application.

    Parameters
    ----------
    backend : Backend
    token : str
        Required for every request.
    port : int
    closing : Event
        Ends the streams of events.
    opened : callable
        Called when the page is asked for.
    """
    session, dropped, queue = backend.session, backend.dropped, backend.queue
    shown = ShownReport(session)
    # Pages say which server they are of: one of another is refused, whatever its token.
    server = secrets.token_hex(8)
    text_of_page = asset("page.html", PACKAGE).replace("SERVER", server)

    async def page(request: Request) -> Response:
        opened()
        answer = HTMLResponse(text_of_page, headers={"Content-Security-Policy": POLICY})
        answer.set_cookie(cookie_name(port), token, httponly=True, samesite="strict", path="/")
        return answer

    async def events(request: Request) -> Response:
        return StreamingResponse(event_stream(backend, closing), media_type="text/event-stream")

    async def report(request: Request) -> Response:
        text = await run_in_threadpool(_report, session, shown)
        return HTMLResponse(text, headers={"Content-Security-Policy": FRAMED})

    async def exported(request: Request) -> Response:
        try:
            path = await run_in_threadpool(backend.archive)
        except InputError as error:
            return JSONResponse({"error": str(error)}, status_code=422)
        except OSError as error:
            return JSONResponse({"error": not_written("the archive", error)}, status_code=507)
        return FileResponse(
            path,
            media_type="application/zip",
            filename=f"{backend.name}.zip",
            background=BackgroundTask(path.unlink),
        )

    async def of_result(request: Request) -> Response:
        """The page of a result, or one of its files by name."""
        number, name = (request.query_params.get(each, "") for each in ("id", "name"))
        try:
            if request.url.path.endswith("page"):
                text = await run_in_threadpool(backend.page, number)
                return HTMLResponse(text, headers={"Content-Security-Policy": FRAMED})
            path = await run_in_threadpool(backend.file, number, name)
        except InputError as error:
            return JSONResponse({"error": str(error)}, status_code=404)
        kind = "application/octet-stream"
        return FileResponse(path, media_type=kind, filename=f"{number}-{path.name}")

    actions: dict[str, Callable[[str], Any]] = {
        "/files/remove": lambda text: dropped.remove(read_request(RemoveRequest, text).file),
        "/edit": lambda text: session.edit(read_edit(text)),
        "/undo": lambda text: session.undo(),
        "/redo": lambda text: session.redo(),
        "/lift": lambda text: session.lift_windows(),
        "/plan": lambda text: session.plan(read_request(PlanningOrder, text)),
        "/sample": lambda text: backend.sample(),
        "/stop": lambda text: session.stop(),
        "/choose": lambda text: backend.choose(read_request(ChooseRequest, text)),
        "/jobs": lambda text: backend.begin(read_request(JobRequest, text)),
        "/jobs/stop": lambda text: queue.stop(read_request(StopRequest, text).job),
        "/show": lambda text: backend.show(read_request(ShowRequest, text)),
    }
    return Starlette(
        routes=[
            Route("/", page),
            *_assets(),
            _told("/choices", choices),
            _told("/state", backend.state),
            _told("/objects", backend.dropped.columns),
            _told("/forms", form_fields),
            _told("/jobs", backend.queue.rows),
            _told("/results", backend.results),
            Route("/events", events),
            Route("/report", report),
            Route("/results/page", of_result),
            Route("/results/file", of_result),
            _told_of("/results/points", backend.points),
            Route("/export", exported),
            Route(UPLOAD, uploaded(backend), methods=["POST"]),
            *(_action(backend, path, act) for path, act in actions.items()),
        ],
        middleware=[Middleware(Guard, token=token, port=port, server=server)],
    )


def _told(path: str, content: Callable[[], Any]) -> Route:
    """A GET request that is answered with JSON, compressed where the browser takes that."""
    return _told_of(path, lambda number: content())


def _told_of(path: str, content: Callable[[str], Any]) -> Route:
    """A GET request about a result, whose number is the query's ``id``."""

    def text(number: str, compressed: bool) -> bytes:
        plain_text = to_json(content(number)).encode()
        return gzip.compress(plain_text, 5) if compressed else plain_text

    async def answer(request: Request) -> Response:
        compressed = "gzip" in request.headers.get("accept-encoding", "")
        headers = {"Content-Encoding": "gzip"} if compressed else {}
        number = request.query_params.get("id", "")
        try:
            body = await run_in_threadpool(text, number, compressed)
        except InputError as error:
            return JSONResponse({"error": str(error)}, status_code=422)
        return Response(body, media_type="application/json", headers=headers)

    return Route(path, answer)


def _action(backend: Backend, path: str, act: Callable[[str], Any]) -> Route:
    """A POST request that changes something; errors are reported in one sentence.

    The answer has the state that it leaves, so that what the page asks next is asked of that.
    """

    async def answer(request: Request) -> Response:
        try:
            text = (await request.body()).decode("utf-8")
            made = await run_in_threadpool(act, text)
            content = made if isinstance(made, dict) else {}
            told = to_json({**content, "state": await run_in_threadpool(backend.state)})
        except ClientDisconnect:
            return Response(status_code=400)  # which nobody hears
        except UnicodeDecodeError:
            return JSONResponse({"error": "the request is not text in UTF-8"}, status_code=422)
        except InputError as error:
            return JSONResponse({"error": in_labels(str(error))}, status_code=422)
        except OSError as error:
            return JSONResponse({"error": not_written("that", error)}, status_code=507)
        return Response(told, media_type="application/json")

    return Route(path, answer, methods=["POST"])


def _assets() -> list[Route]:
    """Style sheets and scripts of the page: a fixed list, read once."""
    style = asset("page.css") + asset("page.css", PACKAGE)
    found = {"/page.css": (style, "text/css")}
    found["/page.js"] = asset("page.js", PACKAGE), "text/javascript"
    scripts = resources.files(PACKAGE).joinpath("script")
    for each in scripts.iterdir() if scripts.is_dir() else ():
        if each.name.endswith(".js"):
            found[f"/script/{each.name}"] = each.read_text("utf-8"), "text/javascript"

    def route(path: str, text: str, kind: str) -> Route:
        async def answer(request: Request) -> Response:
            return Response(text, media_type=kind)

        return Route(path, answer)

    return [route(path, *content) for path, content in found.items()]


def _report(session: EditingSession, shown: ShownReport) -> str:
    try:
        text = shown.text()
    except InputError as error:
        return _note("No report", str(error))
    if text is not None:
        return text
    progress = session.progress()
    if progress.phase in ("done", "failed") and progress.said:
        failed = "Planning failed" if progress.phase == "failed" else "No plan"
        return _note(failed, f"{progress.said}. Earlier plans are in the list of results.")
    return _note("No plan yet", "Press Plan to see the report here.")


def _note(title: str, said: str) -> str:
    return plain.page("Active debris removal mission", title, said, ())
