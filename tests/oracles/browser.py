"""A headless Chromium, driven through its own pipe: no driver and no package is needed."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from types import TracebackType
from typing import Any

EXECUTABLE = next(
    (
        path
        for name in ("chromium", "chromium-browser", "google-chrome")
        if (path := shutil.which(name))
    ),
    None,
)

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)

PATIENCE_S = 300.0
"""After so long what is waited for does not come, however busy the machine."""

LEVELS = {"error": "error", "assert": "error", "warning": "warning"}


class Browser:
    """One page of a headless Chromium.

    Parameters
    ----------
    profile : Path
        An empty folder for the profile.
    width, height : int
        Size of the window in CSS pixels.
    dark : bool
        Whether the page is told that a dark scheme is wanted.
    options : sequence of str
        More options of Chromium.

    Attributes
    ----------
    requests : list of str
        Addresses of all requests since the page was opened.
    complaints : list of (level, text)
        Level "error" or "warning": what stands in the console, uncaught exceptions and refusals
        of the security policy.
    """

    def __init__(
        self,
        profile: Path,
        *,
        width: int = 1280,
        height: int = 900,
        dark: bool = False,
        options: tuple[str, ...] = (),
    ) -> None:
        assert EXECUTABLE is not None
        self.requests: list[str] = []
        self.complaints: list[tuple[str, str]] = []
        self._width = width
        self._count = 0
        self._rest = b""
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()

        def hand_over() -> None:
            # Chromium reads commands from 3 and answers on 4; the ends may be 3 or 4 already.
            high_in, high_out = os.dup(theirs_in), os.dup(theirs_out)
            while high_in < 10:
                high_in = os.dup(high_in)
            while high_out < 10:
                high_out = os.dup(high_out)
            os.dup2(high_in, 3)
            os.dup2(high_out, 4)

        self._process = subprocess.Popen(
            [EXECUTABLE, *OPTIONS, *options, f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=hand_over,
            close_fds=False,
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._session: str | None = None
        pages = self.call("Target.getTargets")["targetInfos"]
        page = next(info["targetId"] for info in pages if info["type"] == "page")
        self._session = self.call("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        if width < 600:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._process.terminate()
        self._process.wait(PATIENCE_S)
        os.close(self._out)
        os.close(self._in)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the DevTools protocol and wait for its answer."""
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            said = self._read(PATIENCE_S)
            if said.get("id") == self._count:
                if "error" in said:
                    raise RuntimeError(f"{method}: {said['error']['message']}")
                result: dict[str, Any] = said["result"]
                return result

    def open(self, path: Path) -> None:
        """Go to a file."""
        self.go(path.as_uri())

    def go(self, address: str) -> None:
        """Go to an address."""
        self.requests.clear()
        self.complaints.clear()
        self.call("Page.navigate", url=address)

    def open_report(self, path: Path) -> None:
        """Go to a report and down it, until all is drawn: no error, no sideways scrolling."""
        self.open(path)
        self.wait_for("document.documentElement?.dataset.ready")
        self.evaluate("document.getElementById('orbits').scrollIntoView()")
        self.wait_for("document.documentElement?.dataset.complete")
        errors = [text for level, text in self.complaints if level == "error"]
        assert errors == [], errors
        width = self.evaluate("document.documentElement.scrollWidth")
        assert width == self._width, width

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page; a promise is awaited."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def wait_for(self, expression: str, seconds: float = PATIENCE_S) -> Any:
        """Wait until an expression is true and give its value."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if value := self.evaluate(expression):
                return value
            time.sleep(0.05)
        raise TimeoutError(f"{expression} is not true after {seconds:g} s: {self.complaints}")

    def picture(self, path: Path, whole: bool = True) -> None:
        """Write what the page looks like as a PNG file."""
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(shot["data"]))

    def _read(self, seconds: float) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], seconds)
            more = os.read(self._in, 1 << 20) if ready else b""
            if not more:
                raise TimeoutError("Chromium does not answer")
            self._rest += more
        line, _, self._rest = self._rest.partition(b"\0")
        said: dict[str, Any] = json.loads(line)
        self._note(said.get("method", ""), said.get("params", {}))
        return said

    def _note(self, method: str, event: dict[str, Any]) -> None:
        if method == "Network.requestWillBeSent":
            self.requests.append(event["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            details = event["exceptionDetails"]
            said = details.get("exception", {}).get("description", str(details))
            self.complaints.append(("error", said))
        elif method == "Runtime.consoleAPICalled" and event["type"] in LEVELS:
            said = " ".join(str(part.get("value", part)) for part in event["args"])
            self.complaints.append((LEVELS[event["type"]], said))
        elif method == "Log.entryAdded" and event["entry"]["level"] in LEVELS:
            entry = event["entry"]
            self.complaints.append((LEVELS[entry["level"]], entry["text"]))
