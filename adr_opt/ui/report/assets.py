"""Parts of a page, and its content security policy."""

from __future__ import annotations

import base64
import hashlib
from importlib import resources

from ...common.errors import MissingExtra


def policy(*scripts: str) -> str:
    """Content security policy of the page: only its two scripts may run, nothing may be loaded."""
    hashes = " ".join(
        f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
        for text in scripts
    )
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


_ROOMS = """
library state look charts access time spoken motion sun earth moving ground globe view closeup files
burns pictures zones main
"""
ROOMS = tuple(_ROOMS.split())
"""Parts of the script, in the order of assembly."""


def page_script() -> str:
    """The script of the page, as one function, so that its parts share names privately."""
    rooms = "\n".join(asset(f"script/{name}.js") for name in ROOMS)
    return f'"use strict";\n(async () => {{\n{rooms}}})();\n'


def asset(name: str, package: str = "adr_opt.ui.report") -> str:
    """A file of a package, as text."""
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")


def chart_library() -> str:
    """plotly.js, from the plotly package."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise MissingExtra("a report", "plotly", "viz") from None
    library: str = get_plotlyjs()
    return library
