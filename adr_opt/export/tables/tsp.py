"""``.tsp``: an asymmetric travelling-salesman problem in TSPLIB 95 (TYPE ATSP, FULL_MATRIX).

G. Reinelt, TSPLIB 95, Universität Heidelberg.
"""

from __future__ import annotations

from pathlib import Path

from ...legs.matrices import Matrices
from ...problem.instance import Instance
from .weights import comment, edges, slug, whole_weights


def write(
    path: Path, instance: Instance, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure; COMMENT states the scale and the mark of no transfer."""
    weights = whole_weights(matrices, quantity, scale)
    lines = [
        f"NAME : {slug(instance)}",
        "TYPE : ATSP",
        f"COMMENT : {comment(instance, weights)}",
        f"DIMENSION : {len(matrices.names)}",
        *edges(weights),
        "EOF",
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
