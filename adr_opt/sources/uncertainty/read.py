"""Errors of targets from a file: a table, or an Orbit Ephemeris Message with covariances."""

from __future__ import annotations

import os

from ...common.files import read_text
from ...problem.instance import Instance
from .message_covariances import of_message
from .table import read_table
from .target_error import TargetError


def read_target_errors(instance: Instance, path: str | os.PathLike[str]) -> dict[str, TargetError]:
    """Errors of the bodies of an instance by name.

    Parameters
    ----------
    instance : Instance
    path : path
        A table (:mod:`.table`), or a message in key-value notation, which begins with its version.

    Raises
    ------
    InputError
        It cannot be read, or states no errors.
    """
    text = read_text(path)
    if text.lstrip("\ufeff \t\r\n").startswith("CCSDS_OEM_VERS"):
        return of_message(instance, text, str(path))
    return read_table(path, instance.names)
