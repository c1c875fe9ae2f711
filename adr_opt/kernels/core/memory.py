"""Three operations on memory that Numba cannot express in Python, or not briefly.

Kernels that step hundreds of missions read a cache line here and there from tables of gigabytes.
What they wait for is memory, not arithmetic, and two threads that count references to the same
arrays wait for each other.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .compile import inlined


def _lend(context, builder, kind, value):
    """An array, or a named tuple of arrays and others, without ownership."""
    if isinstance(kind, types.Array):
        view = context.make_array(kind)(context, builder, value)
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts: tuple[types.Type, ...] = tuple(kind)  # type: ignore[arg-type]
        for place, part in enumerate(parts):
            lent = _lend(context, builder, part, builder.extract_value(value, place))
            value = builder.insert_value(value, lent, place)
    return value


def _borrowed(_, array):
    """The same array, or named tuple of arrays, without ownership: accesses are not counted.

    Every look at an array of a named tuple that came as an argument counts a reference to it, which
    takes longer than most moves do. For arguments of a kernel and within it only: the caller holds
    the arrays for so long.
    """

    def generate(context, builder, signature, arguments):
        return _lend(context, builder, signature.args[0], arguments[0])

    return array(array), generate


def _fetch(_, array, indices):
    """Prefetch the cache line of an element; ``indices`` is a tuple.

    Indices outside the array are harmless: nothing is read.
    """

    def generate(context, builder, signature, arguments):
        kind = signature.args[0]
        view = context.make_array(kind)(context, builder, arguments[0])
        places = cgutils.unpack_tuple(builder, arguments[1], kind.ndim)
        word = view.strides.type.element
        places = [builder.zext(p, word) if p.type.width < word.width else p for p in places]
        strides = cgutils.unpack_tuple(builder, view.strides, kind.ndim)
        place = ir.Constant(word, 0)
        for index, stride in zip(places, strides, strict=True):
            place = builder.add(place, builder.mul(index, stride))
        byte = ir.IntType(8).as_pointer()
        address = builder.gep(builder.bitcast(view.data, byte), [place])
        flag = ir.IntType(32)
        ask = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(ir.VoidType(), [byte, flag, flag, flag]),
            "llvm.prefetch.p0i8",
        )
        # For reading, to be kept in all caches, data.
        builder.call(ask, [address, flag(0), flag(3), flag(1)])
        return context.get_dummy_value()

    return types.void(array, indices), generate


borrowed: Any = intrinsic(_borrowed)
fetch: Any = intrinsic(_fetch)


@inlined
def write(target, source):
    """Write an array to the beginning of another one, both with one axis.

    An assignment to a slice says the same, but brings code along that puts two shapes into a
    sentence, and compiling that takes longer than most kernels do.
    """
    for i in range(source.size):
        target[i] = source[i]
