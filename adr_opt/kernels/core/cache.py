"""Cache of compiled kernels: files in one folder of the user, never beside the sources.

A file holds one kernel compiled for one signature. Its name is a digest of everything that the
machine code depends on: the versions of what compiles, the processor, the types of the arguments,
and the bytecode and constants of the kernel and of all that it can reach. So nothing in the folder
is ever out of date, two checkouts do not disturb each other, and a file that is being written is
not seen: it appears under its name at once or not at all. What the folder lacks may be in the
:mod:`.archive` that a wheel brings along.

Files are optional: an unreadable one is compiled anew, an unwritable one is skipped, and
:func:`trouble` says why. The least recently used are removed first. What is read is executed:
folders and files that other users could have written are not used.
"""

import hashlib
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from enum import Enum
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any
from uuid import uuid4

import llvmlite
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

VARIABLE = "ADR_OPT_CACHE_DIR"
"""Environment variable that names another folder."""

MOST_BYTES = 256 * 2**20
"""Size beyond which the folder is halved; a full set of kernels takes about a tenth."""

_LIBRARIES = sys.stdlib_module_names | {"numpy", "numba", "llvmlite"}
"""Packages identified by their version alone, without a digest of their code."""

_PLAIN = (bool, int, float, complex, str, bytes, type(None), np.generic, np.dtype, numba.types.Type)

_troubles: list[str] = []
_used: set[Path] = set()
_is_pruned = False


def trouble() -> str | None:
    """Reason why compiled kernels could not be cached; None if they could."""
    return next(iter((*refused(), *_troubles)), None)


def used() -> set[Path]:
    """Files of the kernels that Python has called in this process."""
    return set(_used)


def folders() -> list[Path]:
    """Folders to read from and write to, in order of preference; they need not exist."""
    return [folder for folder in _places() if refusal(folder) is None]


def refused() -> list[str]:
    """Folders rejected for the cache, each with the reason in brackets."""
    found = ((folder, refusal(folder)) for folder in _places())
    return [f"{folder} ({reason})" for folder, reason in found if reason is not None]


def _places() -> list[Path]:
    named = os.environ.get(VARIABLE)
    if named:
        return [Path(named)]
    # Without a home directory the name of the folder would be relative.
    usual = Path(AppDirs("adr-opt", appauthor=False).user_cache_dir)
    return [*([usual] if usual.is_absolute() else []), *_temporary()]


def _temporary() -> list[Path]:
    """Folder in place of an unwritable home."""
    with suppress(OSError, AttributeError):  # AttributeError: Windows, where homes are writable
        path = Path(tempfile.gettempdir()) / f"adr-opt-{os.getuid()}"
        path.mkdir(mode=0o700, exist_ok=True)
        if not path.is_symlink():
            return [path]
    return []


def refusal(folder: Path) -> str | None:
    """Reason why a folder is not trusted: other users may write to it; None if it is."""
    try:
        status = folder.stat()
    except OSError:
        return None  # it does not exist, or cannot be read from
    if is_ours(status):
        return None
    return "others can write to it, and what lies there is executed: chmod go-w it as its owner"


