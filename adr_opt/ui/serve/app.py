"""Pages and requests of the session, as a Starlette application."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import AsyncIterator, Callable
from importlib import resources
from typing import Annotated, Any

from pydantic import Field, ValidationError
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from ...common.errors import InputError
from ...common.records import Record
from ...common.sentences import sentence
from ..report import plain
from .drafts import read_edit
from .guard import Guard
from .session import EditingSession, choices
from .work import PlanningOrder

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
"""Content security policy of the page: everything comes from this server."""

FRAMED = "frame-ancestors 'self'"
"""Framing policy of the report, which is shown only within the page."""

PAUSE_S, BREATH_S = 0.2, 15.0
"""Intervals between checks of the session, and between keep-alive messages [s]."""


class OrderRequest(Record):
    """Parameters of a planning run, as requested by the page."""

    method: str
    time_limit_s: float
    bound: str | None = None
    seed: Annotated[int, Field(ge=0)] = 0
    goes_on: bool = True


async def told(session: EditingSession, closing: threading.Event) -> AsyncIterator[str]:
    """Server-sent events: the state after every change, and the planner's progress.

    Parameters
    ----------
    session : EditingSession
    closing : Event
        Ends it.
    """
    revision, last, silent_s = -1, "", 0.0
    while not closing.is_set():
        silent_s += PAUSE_S
        # Looked at before the state: what the planner is done with is in the state that follows.
        look = json.dumps(session.look().to_dict())
        if session.revision != revision:
            revision = session.revision
            state = await run_in_threadpool(session.state)
            yield f"event: state\ndata: {json.dumps(state)}\n\n"
            silent_s = 0.0
        if look != last:
            last = look
            yield f"event: work\ndata: {look}\n\n"
            silent_s = 0.0
        if silent_s >= BREATH_S:
            yield ": still here\n\n"
            silent_s = 0.0
        await asyncio.sleep(PAUSE_S)


def application(
    session: EditingSession, token: str, port: int, closing: threading.Event
) -> Starlette:
    """The application.

    Parameters
    ----------
    session : EditingSession
    token : str
        Required for every request.
    port : int
    closing : Event
        Ends the streams of events.
    """
    style, script = _asset("page.css"), _asset("page.js")
    style = resources.files("adr_opt.ui.report").joinpath("page.css").read_text("utf-8") + style

    async def page(request: Request) -> Response:
        answer = HTMLResponse(_asset("page.html"), headers={"Content-Security-Policy": POLICY})
        answer.set_cookie(f"adr-opt-{port}", token, httponly=True, samesite="strict", path="/")
        return answer

    async def style_sheet(request: Request) -> Response:
        return Response(style, media_type="text/css")

    async def script_file(request: Request) -> Response:
        return Response(script, media_type="text/javascript")

    async def offered(request: Request) -> Response:
        return JSONResponse(choices())

    async def state(request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(session.state))

    async def events(request: Request) -> Response:
        return StreamingResponse(told(session, closing), media_type="text/event-stream")

    async def report(request: Request) -> Response:
        text = await run_in_threadpool(_report, session)
        return HTMLResponse(text, headers={"Content-Security-Policy": FRAMED})

    return Starlette(
        routes=[
            Route("/", page),
            Route("/page.css", style_sheet),
            Route("/page.js", script_file),
            Route("/choices", offered),
            Route("/state", state),
            Route("/events", events),
            Route("/report", report),
            _action("/edit", lambda text: session.edit(read_edit(text))),
            _action("/undo", lambda text: session.undo()),
            _action("/redo", lambda text: session.redo()),
            _action("/plan", lambda text: session.plan(read_order(text))),
            _action("/stop", lambda text: session.stop()),
        ],
        middleware=[Middleware(Guard, token=token, port=port)],
    )


def read_order(text: str) -> PlanningOrder:
    """Parameters of a planning run, from JSON text.

    Raises
    ------
    InputError
        It does not say so.
    """
    try:
        return PlanningOrder(**dict(OrderRequest.from_json(text)))
    except ValidationError as error:
        raise InputError(sentence(error)) from None


def _action(path: str, act: Callable[[str], Any]) -> Route:
    """A POST request that changes something; errors are reported in one sentence."""

    async def answer(request: Request) -> Response:
        try:
            text = (await request.body()).decode("utf-8")
            await run_in_threadpool(act, text)
        except UnicodeDecodeError:
            return JSONResponse({"error": "the request is not text in UTF-8"}, status_code=422)
        except InputError as error:
            return JSONResponse({"error": str(error)}, status_code=422)
        return JSONResponse({})

    return Route(path, answer, methods=["POST"])


def _report(session: EditingSession) -> str:
    try:
        text = session.report()
    except InputError as error:
        return _note("No report", str(error))
    return _note("No plan yet", "Press Plan, and the report comes here.") if text is None else text


def _note(title: str, said: str) -> str:
    return plain.page("Active debris removal mission", title, said, ())


def _asset(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
