"""``python -m adr_opt``, also installed as ``adr-opt``."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress

INTERRUPTED = 128 + 2
"""Exit status after Ctrl-C, the one that shells use."""


def main() -> int:
    """Run the command line and return the exit status of this process."""
    # Importing takes a tenth of a second, in which Ctrl-C would print a traceback; and so would the
    # end of the interpreter. An ignored signal, as in the background of a script, stays ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    try:
        from .ui.cli.entry import main as run
    except ImportError as error:
        if "--debug" in sys.argv:
            raise
        print(
            f"adr-opt: {error.name or 'a package'} cannot be imported ({error}); install adr-opt "
            "again with pip, or add --debug for the traceback",
            file=sys.stderr,
        )
        return 3
    status = run()
    if status == INTERRUPTED:
        # Python kills itself if an interrupt has passed through ``exec``, and waits for threads.
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                stream.flush()
        os._exit(status)
    return status


def _leave(number: int, frame: object) -> None:
    """End the process at once; no clean-up is needed before or after the command runs."""
    os.write(2, b"adr-opt: aborted\n")
    os._exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
