"""Kernels that only other kernels call: code to be linked into that of callers, and not run.

Numba optimises each function and emits its machine code, and does so again in all of its callers.
Functions that Python never calls need neither: they are optimised where they end up.
"""

from typing import Any

from llvmlite import binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, compile_result


class _NoMachineCode:
    """Takes the environments of functions, which are variables of their machine code."""

    @staticmethod
    def set_env(name: str, env: Any) -> None:
        """Do nothing: the caller's machine code has the variable; see :func:`set_environments`."""


class InnerLibrary(JITCodeLibrary):
    """The code of a function, to be linked into that of others."""

    @property
    def codegen(self) -> Any:
        """What environments are given to."""
        return _NoMachineCode

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Address of machine code: there is none."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """The code of callers is all that there is."""
        return (self.name, "inner", self._get_module_for_linking().as_bitcode())


class InnerCompiler(Compiler):
    """Numba's compiler, into an :class:`InnerLibrary`."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function."""
        self.state.library = InnerLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


def is_inner(compiled: Any) -> bool:
    """Whether a function has been compiled for other kernels only."""
    return isinstance(compiled.library, InnerLibrary)


def set_environments(compiled: Any) -> None:
    """Tell machine code of the environments of inner kernels that it holds."""
    if not is_inner(compiled):
        for env in compiled._find_referenced_environments():
            compiled.codegen.set_env(env.env_name, env)


def rebuilt(target: Any, parts: tuple[Any, ...]) -> Any:
    """A compiled function of the parts that ``_reduce`` takes it into.

    Parameters
    ----------
    target : numba.core.base.BaseContext
    parts : tuple
        Of an inner kernel or of another one.
    """
    (name, kind, code), description, env, signature, *rest = parts
    if kind != "inner":
        return CompileResult._rebuild(target, *parts)
    objectmode, lifted, annotation, reload_init, envs = rest
    for initialise in reload_init:
        initialise()
    library = InnerLibrary(target.codegen(), name)
    library._final_module = llvm.parse_bitcode(code)
    library._finalize_final_module()
    return compile_result(
        typing_context=target.typing_context, target_context=target,
        entry_point=target.get_executable(library, description, env),
        type_annotation=annotation, signature=signature, objectmode=objectmode, lifted=lifted,
        fndesc=description, library=library, environment=env, reload_init=reload_init,
        referenced_envs=envs,
    )  # fmt: skip
