"""Entry point: run a verb, and turn any error into one sentence and an exit status."""

from __future__ import annotations

import errno
import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from keyword import iskeyword
from typing import TextIO

import click
from click.shell_completion import shell_complete

from ...common.errors import InputError, failure
from ...common.version import __version__
from .complete import VARIABLE
from .output import say
from .signals import INTERRUPTED, Aborted, interruptible

_VERBS = """
generate worth import windows solve bound check verify price compare tradeoff replan rehearse
scenario fly refine screen dispose matrix export report serve train methods warm-up doctor schema
"""
VERBS = tuple(_VERBS.split())


DEBUG = "--debug"
"""Option that prints the traceback of an internal error."""


class Verbs(click.Group):
    """A group whose verbs are imported on use."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """All verbs, in the usual order of use."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a verb; None if there is no such verb."""
        if cmd_name not in VERBS:
            return None
        # A keyword of the language cannot name a module that others may import.
        module = f"{cmd_name}_" if iskeyword(cmd_name) else cmd_name.replace("-", "_")
        command: click.Command = import_module(f"{__package__}.{module}").command
        if not any(DEBUG in parameter.opts for parameter in command.params):
            command.params.append(_debug(hidden=True))
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb of a call, with the sentence for an unknown one."""
        is_known = args[0].startswith("-") or args[0] in VERBS
        if not is_known and not ctx.resilient_parsing:  # as it is where a shell asks
            raise InputError(f"verb {args[0]!r} is unknown; use one of: {', '.join(VERBS)}")
        return super().resolve_command(ctx, args)


def _debug(*, hidden: bool = False) -> click.Option:
    """The option ``--debug``, before or after a verb; it is looked for before parsing."""
    return click.Option(
        [DEBUG],
        is_flag=True,
        expose_value=False,
        hidden=hidden,
        help="Print the traceback of an internal error; also after the verb.",
    )


@click.group(
    cls=Verbs,
    params=[_debug()],
    no_args_is_help=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="%(prog)s %(version)s", prog_name="adr-opt")
def command() -> None:
    """Plan active-debris-removal missions, and prove how good the plans are.

    Exit status: 0 done; 1 the answer is no (a plan with violations, an infeasible instance);
    2 the input or the call is wrong; 3 the program has failed, or the memory does not suffice.
    With 2 and 3, one sentence on standard error says why. 130: stopped by Ctrl-C.
    """


DONE, WRONG, FAILED, READER_GONE = 0, 2, 3, 128 + 13


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the name of the program; from the process by default.

    Returns
    -------
    int
        The exit status: 0, 1, 2 or 3 as the help says; as usual 130 after Ctrl-C and 141 if the
        reader of standard output went away.
    """
    for stream in (sys.stdout, sys.stderr):
        _can_say_everything(stream)
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with interruptible() as arrived:
            return _answered(words, arrived)
    except KeyboardInterrupt:  # another one, after the last word
        return INTERRUPTED


def _answered(words: list[str], arrived: Callable[[], bool]) -> int:
    """Run a verb and report what it raises; ``arrived`` tells of an interrupt, and ends it."""
    try:
        try:
            status = _run(words.copy())  # click takes them away
        except Exception:
            if arrived():  # an interrupt has made another error of it
                raise KeyboardInterrupt from None
            raise
        if arrived():
            raise KeyboardInterrupt
        if sys.stdout is not None:
            sys.stdout.flush()
        return status
    except click.ClickException as error:
        say(_sentence(error))
        return WRONG
    except InputError as error:
        say(str(error))
        return WRONG
    except Aborted as aborted:
        arrived()
        say("aborted")
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                stream.flush()
        # The planner still runs in its threads and cannot be ended in any other way.
        os._exit(128 + aborted.number)
    except (KeyboardInterrupt, click.Abort):
        arrived()
        say("aborted")
        return INTERRUPTED
    except BrokenPipeError:
        _let_go(sys.stdout)
        return READER_GONE
    except OSError as error:
        if error.errno == errno.ENOMEM:
            return _failed(words, error)
        _let_go(sys.stdout)
        place = error.filename if error.filename is not None else "standard output"
        say(f"{place}: {error.strerror or error}; check the place and its permissions")
        return WRONG
    except Exception as error:
        return _failed(words, error)


def _failed(words: list[str], error: Exception) -> int:
    """Report an error not caused by the input in one sentence; with ``--debug``, its traceback."""
    if DEBUG in words:
        traceback.print_exception(error)
    say(failure(error) + ("" if DEBUG in words else f"; {DEBUG} prints the traceback"))
    return FAILED


def _run(arguments: list[str]) -> int:
    # Not ``command.main``: it has its own ideas of a closed pipe and of Ctrl-C.
    program = "adr-opt"
    if os.environ.get(VARIABLE):
        return shell_complete(command, {}, program, VARIABLE, os.environ[VARIABLE])
    if os.path.basename(sys.argv[0]) == "__main__.py":
        program = "python -m adr_opt"
    try:
        with command.make_context(program, arguments) as context:
            status = command.invoke(context)
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    return status if isinstance(status, int) else DONE


def _sentence(error: click.ClickException) -> str:
    """A click error as one sentence with a pointer to the help."""
    said = " ".join(error.format_message().split()).rstrip(".")
    said = re.sub(r"\.? \(?Did you mean (.*)\?\)?$", r" (did you mean \1?)", said)
    said = said[:1].lower() + said[1:].replace(". ", "; ")
    context = getattr(error, "ctx", None)
    return f"{said}; see '{context.command_path} --help'" if context is not None else said


def _can_say_everything(stream: TextIO | None) -> None:
    """Ensure that printing never fails with UnicodeEncodeError; JSON is UTF-8 by its standard.

    What no encoding can say, as the name of a file in another one, is escaped as JSON does it.
    """
    with suppress(AttributeError, OSError):
        if stream.isatty():  # type: ignore[union-attr]
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]
        else:
            stream.reconfigure(encoding="utf-8", errors="backslashreplace")  # type: ignore[union-attr]


def _let_go(stream: TextIO | None) -> None:
    """Redirect a broken stream to nowhere, so that the interpreter can flush it at exit."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())  # type: ignore[union-attr]
        os.close(nowhere)
