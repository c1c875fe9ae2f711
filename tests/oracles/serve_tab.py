"""``serve`` as a process, and what somebody does on its page in a browser."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

from browser import PATIENCE_S, Browser
from interruptible import CHILD

PAINTED = (
    "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
)
"""True once the page has been painted as it is now."""


@contextmanager
def served(folder: Path, *arguments: str) -> Iterator[dict[str, Any]]:
    """What `serve` says as JSON, while it runs; it ends well when it is interrupted."""
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, "serve", *arguments, "--no-open", "--json"],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    lines = []
    while not lines or lines[-1] not in ("}\n", ""):
        lines.append(process.stdout.readline())
    try:
        assert lines[-1], process.communicate()
        said = json.loads("".join(lines))
        yield said
    finally:
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    assert "Traceback" not in err, err
    said["stderr"] = err


def put(tab: Browser, label: str, value: object) -> None:
    """Change a field, by its label or #id, as by typing, and leave it."""
    found = label if label.startswith("#") else f"[aria-label={json.dumps(label)}]"
    tab.evaluate(
        f"(() => {{ const field = document.querySelector({json.dumps(found)});"
        f" field.value = {json.dumps(value)};"
        " for (const kind of ['input', 'change'])"
        " field.dispatchEvent(new Event(kind, { bubbles: true })); })()"
    )


def click(tab: Browser, name: str) -> None:
    """Press a button, or open what is closed."""
    tab.evaluate(f"document.getElementById('{name}').click()")


def text(tab: Browser, name: str) -> str:
    """What an element says."""
    said: str = tab.evaluate(f"document.getElementById('{name}').textContent")
    return said


def on_page(tab: Browser, key: str, value: object) -> None:
    """Wait until the page says so of itself."""
    wanted = json.dumps(str(value))
    tab.wait_for(f"document.documentElement?.dataset.{key} === {wanted}")


def look(tab: Browser, width: int, dark: bool) -> None:
    """Another width of the window, and another scheme."""
    tab.call(
        "Emulation.setDeviceMetricsOverride",
        width=width,
        height=844 if width < 600 else 900,
        deviceScaleFactor=1,
        mobile=width < 600,
    )
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    tab.call("Emulation.setEmulatedMedia", features=[scheme])


def drop(tab: Browser, *paths: Path) -> None:
    """Drag files over the edge of the page onto its middle, and let them go.

    The report in its frame has events of its own: a page hears of files that come over its edge,
    and lets them through its frame once it has been painted again. A hidden tab is not painted, and
    one that is may still be looked up as it was: they are let go where the page has heard of them.
    """
    files = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}

    def move(kind: str, x: int, y: int) -> None:
        tab.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data=files)

    tab.call("Page.bringToFront")
    tab.evaluate(PAINTED)
    tab.evaluate("addEventListener('dragover', ({ clientX }) => { window.draggedTo = clientX; })")
    move("dragEnter", 4, 4)
    move("dragOver", 4, 4)
    tab.wait_for("document.body.classList.contains('dragging')")
    end = time.monotonic() + PATIENCE_S
    while tab.evaluate("window.draggedTo") != 640:
        assert time.monotonic() < end
        tab.evaluate(PAINTED)
        move("dragOver", 640, 300)
    move("drop", 640, 300)


def drag(
    tab: Browser,
    selector: str,
    begin: tuple[float, float],
    end: tuple[float, float],
    steps: int = 8,
) -> None:
    """Drag the mouse within an element, between two places as shares of its width and height."""
    box = tab.evaluate(
        f"(() => {{ const box = document.querySelector({json.dumps(selector)})"
        ".getBoundingClientRect(); return [box.x, box.y, box.width, box.height]; })()"
    )

    def mouse(kind: str, share: float, **more: Any) -> None:
        x, y = (first + share * (last - first) for first, last in zip(begin, end, strict=True))
        tab.call(
            "Input.dispatchMouseEvent",
            type=kind,
            button="left",
            clickCount=1,
            x=box[0] + x * box[2],
            y=box[1] + y * box[3],
            **more,
        )

    mouse("mousePressed", 0.0)
    for step in range(1, steps + 1):
        mouse("mouseMoved", step / steps, buttons=1)
    mouse("mouseReleased", 1.0)


def in_report(tab: Browser, expression: str) -> Any:
    """Value of an expression in the report, which is a page of its own, once it is true."""
    mine = tab._session
    tab._session = None
    end, reports = time.monotonic() + PATIENCE_S, []
    while not reports and time.monotonic() < end:  # after a reload it comes later than the page
        found = tab.call("Target.getTargets")["targetInfos"]
        reports = [each["targetId"] for each in found if "/report?" in each["url"]]
    (target,) = reports
    tab._session = tab.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    try:
        return tab.wait_for(expression)
    finally:
        tab._session = mine


class Tabs:
    """More tabs of a browser, of which each is the one that is driven while it is gone through.

    Parameters
    ----------
    tab : Browser
    count : int
    windows : bool
        Whether each has a window of its own, so that all are seen.
    """

    def __init__(self, tab: Browser, count: int, *, windows: bool = False) -> None:
        self._tab, self._count, self._windows = tab, count, windows
        self._targets: list[tuple[str, str]] = []

    def __enter__(self) -> Tabs:
        self._mine, self._tab._session = self._tab._session, None
        for _ in range(self._count):
            target = self._tab.call(
                "Target.createTarget", url="about:blank", newWindow=self._windows
            )["targetId"]
            session = self._tab.call("Target.attachToTarget", targetId=target, flatten=True)
            self._targets.append((target, session["sessionId"]))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._tab._session = None
        for target, _ in self._targets:
            self._tab.call("Target.closeTarget", targetId=target)
        self._tab._session = self._mine

    def __iter__(self) -> Iterator[int]:
        for number, (_, session) in enumerate(self._targets):
            self._tab._session = session
            yield number
