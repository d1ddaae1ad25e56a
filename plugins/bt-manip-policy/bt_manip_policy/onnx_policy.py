"""Policies in ONNX files."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import onnxruntime as ort

from bt_manip.exceptions import BtManipError, one_line, shown
from bt_manip.files import read_bytes
from bt_manip.parameters import Parameter

ACTION, RATE = "bt_manip.action", "bt_manip.rate"
"""Keys of the metadata that must be there: kind of the actions, and actions per second."""

NUMBERS = {
    RATE: Parameter(unit="Hz", type=float, above=0.0, at_most=1000.0),
    "bt_manip.history": Parameter(default=1, at_least=1, at_most=64),
    "bt_manip.execute": Parameter(default=0, at_least=0, at_most=1_000_000),
    "bt_manip.ensemble": Parameter(default=None, type=float, at_least=0.0, at_most=1000.0),
}
"""Numbers in the metadata, by key; `OnnxPolicy` has their meanings."""

STATE, NEXT_STATE = "state_", "next_state_"
"""Prefixes of the names of recurrent states in inputs and outputs."""

_DTYPES = {"tensor(float)": np.float32, "tensor(double)": np.float64, "tensor(uint8)": np.uint8}

Shape = tuple[int | None, ...]


class OnnxPolicy:
    """A function from observations to actions, read from an ONNX file.

    Each input of the graph is the observation of that name; the output is an action, or one action
    per row to execute in turn. All may have an additional leading dimension of 1. An input
    ``state_NAME`` is zero at first, then the last output ``next_state_NAME``. Normalization is part
    of the graph. The file's metadata have the kind of the actions under `ACTION`, and `NUMBERS`.

    The graph runs on the CPU in one thread, so that the same observations give the same actions.
    A `PolicyProcess` limits its time and memory; it accepts any class with these attributes.

    Args:
        path: The file; it is untrusted, but can only compute and read no other file.

    Attributes:
        action: Kind of the actions.
        rate: Number of actions per second [Hz].
        inputs: Shape of each observation; None for a dimension of any size.
        states: Shape of each recurrent state, by the name of its input.
        history: Number of successive observations in an input, the present one last; if more than
            one, it is the size of the first dimension of each input.
        execute: Number of executed rows of an output before the next observation; 0: all.
        ensemble: Decay of temporal ensembling, with a new action in each step; None without it.

    Raises:
        BtManipError: If it cannot be read or is not a policy.
    """

    def __init__(self, path: str) -> None:
        try:
            data = read_bytes(path)
        except OSError as error:
            raise BtManipError(f"cannot be read: {error.strerror}") from error
        try:
            self._session = ort.InferenceSession(
                data, _options(), providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime's errors have no other base class
            raise BtManipError(f"does not load: {one_line(error)}") from error
        metadata = self._session.get_modelmeta().custom_metadata_map
        if missing := [key for key in (ACTION, RATE) if key not in metadata]:
            raise BtManipError(f"its metadata lack '{missing[0]}'; known: {', '.join(metadata)}")
        self.action = metadata[ACTION]
        numbers = (_number(metadata, key) for key in NUMBERS)
        self.rate, self.history, self.execute, self.ensemble = numbers
        given = {tensor.name: tensor for tensor in self._session.get_inputs()}
        for name, tensor in given.items():
            if tensor.type not in _DTYPES:
                raise BtManipError(
                    f"has the input {shown(name)} of {tensor.type}, expected floats or bytes"
                )
        self._dtypes = {name: _DTYPES[tensor.type] for name, tensor in given.items()}
        shapes = {name: _shape(tensor.shape) for name, tensor in given.items()}
        self._outputs = [tensor.name for tensor in self._session.get_outputs()]
        self.states = _states(shapes, self._outputs)
        self.inputs = {name: shape for name, shape in shapes.items() if name not in self.states}
        actions = [tensor for tensor in self._outputs if not tensor.startswith(NEXT_STATE)]
        if not self.inputs or len(actions) != 1:
            raise BtManipError("expected inputs, and one output: the actions")

    def act(
        self, observations: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the actions, one or one per row, and the next states.

        Args:
            observations: The present observations and states by name.
        """
        feeds = {}
        for name, shape in (self.inputs | self.states).items():
            value = np.asarray(observations[name], dtype=self._dtypes[name])
            feeds[name] = value if value.ndim == len(shape) else value[None]
        results = dict(zip(self._outputs, self._session.run(None, feeds), strict=True))
        states = {name: results.pop(NEXT_STATE + name.removeprefix(STATE)) for name in self.states}
        (actions,) = results.values()
        return np.asarray(actions), states


def _shape(shape: Sequence[Any]) -> Shape:
    return tuple(n if isinstance(n, int) else None for n in shape)


def _states(inputs: Mapping[str, Shape], outputs: Sequence[str]) -> dict[str, Shape]:
    """Return the shapes of the recurrent states."""
    found = {}
    for output in outputs:
        if output.startswith(NEXT_STATE):
            name = STATE + output.removeprefix(NEXT_STATE)
            if name not in inputs:
                raise BtManipError(f"has the output {shown(output)}, but no input {shown(name)}")
            if None in inputs[name]:
                raise BtManipError(f"has the state {shown(name)} of any size, expected a fixed one")
            found[name] = inputs[name]
    return found


def _number(metadata: Mapping[str, str], key: str) -> Any:
    if key not in metadata:
        return NUMBERS[key].default
    try:
        return NUMBERS[key].read(metadata[key])
    except ValueError as error:
        raise BtManipError(f"its metadata '{key}' {error}") from None


def _options() -> ort.SessionOptions:
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.use_deterministic_compute = True
    options.log_severity_level = 4  # errors are raised
    return options
