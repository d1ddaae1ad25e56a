"""Policies in ONNX files."""

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.control import ControlError
from bt_manip.exceptions import did_you_mean, one_line, shown
from bt_manip.input_files import read_bytes

ACTION = "bt_manip.action"
"""Key of the metadata with the kind of the actions."""

RATE = "bt_manip.rate"
"""Key of the metadata with the number of actions per second [Hz]."""

MAX_TIME = 5.0
"""Longest wall time of one inference [s]: a file may contain an endless loop."""

_DTYPES = {"tensor(float)": np.float32, "tensor(double)": np.float64}


class PolicyError(ControlError):
    """A policy that cannot be read, does not fit the station, or returns no valid action."""


class OnnxPolicy:
    """A function from observations to actions, read from an ONNX file.

    Each input of the graph is the observation of that name; the only output is an action, or one
    action per row to execute in turn. A leading dimension of 1 may be added to all of them.
    Normalization is part of the graph. The file's metadata has the kind of the actions under
    `ACTION` and their rate under `RATE`.

    The graph runs on the CPU in one thread, so that the same observations give the same actions.

    Attributes:
        path: The file.
        action: Kind of the actions.
        rate: Number of actions per second [Hz].
        inputs: Shape of each observation; None is a dimension of any size.
    """

    def __init__(self, path: str | Path) -> None:
        """Read a file, which may come from anywhere: it can only compute, and reads no other file.

        Args:
            path: The file.

        Raises:
            PolicyError: If it cannot be read or is not a policy.
        """
        import onnxruntime as ort  # takes 0.3 s, by trees with a policy alone

        self._ort = ort
        self.path = Path(path)
        try:
            data = read_bytes(self.path)
        except OSError as error:
            raise self._error(f"cannot be read: {error.strerror}") from error
        try:
            self._session = ort.InferenceSession(
                data, _options(ort), providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime's errors have no other base class
            raise self._error(f"does not load: {one_line(error)}") from error
        metadata = self._session.get_modelmeta().custom_metadata_map
        self.action, self.rate = self._read_metadata(metadata)
        self.inputs: dict[str, tuple[int | None, ...]] = {}
        for given in self._session.get_inputs():
            if given.type not in _DTYPES:
                raise self._error(f"has the input '{given.name}' of {given.type}, expected floats")
            self.inputs[given.name] = tuple(n if isinstance(n, int) else None for n in given.shape)
        if not self.inputs or len(self._session.get_outputs()) != 1:
            raise self._error("expected inputs, and one output: the actions")
        self._dtypes = {one.name: _DTYPES[one.type] for one in self._session.get_inputs()}

    def check(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Check that it fits a station.

        Args:
            shapes: Shapes of the station's observations by name.

        Raises:
            PolicyError: If the policy expects others.
        """
        for name, expected in self.inputs.items():
            if name not in shapes:
                raise self._error(
                    f"expects the observation '{name}', which the station lacks"
                    + did_you_mean(name, shapes)
                )
            found = shapes[name]
            if not (_fits(found, expected) or _fits((1, *found), expected)):
                raise self._error(
                    f"expects the observation '{name}' of size {_shape_text(expected)}, the "
                    f"station's has {_shape_text(found)}"
                )

    def act(self, observations: Mapping[str, np.ndarray], size: int) -> np.ndarray:
        """Return the next actions.

        Args:
            observations: The present observations by name.
            size: Number of values of an action.

        Returns:
            One action per row.  # (n, size)

        Raises:
            PolicyError: If the graph fails, or its result is not finite or has another shape.
        """
        feeds = {}
        for name, shape in self.inputs.items():
            value = np.asarray(observations[name], dtype=self._dtypes[name])
            feeds[name] = value if value.ndim == len(shape) else value[None]
        options = self._ort.RunOptions()
        timer = threading.Timer(MAX_TIME, setattr, (options, "terminate", True))
        timer.start()
        try:
            (result,) = self._session.run(None, feeds, options)
        except Exception as error:
            raise self._error(f"failed: {one_line(error)}") from error
        finally:
            timer.cancel()
        actions = np.asarray(result, dtype=float)
        if actions.ndim == 3 and len(actions) == 1:
            actions = actions[0]
        if actions.ndim == 1:
            actions = actions[None]
        if actions.ndim != 2 or not len(actions) or actions.shape[1] != size:
            raise self._error(
                f"returned values of shape {_shape_text(np.shape(result))}, an action "
                f"'{self.action}' of this robot has {size}"
            )
        if not np.isfinite(actions).all():
            raise self._error(f"returned an action that is not finite: {actions.tolist()[0]}")
        return actions

    def _read_metadata(self, metadata: Mapping[str, str]) -> tuple[str, float]:
        for key in (ACTION, RATE):
            if key not in metadata:
                raise self._error(f"its metadata lack '{key}'; known: {', '.join(metadata)}")
        try:
            rate = float(metadata[RATE])
        except ValueError:
            rate = 0.0
        if not 0.0 < rate <= 1000.0:
            raise self._error(
                f"its metadata '{RATE}' must be a number above 0 and up to 1000 [Hz], "
                f"got {shown(metadata[RATE])}"
            )
        return metadata[ACTION], rate

    def _error(self, message: str) -> PolicyError:
        return PolicyError(f"policy '{self.path}' {message}")


def _options(ort: Any) -> Any:
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.use_deterministic_compute = True
    options.log_severity_level = 4  # errors are raised
    return options


def _fits(shape: tuple[int, ...], expected: tuple[int | None, ...]) -> bool:
    return len(shape) == len(expected) and all(
        e in (None, n) for n, e in zip(shape, expected, strict=True)
    )


def _shape_text(shape: tuple[int | None, ...]) -> str:
    return " x ".join("any" if n is None else str(n) for n in shape) or "none"
