"""The command line as a process that Ctrl-C interrupts."""

from __future__ import annotations

# Children of a script in the background inherit an ignored SIGINT; a user's shell does not do that.
CHILD = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from adr_opt.__main__ import main; sys.exit(main())"
)
"""Script for ``python -c``, with the arguments of the command line behind it."""
