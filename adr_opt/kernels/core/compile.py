"""Compiler settings of all kernels, and the time spent compiling.

Numba optimises each function and emits its machine code, and does both again in every caller.
A function that only kernels call needs neither: it is an *inner* kernel, intermediate code that is
linked into its callers and optimised there.
"""

import gc
import time
from collections.abc import Callable
from typing import Any

from llvmlite import binding as llvm
from numba import njit, types
from numba.core import event
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, compile_result

from ...common.clock import leave_out
from . import enabled
from .archive import find
from .cache import KernelCache


class _NoMachineCode:
    """Stand-in for Numba's code generator where a function has no machine code of its own."""

    @staticmethod
    def set_env(name: str, env: Any) -> None:
        """Do nothing: the variable is in the callers; see :class:`OuterCompiler`."""


class InnerLibrary(JITCodeLibrary):
    """Intermediate code of a function, to be linked into its callers."""

    is_inner = True

    @property
    def codegen(self) -> Any:
        """Stand-in that ignores environments; other methods use ``_codegen``."""
        return _NoMachineCode

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Address of the machine code: 0, as there is none."""
        self._ensure_finalized()
        return 0

    @property
    def rebuild(self) -> Any:
        """Function that restores a compiled function; see :func:`rebuilt`."""
        return rebuilt

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """Name, kind and intermediate code."""
        return (self.name, "inner", self._get_module_for_linking().as_bitcode())


class InnerCompiler(Compiler):
    """Numba's compiler, into an :class:`InnerLibrary`."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function."""
        self.state.library = InnerLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


class OuterCompiler(Compiler):
    """Numba's compiler, for functions that Python calls."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function."""
        compiled: Any = super().compile_extra(func)
        # Its machine code holds the variables of the inner functions that it calls.
        for env in compiled._find_referenced_environments():
            compiled.codegen.set_env(env.env_name, env)
        return compiled


def rebuilt(
    target: Any,
    code: tuple[str, str, bytes],
    description: Any,
    env: Any,
    signature: Any,
    *more: Any,
) -> Any:
    """Inner function, restored from the parts that ``CompileResult._reduce`` gives.

    Parameters
    ----------
    target : numba.core.base.BaseContext
    code : tuple
        What :meth:`InnerLibrary.serialize_using_object_code` gives.
    description, env, signature, *more
        As ``CompileResult._rebuild`` takes them.
    """
    objectmode, lifted, annotation, reload_init, envs = more
    for initialise in reload_init:
        initialise()
    library = InnerLibrary(target.codegen(), code[0])
    library._final_module = llvm.parse_bitcode(code[2])
    library._finalize_final_module()
    return compile_result(
        typing_context=target.typing_context,
        target_context=target,
        entry_point=target.get_executable(library, description, env),
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        fndesc=description,
        library=library,
        environment=env,
        reload_init=reload_init,
        referenced_envs=envs,
    )


Function = Callable[..., Any]

# What is imported by way of this module cannot be called in Python, and says so before any work.
enabled.need()


def _compiled(**options: Any) -> Callable[[Function], Function]:
    # ``nogil``: kernels run in threads, one per core, without fork and without a threading layer.
    # ``error_model="numpy"``: a division by zero gives inf, as in NumPy, and saves a branch.
    # No ``fastmath``: tables hold +inf for "no transfer", and two machines must agree.
    # No ``cache``: Numba would write beside the sources and overlook changes of other files.
    # ``no_cfunc_wrapper``: nobody calls kernels from C, and it is an eighth of the compiling.
    options |= {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    decorate = njit(**options, pipeline_class=OuterCompiler)
    inner = options | {"no_cpython_wrapper": True, "pipeline_class": InnerCompiler}
    decorate_within = njit(**inner)

    def decorator(function: Function) -> Function:
        dispatcher: Any = decorate(function)
        keep(dispatcher)
        _call_within(dispatcher, decorate_within(function))
        return dispatcher  # type: ignore[no-any-return]

    return decorator


def keep(dispatcher: Any) -> None:
    """Cache the compiled code of a function for later runs, even if its package does not.

    Parameters
    ----------
    dispatcher : numba.core.dispatcher.Dispatcher
    """
    dispatcher._cache = KernelCache(dispatcher, find)


def _call_within(dispatcher: Any, within: Any) -> None:
    """Give kernels a twin to call that Python cannot call, unless Python has called the kernel.

    Code that unpacks a mission from Python objects takes a fifth of all compiling.
    """
    keep(within)
    own_template, own_overload = dispatcher.get_call_template, dispatcher.get_overload

    def template(args: Any, kws: Any) -> Any:
        args = tuple(_plain(kind) for kind in args)
        named = {name: _plain(kind) for name, kind in kws.items()}
        known = not named and args in dispatcher.overloads
        return (own_template if known else within.get_call_template)(args, named)

    def overload(args: Any) -> Any:
        return (within.get_overload if args in within.overloads else own_overload)(args)

    dispatcher.get_call_template, dispatcher.get_overload = template, overload


def _plain(kind: Any) -> Any:
    """Argument type with which one kernel calls another.

    Numba would compile it anew for each width of an integer and for each one written out in a call.
    """
    kind = types.unliteral(kind)
    narrow = getattr(kind, "signed", False) and kind.bitwidth < 64
    return types.int64 if narrow else kind


kernel = _compiled()

# For the few small kernels that planners call millions of times. A call costs about 100 ns, nearly
# all of it for counting references to the arrays of a table; inlined, they are counted once.
inlined = _compiled(forceinline=True)


class _Clock(event.Listener):
    """Listener that times Numba's events; nested events count once."""

    def __init__(self) -> None:
        self._depth = 0
        # The time spent before, and since when more is. Other threads read both at once.
        self._spent: tuple[float, float | None] = (0.0, None)

    def on_start(self, event: Any) -> None:
        """Note a beginning."""
        if self._depth == 0:
            self._spent = self._spent[0], time.perf_counter()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Note an end."""
        self._depth -= 1
        if self._depth == 0:
            self._spent = self.seconds(), None

    @property
    def is_running(self) -> bool:
        """Whether a timed event is under way."""
        return self._spent[1] is not None

    def seconds(self) -> float:
        """Time spent so far [s]."""
        spent, since = self._spent
        return spent if since is None else spent + time.perf_counter() - since


class _WithoutGarbage(event.Listener):
    """Listener that pauses garbage collection: a tenth of compile time, and it frees nothing."""

    def __init__(self) -> None:
        self._depth = 0
        self._collects = True

    def on_start(self, event: Any) -> None:
        """Pause garbage collection."""
        if self._depth == 0:
            self._collects = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Resume garbage collection."""
        self._depth -= 1
        if self._depth == 0 and self._collects:
            gc.enable()


# Kernels that are compiled, and those that are read, compiled or kept, which takes time as well.
_compiled_now, _made_now = _Clock(), _Clock()
for _listener in (_compiled_now, _WithoutGarbage()):
    event.register("numba:compile", _listener)
event.register("numba:compiler_lock", _made_now)
leave_out(_made_now.seconds)


def compiling_s() -> float:
    """Seconds that this process has spent compiling; 0 if all kernels were cached."""
    return _compiled_now.seconds()


def is_compiling() -> bool:
    """Whether this process is compiling a kernel."""
    return _compiled_now.is_running
