"""Screening of ONNX files: only networks like those written by ``train`` may run.

ONNX Runtime allocates what a file asks for, and runs what it says for as long as it says. So a file
is judged before it is run: by its operators, by its tensors, and by the shapes of everything in
it, which are inferred without computing anything.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from adr_opt.common.errors import InputError, MissingExtra

OPSET = 17

OPERATORS = frozenset(
    {
        "Add",
        "Clip",
        "Concat",
        "Constant",
        "Div",
        "Gather",
        "Gemm",
        "Identity",
        "MatMul",
        "Max",
        "Mul",
        "ReduceMax",
        "ReduceSum",
        "Relu",
        "Squeeze",
        "Tanh",
        "Unsqueeze",
    }
)
"""Operators of supported networks; none of them loops or reads a file."""

MOST_NODES = 500
WIDEST = 4096
"""Maximum number of features of a state or a move, anywhere in the network."""

BATCH, ACTIONS = 4099, 4111
"""Numbers of states and moves in shape inference; prime, so that they are recognisable."""

FLOAT, INT64 = 1, 7
BYTES = {FLOAT: 4, INT64: 8}
"""Tensor types by ONNX number, with the size of an element."""

NUMBER, WHOLE, TENSOR, WHOLES = 1, 2, 4, 7
"""Attribute types by ONNX number; the others hold texts and graphs."""


def parsed(data: bytes, path: Any) -> Any:
    """The model in a file, not yet screened.

    Raises
    ------
    InputError
        Not an ONNX file.
    MissingExtra
        The package onnx is not installed.
    """
    try:
        import onnx
    except ImportError:
        raise MissingExtra("method 'ppo'", "onnx", "ppo") from None
    try:
        model = onnx.ModelProto.FromString(data)
    except Exception:  # DecodeError, of a package that onnx brings along
        model = onnx.ModelProto()
    if not model.graph.node:
        raise InputError(
            f"{path}: not a complete ONNX file, so not a policy; give a file that train wrote"
        )
    # Readers may differ in what they take fields for that they do not know.
    model.DiscardUnknownFields()
    return model


def check_graph(model: Any, path: Any, inputs: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse unsupported networks: a supported one is bounded by the numbers of states and moves.

    Parameters
    ----------
    model : onnx.ModelProto
    path : path
        Names the file in errors.
    inputs : mapping
        Name of an input → its shape for :data:`BATCH` states and :data:`ACTIONS` moves.

    Raises
    ------
    InputError
        Another operator, a tensor of another type or size, or a shape that grows with more than
        states, moves and :data:`WIDEST`.
    """
    foreign = _foreign(model, inputs)
    if foreign:
        raise InputError(f"{path}: {foreign}, so not a policy; give a file that train wrote")


def _foreign(model: Any, inputs: Mapping[str, tuple[int, ...]]) -> str:
    """Unsupported parts of a model; empty if there are none."""
    graph = model.graph
    if [(opset.domain, opset.version) for opset in model.opset_import] != [("", OPSET)]:
        return f"does not use the operator set {OPSET}"
    if model.functions or model.training_info or graph.sparse_initializer:
        return "holds more than a network"
    if len(graph.node) > MOST_NODES:
        return f"has {len(graph.node)} operators, more than {MOST_NODES}"
    tensors = list(graph.initializer)
    for node in graph.node:
        if node.op_type not in OPERATORS or node.domain:
            return f"uses an operator {node.op_type[:40]!r} that no policy has"
        for attribute in node.attribute:
            kinds = (NUMBER, WHOLE, WHOLES, TENSOR)
            if attribute.type not in kinds or attribute.ref_attr_name:
                return f"has an operator {node.op_type!r} with an attribute that no policy has"
            if attribute.type == TENSOR:
                tensors.append(attribute.t)
    for tensor in tensors:
        size, kind = math.prod(tensor.dims), tensor.data_type
        stored_outside = tensor.external_data or tensor.data_location
        if stored_outside or kind not in BYTES or len(tensor.raw_data) != BYTES[kind] * size:
            return "has a tensor that is not whole, or of a type that no policy has"
        if min(tensor.dims, default=1) < 1 or (kind == INT64 and size > 1):
            return "has a tensor of a shape that no policy has"
    return _foreign_shape(model, inputs)


def _foreign_shape(model: Any, inputs: Mapping[str, tuple[int, ...]]) -> str:
    from onnx import ModelProto, shape_inference

    if {entry.name for entry in model.graph.input} != inputs.keys():
        return f"does not take {' and '.join(inputs)}"
    if any(length > max(BATCH, ACTIONS, WIDEST) for shape in inputs.values() for length in shape):
        return "is for more targets than any policy"
    sized = ModelProto()
    sized.CopyFrom(model)
    # What the file says about shapes may be wrong.
    del sized.graph.value_info[:]
    for entry in (*sized.graph.input, *sized.graph.output):
        entry.type.tensor_type.elem_type = FLOAT
        entry.type.tensor_type.ClearField("shape")
    for entry in sized.graph.input:
        for length in inputs[entry.name]:
            entry.type.tensor_type.shape.dim.add().dim_value = length
    try:
        graph = shape_inference.infer_shapes(sized, check_type=True, strict_mode=True).graph
    except Exception as error:  # the package has no common class of its own for these
        return f"has operators that do not fit together ({type(error).__name__})"
    known = {}
    for entry in (*graph.value_info, *graph.output):
        known[entry.name] = [dim.dim_value for dim in entry.type.tensor_type.shape.dim]
    for node in graph.node:
        for name in node.output:
            rest = sorted(known.get(name, [0]))
            for length in (BATCH, ACTIONS):
                if length in rest:
                    rest.remove(length)
            if not 0 < math.prod(rest) <= WIDEST:
                return f"has an operator {node.op_type!r} of a size that no policy has"
    return ""
