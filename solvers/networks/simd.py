"""SIMD vectors of sixteen integers as values in kernels.

Loops over several arrays at once are not vectorised by the compiler, because it cannot know that
the arrays do not overlap. With these few operations a kernel says itself what happens sixteen
numbers at a time; on processors with narrower registers the compiler splits them.
Arrays are one-dimensional, contiguous int32; indices are not checked.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic as _untyped_intrinsic
from numba.extending import models, register_model

LANES = 16
intrinsic: Any = _untyped_intrinsic  # a kernel calls these with other arguments than are declared
_INT = ir.IntType(32)
_VECTOR = ir.VectorType(_INT, LANES)


class LanesType(types.Type):
    """Type of sixteen int32."""

    def __init__(self):
        super().__init__(name=f"Lanes({LANES} x int32)")


lanes_type = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _VECTOR)


def _pointer(context, builder, signature, values):
    array = context.make_array(signature.args[0])(context, builder, values[0])
    at = context.cast(builder, values[1], signature.args[1], types.intp)
    return builder.bitcast(builder.gep(array.data, [at]), _VECTOR.as_pointer())


@intrinsic
def load(typing, array, at):
    """The sixteen numbers ``array[at : at + 16]``."""

    def code(context, builder, signature, values):
        return builder.load(_pointer(context, builder, signature, values), align=4)

    return lanes_type(array, at), code


@intrinsic
def store(typing, array, at, lanes):
    """Write ``array[at : at + 16]``."""

    def code(context, builder, signature, values):
        builder.store(values[2], _pointer(context, builder, signature, values), align=4)
        return context.get_dummy_value()

    return types.void(array, at, lanes), code


@intrinsic
def spread(typing, number):
    """A number in all lanes."""

    def code(context, builder, signature, values):
        value = context.cast(builder, values[0], signature.args[0], types.int32)
        one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INT(0))
        zeros = ir.Constant(ir.VectorType(_INT, LANES), None)
        return builder.shuffle_vector(one, one, zeros)

    return lanes_type(number), code


@intrinsic
def count_up(typing):
    """The numbers 0 to 15 in the lanes."""

    def code(context, builder, signature, values):
        return ir.Constant(_VECTOR, list(range(LANES)))

    return lanes_type(), code


def _binary(build, doc):
    def typer(typing, a, b):
        def code(context, builder, signature, values):
            return build(builder, values[0], values[1])

        return lanes_type(a, b), code

    typer.__doc__ = doc
    return intrinsic(typer)


larger = _binary(
    lambda builder, a, b: builder.select(builder.icmp_signed(">", a, b), a, b),
    "The larger number of each lane.",
)
smaller = _binary(
    lambda builder, a, b: builder.select(builder.icmp_signed("<", a, b), a, b),
    "The smaller number of each lane.",
)
plus = _binary(lambda builder, a, b: builder.add(a, b), "Sums, lane by lane.")
both = _binary(lambda builder, a, b: builder.and_(a, b), "Bits set in both, lane by lane.")


@intrinsic
def where_equal(typing, a, b, then, otherwise):
    """``then`` in lanes where a = b, ``otherwise`` elsewhere."""

    def code(context, builder, signature, values):
        a, b, then, otherwise = values
        return builder.select(builder.icmp_signed("==", a, b), then, otherwise)

    return lanes_type(a, b, then, otherwise), code


@intrinsic
def where_less(typing, a, b, then, otherwise):
    """``then`` in lanes where a < b, ``otherwise`` elsewhere."""

    def code(context, builder, signature, values):
        a, b, then, otherwise = values
        return builder.select(builder.icmp_signed("<", a, b), then, otherwise)

    return lanes_type(a, b, then, otherwise), code


@intrinsic
def where_same(typing, a, b, bits, then):
    """``then`` in lanes where a and b agree in the given bits, ``b`` elsewhere."""

    def code(context, builder, signature, values):
        a, b, bits, then = values
        differing = builder.and_(builder.xor(a, b), bits)
        zero = ir.Constant(_VECTOR, [0] * LANES)
        return builder.select(builder.icmp_signed("==", differing, zero), then, b)

    return lanes_type(a, b, bits, then), code


def _mask(build, doc):
    def typer(typing, a, b):
        def code(context, builder, signature, values):
            bits = builder.bitcast(build(builder, values[0], values[1]), ir.IntType(LANES))
            return builder.zext(bits, ir.IntType(64))

        return types.int64(a, b), code

    typer.__doc__ = doc
    return intrinsic(typer)


at_least = _mask(
    lambda builder, a, b: builder.icmp_signed(">=", a, b),
    "The lanes where a ≥ b, as bits of a number.",
)
disjoint = _mask(
    lambda builder, a, b: builder.icmp_signed(
        "==", builder.and_(a, b), ir.Constant(_VECTOR, [0] * LANES)
    ),
    "The lanes where a and b have no bit in common, as bits of a number.",
)
covers = _mask(
    lambda builder, a, b: builder.icmp_signed("==", builder.and_(a, b), b),
    "The lanes where a has all bits of b, as bits of a number.",
)


@intrinsic
def lowest_bit(typing, number):
    """Position of the lowest bit that is set in a number, which is not 0."""

    def code(context, builder, signature, values):
        wide = context.cast(builder, values[0], signature.args[0], types.int64)
        return builder.cttz(wide, ir.Constant(ir.IntType(1), 1))

    return types.int64(number), code
