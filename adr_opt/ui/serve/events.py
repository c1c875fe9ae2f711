"""Server-sent events: what changed, to every tab that listens."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from typing import Any

from starlette.concurrency import run_in_threadpool

from ...common.errors import InputError
from .desk import Desk
from .strict_json import to_json

PAUSE_S, BREATH_S = 0.2, 15.0
"""Intervals between checks of the desk, and between keep-alive messages [s]."""


async def told(desk: Desk, closing: threading.Event) -> AsyncIterator[str]:
    """Server-sent events: state, results and jobs after every change, and the planner's progress.

    Parameters
    ----------
    desk : Desk
    closing : Event
        Ends it.
    """
    parts: tuple[tuple[str, Callable[[], int], Callable[[], Any]], ...] = (
        ("state", lambda: desk.revision, desk.state),
        ("results", lambda: desk.results_revision, desk.results),
        ("jobs", lambda: desk.jobs_revision, desk.jobs),
    )
    revisions, last, silent_s = dict.fromkeys((name for name, *_ in parts), -1), "", 0.0
    while not closing.is_set():
        silent_s += PAUSE_S
        # Looked at before the state: what the planner is done with is in the state that follows.
        look = to_json(desk.look())
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
        if look != last:
            last = look
            yield f"event: work\ndata: {look}\n\n"
            silent_s = 0.0
        if silent_s >= BREATH_S:
            yield ": still here\n\n"
            silent_s = 0.0
        await asyncio.sleep(PAUSE_S)
