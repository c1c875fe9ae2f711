"""Dropped files: streamed to a temporary file of the project, counted, and handed on."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from ...common.errors import InputError
from .backend import Backend
from .project.private import passing, private_file

MOST_AT_ONCE = 2
"""Maximum number of files that are uploaded at once."""

LONGEST_NAME = 200
"""Maximum length of a file's name [characters]."""


def uploaded(backend: Backend) -> Callable[[Request], Awaitable[Response]]:
    """Handler of uploads, whose size the guard has limited.

    Parameters
    ----------
    backend : Backend
    """
    turn = asyncio.Semaphore(MOST_AT_ONCE)

    async def answer(request: Request) -> Response:
        name = request.query_params.get("name", "")
        if not name or len(name) > LONGEST_NAME:
            return _refused(f"the name of the file must have 1 to {LONGEST_NAME} characters")
        if turn.locked():
            return _refused("other files are being uploaded; drop this one again after them", 429)
        async with turn:
            path = passing(backend.session.folder.path)
            try:
                with private_file(path) as file:
                    async for chunk in request.stream():
                        await run_in_threadpool(file.write, chunk)
                return JSONResponse(await run_in_threadpool(backend.dropped.drop, path, name))
            except InputError as error:
                return _refused(str(error))
            except OSError as error:
                return _refused(not_written("the file", error), 507)
            except ClientDisconnect:
                return Response(status_code=400)  # which nobody hears
            finally:
                path.unlink(missing_ok=True)

    return answer


def not_written(what: str, error: OSError) -> str:
    """A sentence on a failed write, as on a full disk."""
    why = error.strerror or type(error).__name__
    return f"{what} cannot be stored in the project folder ({why}); make room there, and try again"


def _refused(sentence: str, status: int = 422) -> Response:
    return JSONResponse({"error": sentence}, status_code=status)
