"""Coefficients of Gauss's collocation with eight stages, to twice the precision of a float.

A coefficient that is rounded is wrong by the same amount in every step, so that energy drifts
instead of walking at random (E. Hairer, R. McLachlan and A. Razakarivony, BIT Numerical Mathematics
48, 2008, 231). So each is a float and the float that it is short of. They are computed in decimal
numbers, because the linear algebra of NumPy rounds differently on different processors.
"""

from collections.abc import Sequence
from decimal import Decimal, localcontext

import numpy as np
import numpy.typing as npt

STAGES = 8

DIGITS = 40
"""Decimal digits used for the coefficients: two floats hold 32."""


def _split(
    numbers: Sequence[Sequence[Decimal]],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The nearest floats, and the floats nearest to the remainders."""
    near = np.array([[float(number) for number in row] for row in numbers])
    short = [
        [float(number - Decimal(there)) for number, there in zip(row, line, strict=True)]
        for row, line in zip(numbers, near.tolist(), strict=True)
    ]
    return near, np.array(short)


def _legendre(x: Decimal) -> tuple[Decimal, Decimal]:
    """Legendre's polynomial of degree STAGES, and its derivative."""
    before, value = Decimal(1), x
    for n in range(1, STAGES):
        before, value = value, ((2 * n + 1) * x * value - n * before) / (n + 1)
    return value, STAGES * (x * value - before) / (x * x - 1)


def _lagrange(nodes: Sequence[Decimal], point: Decimal) -> list[Decimal]:
    """The Lagrange polynomials of some nodes at a point."""
    values = []
    for own in nodes:
        value = Decimal(1)
        for other in nodes:
            if other is not own:
                value *= (point - other) / (own - other)
        values.append(value)
    return values


def _product(first: Sequence[Sequence[Decimal]], second: Sequence[Sequence[Decimal]]):
    return [
        [
            sum(a * b for a, b in zip(row, column, strict=True))
            for column in zip(*second, strict=True)
        ]
        for row in first
    ]


def _collocation():
    """Nodes on [0, 1], weights, the matrix A, and polynomials at the nodes of the next step."""
    nodes, weights = [], []
    for start in np.polynomial.legendre.leggauss(STAGES)[0].tolist():
        x = Decimal(start)
        for _ in range(3):
            value, slope = _legendre(x)
            x -= value / slope
        nodes.append((x + 1) / 2)
        weights.append(1 / ((1 - x * x) * _legendre(x)[1] ** 2))
    a = []
    for node in nodes:
        inner = [_lagrange(nodes, node * other) for other in nodes]
        a.append([node * total for total in _product([weights], inner)[0]])
    return nodes, weights, a, [_lagrange(nodes, 1 + node) for node in nodes]


with localcontext() as _context:
    _context.prec = DIGITS
    _nodes, _weights, _a, _ahead = _collocation()
    NODES, NODES_SHORT = (each[0] for each in _split([_nodes]))
    WEIGHTS, WEIGHTS_SHORT = (each[0] for each in _split([_weights]))
    SQUARED, SQUARED_SHORT = _split(_product(_a, _a))
    SQUARED_WEIGHTS, SQUARED_WEIGHTS_SHORT = (each[0] for each in _split(_product([_weights], _a)))
    AHEAD = _split(_ahead)[0]
    BEFORE = _split(_a)[0]
