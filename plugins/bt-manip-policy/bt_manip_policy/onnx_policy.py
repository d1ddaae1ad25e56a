"""Policies in ONNX files."""

from collections.abc import Mapping

import numpy as np
import onnxruntime as ort

from bt_manip.exceptions import BtManipError, one_line, shown
from bt_manip.input_files import read_bytes

ACTION = "bt_manip.action"
"""Key of the metadata with the kind of the actions."""

RATE = "bt_manip.rate"
"""Key of the metadata with the number of actions per second [Hz]."""

_DTYPES = {"tensor(float)": np.float32, "tensor(double)": np.float64}


class OnnxPolicy:
    """A function from observations to actions, read from an ONNX file.

    Each input of the graph is the observation of that name; the only output is an action, or one
    action per row to execute in turn. A leading dimension of 1 may be added to all of them.
    Normalization is part of the graph. The file's metadata has the kind of the actions under
    `ACTION` and their rate under `RATE`.

    The graph runs on the CPU in one thread, so that the same observations give the same actions.
    A `PolicyProcess` bounds its time and memory; it takes any class with these attributes.

    Attributes:
        action: Kind of the actions.
        rate: Number of actions per second [Hz].
        inputs: Shape of each observation; None is a dimension of any size.
    """

    def __init__(self, path: str) -> None:
        """Read a file, which may come from anywhere: it can only compute, and reads no other file.

        Args:
            path: The file.

        Raises:
            BtManipError: If it cannot be read or is not a policy.
        """
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
        self.action, self.rate = _read_metadata(metadata)
        self.inputs: dict[str, tuple[int | None, ...]] = {}
        for given in self._session.get_inputs():
            if given.type not in _DTYPES:
                raise BtManipError(f"has the input '{given.name}' of {given.type}, expected floats")
            self.inputs[given.name] = tuple(n if isinstance(n, int) else None for n in given.shape)
        if not self.inputs or len(self._session.get_outputs()) != 1:
            raise BtManipError("expected inputs, and one output: the actions")
        self._dtypes = {one.name: _DTYPES[one.type] for one in self._session.get_inputs()}

    def act(self, observations: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the output of the graph: an action, or one per row.

        Args:
            observations: The present observations by name.
        """
        feeds = {}
        for name, shape in self.inputs.items():
            value = np.asarray(observations[name], dtype=self._dtypes[name])
            feeds[name] = value if value.ndim == len(shape) else value[None]
        (result,) = self._session.run(None, feeds)
        return np.asarray(result)


def _read_metadata(metadata: Mapping[str, str]) -> tuple[str, float]:
    for key in (ACTION, RATE):
        if key not in metadata:
            raise BtManipError(f"its metadata lack '{key}'; known: {', '.join(metadata)}")
    try:
        rate = float(metadata[RATE])
    except ValueError:
        rate = 0.0
    if not 0.0 < rate <= 1000.0:
        raise BtManipError(
            f"its metadata '{RATE}' must be a number above 0 and up to 1000 [Hz], "
            f"got {shown(metadata[RATE])}"
        )
    return metadata[ACTION], rate


def _options() -> ort.SessionOptions:
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.use_deterministic_compute = True
    options.log_severity_level = 4  # errors are raised
    return options