def is_ours(status: os.stat_result) -> bool:
    """Whether only this user or root can have written a file or into a folder."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid in (0, os.getuid()) and not status.st_mode & 0o022


Processor = tuple[str, ...]
"""Triple, name and features of a processor."""

Archived = Callable[[Callable[[Processor], str], Processor], bytes | None]


class KernelCache(_Cache):
    """The cache of one kernel, for Numba.

    Parameters
    ----------
    dispatcher : numba.core.dispatcher.Dispatcher
    archived : callable
        Looks elsewhere for what no folder has, see :func:`.archive.find`.
    """

    def __init__(self, dispatcher: Any, archived: Archived) -> None:
        self._dispatcher = dispatcher
        self._archived = archived
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """Folder of first choice."""
        return str(next(iter(folders()), ""))

    def enable(self) -> None:
        """Use files."""
        self._enabled = True

    def disable(self) -> None:
        """Use no files."""
        self._enabled = False

    def flush(self) -> None:
        """Do nothing: no file is out of date."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled kernel of a signature; None if it has to be compiled."""
        target_context.refresh()
        if self._enabled:
            for payload, file in self._found(sig, target_context.codegen().magic_tuple()):
                # Its checksum is right, so this is a file of ours; whatever may be wrong with it
                # all the same, compiling is the answer.
                with suppress(Exception):
                    rebuild, parts = pickle.loads(payload)
                    compiled = rebuild(target_context, *parts)
                    self._note(compiled, file)
                    return compiled
        return None

    def _found(self, sig: Any, own: Processor) -> Iterator[tuple[bytes, Path | None]]:
        """Stored forms of a kernel: those in the folders, with their files, then the archive's."""
        name = self._name(sig, own)
        for folder in folders():
            payload = read(folder / name)
            if payload is not None:
                yield payload, folder / name
        payload = self._archived(lambda other: self._name(sig, other), own)
        if payload is not None:
            yield payload, None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel."""
        if not self._enabled or data.lifted or data.library.has_dynamic_globals:
            return
        rebuild = getattr(data.library, "rebuild", CompileResult._rebuild)
        payload = dumps((rebuild, data._reduce()))
        self._note(data, _write(self._name(sig, data.codegen.magic_tuple()), payload))

    def _note(self, compiled: Any, file: Path | None) -> None:
        """Remember the file of a kernel that Python calls."""
        if file is not None and not getattr(compiled.library, "is_inner", False):
            _used.add(file)

    def _name(self, sig: Any, processor: Processor) -> str:
        versions = numba.__version__, llvmlite.__version__, np.__version__
        python = str(sys.implementation.cache_tag)
        depends = (*versions, python, *processor, _type(sig), sources(self._dispatcher))
        key = hashlib.sha256("\n".join(depends).encode()).hexdigest()[:32]
        function = self._dispatcher.py_func
        named = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        return f"{named}-{key}.kernel"


def read(path: Path) -> bytes | None:
    """Content of a file; None if it is missing or damaged, or another user's."""
    try:
        with path.open("rb") as file:
            content = file.read() if is_ours(os.fstat(file.fileno())) else b""
    except OSError:
        return None
    checksum, payload = content[:32], content[32:]
    if hashlib.sha256(payload).digest() != checksum:
        return None
    with suppress(OSError):
        os.utime(path)  # used just now
    return payload


def _write(name: str, payload: bytes) -> Path | None:
    """Write a file and return its path, or None if it cannot be written."""
    failures = []
    for folder in folders():
        unfinished = folder / f".{uuid4().hex}"
        try:
            folder.mkdir(mode=0o755, parents=True, exist_ok=True)
            unfinished.touch(mode=0o644)  # whatever the mask is, as others could write otherwise
            unfinished.write_bytes(hashlib.sha256(payload).digest() + payload)
            unfinished.replace(folder / name)
        except OSError as error:
            failures.append(f"{folder}: {error.strerror or error}")
            with suppress(OSError):
                unfinished.unlink()
        else:
            _prune(folder)
            return folder / name
    # One that is refused says so itself.
    if failures or not refused():
        _troubles.append(failures[0] if failures else "there is no folder to keep them in")
    return None


def _prune(folder: Path) -> None:
    """Remove the least recently used files if there are too many, once in a process."""
    global _is_pruned
    if _is_pruned:
        return
    _is_pruned = True
    with suppress(OSError):  # another process prunes too
        found = [(entry.stat(), entry.path) for entry in os.scandir(folder) if entry.is_file()]
        total = sum(status.st_size for status, _ in found)
        if total <= MOST_BYTES:
            return
        for status, path in sorted(found, key=lambda item: item[0].st_mtime):
            os.unlink(path)
            total -= status.st_size
            if total <= MOST_BYTES / 2:
                return


