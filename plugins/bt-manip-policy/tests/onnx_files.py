"""Small ONNX files, encoded by hand: the fields and their numbers are those of onnx.proto."""

import numpy as np

FLOAT, UINT8, INT64, BOOL = 1, 2, 7, 9


def _varint(n):
    out = b""
    while n > 0x7F:
        out, n = out + bytes([n & 0x7F | 0x80]), n >> 7
    return out + bytes([n])


def message(*fields):
    """Encode pairs of number and value: an integer, a text, or an encoded message."""
    out = b""
    for number, value in fields:
        if isinstance(value, int):
            out += _varint(number << 3) + _varint(value)
        else:
            data = value.encode() if isinstance(value, str) else value
            out += _varint(number << 3 | 2) + _varint(len(data)) + data
    return out


def node(operator, inputs, outputs, *attributes, **integers):
    """Encode a node; integers: attributes by name."""
    names = [(1, name) for name in inputs] + [(2, name) for name in outputs]
    more = [message((1, name), (3, n), (20, 2)) for name, n in integers.items()]
    return message(*names, (4, operator), *((5, one) for one in (*attributes, *more)))


def tensor(name, values):
    """Encode an initializer."""
    array = np.asarray(values)
    kind = {"f": FLOAT, "i": INT64, "b": BOOL}[array.dtype.kind]
    array = array.astype(np.float32) if kind == FLOAT else array
    return message(*((1, n) for n in array.shape), (2, kind), (8, name), (9, array.tobytes()))


def value(name, shape, kind=FLOAT):
    """Encode the description of an input or output."""
    dims = [(1, message((2, n) if isinstance(n, str) else (1, n))) for n in shape]
    return message((1, name), (2, message((1, message((1, kind), (2, message(*dims)))))))


def graph(nodes, inputs, outputs, initializers=()):
    """Encode a graph."""
    return message(
        *((1, one) for one in nodes), (2, "graph"), *((5, one) for one in initializers),
        *((11, one) for one in inputs), *((12, one) for one in outputs),
    )  # fmt: skip


def model(encoded_graph, **metadata):
    """Encode a model."""
    entries = [message((1, f"bt_manip.{key}"), (2, text)) for key, text in metadata.items()]
    opset = message((1, ""), (2, 17))
    return message((1, 8), (7, encoded_graph), (8, opset), *((14, entry) for entry in entries))


def linear(offset, inputs, weights=None, **metadata):
    """Encode a policy: an offset plus weighted observations.

    Offset (n,) or rows of it; inputs: shapes by name; weights (size, n) by name, else zero.
    """
    offset = np.asarray(offset, dtype=float)
    nodes, initializers, total = [], [tensor("offset", offset)], "offset"
    for i, (name, shape) in enumerate(inputs.items(), 1):
        weight = (weights or {}).get(name, np.zeros((shape[-1], offset.shape[-1])))
        initializers.append(tensor(f"weight{i}", np.asarray(weight, dtype=float)))
        nodes.append(node("MatMul", [name, f"weight{i}"], [f"product{i}"]))
        before, total = total, "action" if i == len(inputs) else f"sum{i}"
        nodes.append(node("Add", [before, f"product{i}"], [total]))
    described = [value(name, shape) for name, shape in inputs.items()]
    out = [value("action", offset.shape)]
    metadata = {"action": "cartesian_deltas", "rate": "20", **metadata}
    return model(graph(nodes, described, out, initializers), **metadata)


def bright(camera, height, width):
    """Encode a policy that moves along x by a millionth of the mean of an image."""
    nodes = [
        node("Cast", [camera], ["floats"], to=FLOAT),
        node("ReduceMean", ["floats"], ["mean"], keepdims=0),
        node("Mul", ["mean", "along_x"], ["action"]),
    ]
    inputs, outputs = [value(camera, (height, width, 3), UINT8)], [value("action", (7,))]
    encoded = graph(nodes, inputs, outputs, [tensor("along_x", 1e-6 * np.eye(1, 7)[0])])
    return model(encoded, action="cartesian_deltas", rate="20")


def counting(output="next_state_n"):
    """Encode a policy that counts its calls, and returns their number as joint targets."""
    nodes = [
        node("Add", ["state_n", "one"], [output]),
        node("Add", ["robot_joint_positions", output], ["moved"]),
    ]
    inputs, outputs = [value("state_n", (7,))], [value(output, (7,))]
    return _joint_targets(nodes, tensor("one", np.ones(7)), inputs=inputs, outputs=outputs)


def endless(watched=None):
    """Encode a policy that computes without end, or as long as an observation (3,) is not zero."""
    body = graph(
        [node("Identity", ["go"], ["still"]), node("Identity", ["x"], ["y"])],
        [value("i", (), INT64), value("go", (), BOOL), value("x", (7,))],
        [value("still", (), BOOL), value("y", (7,))],
    )
    attribute = message((1, "body"), (6, body), (20, 5))
    loop = node("Loop", ["", "go", "robot_joint_positions"], ["moved"], attribute)
    if watched is None:
        return _joint_targets([loop], tensor("go", np.array(True)))
    seen = node("ReduceMax", [watched], ["most"], keepdims=0)
    nodes = [seen, node("Cast", ["most"], ["go"], to=BOOL), loop]
    return _joint_targets(nodes, inputs=[value(watched, (3,))])


def product(n, count=1):
    """Encode a small policy that adds products of matrices (n, n), which are constants."""
    nodes = [node("ConstantOfShape", ["shape"], ["product0"])]
    for i in range(count):
        nodes.append(node("MatMul", [f"product{i}", "product0"], [f"product{i + 1}"]))
    nodes.append(node("ReduceMax", [f"product{count}"], ["sum"], keepdims=0))
    nodes.append(node("Add", ["robot_joint_positions", "sum"], ["moved"]))
    return _joint_targets(nodes, tensor("shape", np.array([n, n])))


def _joint_targets(nodes, *initializers, inputs=(), outputs=()):
    """Encode a policy whose nodes compute "moved" from joint positions; its gripper closes."""
    nodes = [*nodes, node("Concat", ["moved", "gripper"], ["action"], axis=0)]
    inputs = [value("robot_joint_positions", (7,)), *inputs]
    outputs = [value("action", (8,)), *outputs]
    encoded = graph(nodes, inputs, outputs, [*initializers, tensor("gripper", np.ones(1))])
    return model(encoded, action="joint_targets", rate="20")
