"""Errors reported in one sentence: wrong input, missing extras, and failures of any other kind."""

from __future__ import annotations

import errno
from typing import Any

from .wording import cut, in_one_line

LONGEST_SAID = 300
"""Length beyond which the error message of a library is cut [characters]."""


class InputError(ValueError):
    """Wrong input or a wrong call: the command line prints the sentence and exits with 2.

    The sentence names the file, the field, the value and what to do, as far as they are known. What
    it quotes may come from anywhere: long names are cut, and control characters escaped.

    Parameters
    ----------
    sentence : str
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(in_one_line(sentence))

    def __reduce__(self) -> Any:
        # From one process to another; of a derived class the arguments are not known any more.
        return InputError, self.args


class MissingExtra(InputError):
    """An optional dependency is not installed.

    Parameters
    ----------
    what : str
        The requested operation, for example "flying a plan".
    package : str
        The package that is missing.
    extra : str
        The extra of adr-opt that installs it.
    """

    def __init__(self, what: str, package: str, extra: str) -> None:
        super().__init__(
            f"{what} needs the package {package}: install the extra with "
            f"pip install 'adr-opt[{extra}]'"
        )


def failure(error: BaseException) -> str:
    """One sentence on an error that was not caused by the input.

    Parameters
    ----------
    error : BaseException
    """
    from concurrent.futures import BrokenExecutor

    said = cut(" ".join(str(error).split()), LONGEST_SAID)
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return (
            f"memory has run out{f' ({said})' if said else ''}; end other programs, allow this one "
            "more, or make the mission smaller"
        )
    if isinstance(error, BrokenExecutor):
        return (
            "a worker process has died, most likely for lack of memory; end other programs, or "
            "give fewer --jobs"
        )
    if isinstance(error, ImportError):
        package = error.name or "a package"
        return f"{package} cannot be imported ({said}); 'adr-opt doctor' says what to do"
    what = f"{type(error).__name__}: {said}" if said else type(error).__name__
    return f"internal error, {what}"
