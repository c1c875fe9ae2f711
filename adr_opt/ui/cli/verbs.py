"""The verbs, each in the module of its name."""

from __future__ import annotations

from importlib import import_module
from keyword import iskeyword

import click

from ...common.errors import InputError
from ...common.version import __version__

VERBS = (
    "generate",
    "worth",
    "import",
    "solve",
    "bound",
    "check",
    "verify",
    "price",
    "compare",
    "tradeoff",
    "replan",
    "rehearse",
    "scenario",
    "fly",
    "refine",
    "matrix",
    "export",
    "report",
    "serve",
    "train",
    "methods",
    "warm-up",
    "doctor",
    "schema",
)


DEBUG = "--debug"
"""Option that prints the traceback of an internal error."""


class Verbs(click.Group):
    """A group whose verbs are imported on use."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """All verbs, in their usual order of use."""
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
    """The option, before and after a verb; the entry looks for it before anything is parsed."""
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
    Of 2 and 3 one sentence on standard error says why. 130: Ctrl-C.
    """
