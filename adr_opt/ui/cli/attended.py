"""The command line as a child process of :mod:`adr_opt.ui.serve`, which ends with the server."""

from __future__ import annotations

import os
import sys
import threading

from ..serve.children import leave, settle_in
from .entry import main


def watch() -> None:
    """Leave when standard input ends, as it does when the server is killed."""
    # Without a buffer, which would hold a lock that the interpreter wants at the end.
    while os.read(0, 1):
        pass
    leave()


if __name__ == "__main__":
    settle_in()
    threading.Thread(target=watch, name="server", daemon=True).start()
    sys.exit(main())
