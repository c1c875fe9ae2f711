"""Actions in tests of ``serve``: edit, wait, and read the files."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.serve import planning
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.session import EditingSession
from adr_opt.ui.serve.work import Work

PATIENCE_S = 300.0
"""After so long what is waited for does not come, however busy the machine."""


def session_of(instance: Instance | None, plan: Plan | None, folder: Folder) -> EditingSession:
    """A session that plans in a thread of this process."""
    return EditingSession(instance, plan, folder, Work)


def of(*names: str, **changes: Any) -> dict[str, Any]:
    """An edit of some targets."""
    return {"targets": {"names": names, **changes}}


def files_under(folder: Path) -> dict[str, bytes]:
    """All files below a folder with what is in them."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def at_hand(folder: Path) -> list[str]:
    """Files of a project folder beside those of the project itself."""
    own = ("project.json", "history", "results", "files")
    return sorted(name for name in files_under(folder) if Path(name).parts[0] not in own)


def wait(desk: EditingSession) -> planning.PlanningProgress:
    """The run once it is over."""
    assert desk._work.wait(PATIENCE_S)
    return desk.progress()


def until(condition: Callable[[], Any]) -> None:
    """Wait until something holds."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
