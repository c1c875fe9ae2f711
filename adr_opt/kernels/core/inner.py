"""Inner kernels: intermediate code to be linked into callers, without machine code of its own.

Numba optimises each function and emits its machine code, and does both again in every caller.
A function that only kernels call needs neither: it is optimised in its callers.
"""

from typing import Any

from llvmlite import binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, compile_result


class _NoMachineCode:
    """Stand-in for the code generator, whose machine code holds the environments of functions."""

    @staticmethod
    def set_env(name: str, env: Any) -> None:
        """Do nothing: the variable is in the callers; see :class:`OuterCompiler`."""


class InnerLibrary(JITCodeLibrary):
    """Intermediate code of a function, to be linked into its callers."""

    is_inner = True

    @property
    def codegen(self) -> Any:
        """Receiver of environments; other methods use ``_codegen``."""
        return _NoMachineCode

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Address of the machine code: 0, there is none."""
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