def sources(dispatcher: Any) -> str:
    """Digest of a kernel and of everything it depends on: code, constants and compiler options.

    Global names are followed, attributes of modules by their names alone: what else has such a
    name is taken along, which at worst compiles once too often.
    """
    reached: dict[int, str] = {}
    waiting = [dispatcher]
    while waiting:
        item = waiting.pop()
        if id(item) not in reached:
            reached[id(item)] = "; ".join(_describe(item, waiting))
    return hashlib.sha256("\n".join(sorted(reached.values())).encode()).hexdigest()


def _describe(item: Any, waiting: list[Any]) -> Iterator[str]:
    """Description of a kernel or function; those that it names join the list."""
    function = _function(item)
    yield f"{function.__module__}.{function.__qualname__}"
    yield repr(sorted(getattr(item, "targetoptions", {}).items(), key=lambda pair: pair[0]))
    yield _value(function.__defaults__, waiting)
    names: dict[str, None] = {}
    yield from _code(function.__code__, function.__doc__, names, waiting)
    spaces = [function.__globals__]
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    spaces.append({name: cell.cell_contents for name, cell in cells})
    names |= dict.fromkeys(function.__code__.co_freevars)
    seen = set()
    for space in spaces:  # grows
        for name in names:
            if name in space:
                value = space[name]
                if isinstance(value, ModuleType):
                    if value.__name__ not in seen and not _of_library(value.__name__):
                        spaces.append(vars(value))
                    seen.add(value.__name__)
                yield f"{name} = {_value(value, waiting)}"


def _code(code: CodeType, doc: str | None, names: dict[str, None], waiting: list[Any]) -> Any:
    """Bytecode and constants, without file, line numbers and docstring."""
    names |= dict.fromkeys(code.co_names)
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))
    for index, constant in enumerate(code.co_consts):
        if isinstance(constant, CodeType):
            yield from _code(constant, None, names, waiting)
        elif index > 0 or constant != doc:
            yield _value(constant, waiting)


def _value(value: Any, waiting: list[Any]) -> str:
    """A constant, or the name of an object with a description of its own."""
    if isinstance(value, _PLAIN):
        return f"{type(value).__name__} {value!r}"
    if isinstance(value, (tuple, frozenset)):
        parts = [_value(part, waiting) for part in value]
        ordered = parts if isinstance(value, tuple) else sorted(parts)
        return f"{type(value).__name__}({', '.join(ordered)})"
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, type):
        members = list(value) if issubclass(value, Enum) else getattr(value, "_fields", ())
        return f"{value.__module__}.{value.__qualname__} {members!r}"
    function = _function(value)
    if function is not None and not _of_library(function.__module__):
        waiting.append(value)
        return f"{function.__module__}.{function.__qualname__}"
    return type(value).__name__


def _function(value: Any) -> Any:
    """Python function of a kernel, an intrinsic or a function; None of other objects."""
    for name in ("py_func", "_defn"):
        if isinstance(getattr(value, name, None), FunctionType):
            return getattr(value, name)
    return value if isinstance(value, FunctionType) else None


def _of_library(module: str | None) -> bool:
    return (module or "").partition(".")[0] in _LIBRARIES


def _type(kind: Any) -> str:
    """Name of an argument's type; for named tuples with their fields, which Numba leaves out."""
    if hasattr(kind, "instance_class"):
        owner = kind.instance_class
        fields = zip(kind.fields, kind.types, strict=True)
        inner = ", ".join(f"{name}: {_type(field)}" for name, field in fields)
        return f"{owner.__module__}.{owner.__qualname__}({inner})"
    if isinstance(kind, (tuple, numba.types.Tuple, numba.types.UniTuple)):
        parts: Any = kind
        return f"({', '.join(_type(part) for part in parts)})"
    return str(kind)
