"""Access control: requests with the token, from this machine, of a limited size."""

from __future__ import annotations

import json
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MOST_BYTES = 2**20
"""Maximum size of a request: an edit that names 10,000 targets has half of it [bytes]."""

MOST_UPLOADED_BYTES = 64 * 2**20
"""Maximum size of a dropped file: 24,000 objects as OMM XML take 45 MB [bytes]."""

UPLOAD = "/upload"
"""The only address that accepts bytes instead of JSON."""

SERVER = "adr-opt-server"
"""Header in which a page names the server that it came from."""

HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""Headers of every answer. There are none of CORS: no other page may read anything."""


WELCOME = "adr_opt.welcome"
"""Key in a request's state of the function that marks its connection as known."""


class TooLarge(Exception):
    """A request is larger than declared, or than allowed."""


class Guard:
    """Passes permitted requests on, and refuses all others.

    The host has to be this machine by a name that no foreign name server can give
    out: a foreign page whose name leads here (DNS rebinding) says another one. The token
    is in the query or in a cookie that the browser sends to this page alone. What changes something
    is a POST of JSON, from this page; or of bytes, for a dropped file at :data:`UPLOAD` alone.

    Parameters
    ----------
    app : ASGI application
    token : str
    port : int
        That the server listens at.
    server : str
        Which server this is: a page of one before it, on the same port, gets nothing.
    """

    def __init__(self, app: ASGIApp, token: str, port: int, server: str) -> None:
        self._app = app
        self._token = token.encode()
        self._server = server
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self._cookie = cookie_name(port)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] != "http":
            return
        headers = Headers(scope=scope)

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                said = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    said.setdefault(name, value)
            await send(message)

        refused = self._refused(scope, headers)
        if refused is not None:
            await _refuse(*refused, answer)
            return
        _welcome(scope)
        counted, started = 0, False
        most = _most(scope)

        async def limited() -> Message:
            nonlocal counted
            message = await receive()
            counted += len(message.get("body", b""))
            if counted > most:
                raise TooLarge
            return message

        async def noted(message: Message) -> None:
            nonlocal started
            started = True
            await answer(message)

        try:
            await self._app(scope, limited, noted)
        except TooLarge:
            if not started:
                await _refuse(413, _too_large(most), answer)

    def _refused(self, scope: Scope, headers: Headers) -> tuple[int, str] | None:
        """Status and sentence of a refusal."""
        hosts = headers.getlist("host")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return 403, "this is served to 127.0.0.1 only; open the address that was printed"
        token = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[-1]
        if not self._knows(token) and not self._knows(_cookie(headers, self._cookie)):
            return 403, "the token is missing or wrong; open the address that was printed"
        site, origin = headers.get("sec-fetch-site"), headers.get("origin")
        # Another port of this machine is the same site, and gets the cookie, but is not this page.
        foreign = site in ("same-site", "cross-site") and not self._knows(token)
        if foreign or origin not in (None, f"http://{hosts[0]}"):
            return 403, "another page asked for this; open the address that was printed"
        if headers.get(SERVER, self._server) != self._server:
            return 409, "the server was restarted; open the address that was printed"
        if scope["method"] == "POST":
            kind = headers.get("content-type", "").partition(";")[0].strip()
            if kind != ("application/octet-stream" if _uploads(scope) else "application/json"):
                return 415, "a request for a change must be JSON, and a dropped file bytes"
            length, most = headers.get("content-length", "0"), _most(scope)
            if not (length.isascii() and length.isdigit()) or len(length) > 12:
                return 413, _too_large(most)
            if int(length) > most:
                return 413, _too_large(most)
        elif scope["method"] not in ("GET", "HEAD"):
            return 405, "only GET and POST are answered"
        return None

    def _knows(self, token: str) -> bool:
        return secrets.compare_digest(token.encode(), self._token)


def _welcome(scope: Scope) -> None:
    """Mark the connection of a request that has shown the token as known."""
    mark = scope.get("state", {}).get(WELCOME)
    if mark is not None:
        mark()


def cookie_name(port: int) -> str:
    """Name of the cookie with the token: browsers do not tell the ports of a machine apart."""
    return f"adr-opt-{port}"


def _uploads(scope: Scope) -> bool:
    return bool(scope["path"] == UPLOAD)


def _most(scope: Scope) -> int:
    """Maximum size of this request [bytes]."""
    return MOST_UPLOADED_BYTES if _uploads(scope) else MOST_BYTES


def _too_large(most: int) -> str:
    return f"the request is too large; the most is {most} bytes"


def _cookie(headers: Headers, name: str) -> str:
    """Value of a cookie; empty if absent."""
    try:
        found = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return ""
    return "" if found is None else found.value


async def _refuse(status: int, sentence: str, send: Send) -> None:
    """Refuse a request without reading its body, and end the connection."""
    body = json.dumps({"error": sentence}).encode()
    headers = [
        (b"content-type", b"application/json"),
        (b"content-length", str(len(body)).encode()),
        (b"connection", b"close"),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
