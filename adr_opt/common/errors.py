"""Errors of calls and files, each reported in one sentence."""


class InputError(ValueError):
    """Wrong input or a wrong call: the command line prints the sentence and exits with 2.

    The sentence names the file, the field, the value and what to do, as far as they are known.
    """


class MissingExtra(InputError):
    """An optional dependency is not installed.

    Parameters
    ----------
    what : str
        What was asked for, "flying a plan" for example.
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
