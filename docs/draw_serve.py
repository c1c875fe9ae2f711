"""Take the picture of docs/serve.md: the page of ``serve`` beside its report, in a browser.

    python docs/draw_serve.py              # into docs/pictures
    python docs/draw_serve.py --out DIR

Plans a generated field, changes what is wanted of it, and plans again. Needs Chromium and the extra
``[serve]``; the browser is driven as the tests do it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

import adr_opt
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.server import Server, listening
from adr_opt.ui.serve.session import EditingSession

ROOT = Path(__file__).parents[1]
WIDTH, HEIGHT = 1280, 900
LIMIT_S = 30

sys.path.insert(0, str(ROOT / "tests/oracles"))

from browser import Browser  # noqa: E402


def drawn(tab: Browser, url: str) -> None:
    """A field planned, with a target that is worth more, and one that is excluded."""
    tab.go(url)
    tab.wait_for("document.documentElement?.dataset.reported")
    for label, change in (
        ("Prize of debris-003", "field.value = 3"),
        ("Exclude debris-009", "field.checked = true"),
    ):
        found = f"document.querySelector('[aria-label={json.dumps(label)}]')"
        before = tab.evaluate("document.documentElement.dataset.revision")
        tab.evaluate(
            f"(() => {{ const field = {found}; {change}; "
            "field.dispatchEvent(new Event('change', { bubbles: true })); })()"
        )
        tab.wait_for(f"document.documentElement.dataset.revision !== '{before}'")
    tab.evaluate(f"document.getElementById('limit').value = '{LIMIT_S}'")
    tab.evaluate("document.getElementById('plan').click()")
    tab.wait_for("document.documentElement.dataset.phase === 'done'", 120.0)
    tab.wait_for("document.documentElement.dataset.reported === '1'")
    tab.evaluate("document.getElementById('said').textContent = ''")
    time.sleep(15.0)  # the report is a page of its own, and draws in its own time


def main() -> None:
    """Take it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs/pictures")
    out = parser.parse_args().out
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as profile:
        instance = adr_opt.generate("reduced-time", 7)
        desk = EditingSession(instance, None, Folder(Path(folder) / "my-served", "my.json"))
        server = Server(desk, listening())
        server.start()
        try:
            with Browser(Path(profile), width=WIDTH, height=HEIGHT) as tab:
                drawn(tab, server.url)
                tab.evaluate("document.getElementById('folder').textContent = 'Kept in my-served'")
                tab.picture(Path(folder) / "serve.png", whole=False)
        finally:
            server.close()
            desk.close(60.0)
        with Image.open(Path(folder) / "serve.png") as picture:
            # The few colours of small marks count as much as those of large faces.
            few = picture.convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=3)
        few.save(out / "serve.png", optimize=True)


if __name__ == "__main__":
    main()
