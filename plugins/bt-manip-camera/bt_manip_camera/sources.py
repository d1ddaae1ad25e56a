"""Frames from elsewhere than the simulation: of a server, or of a recorded sequence."""

import math
import socket
import struct
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.cell import CellError
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.runner import Run, RunModifier

from .camera import DepthCamera, depth_cameras

HEADER = struct.Struct("<4sHHdd")
"""Header of a message: `MAGIC`, width and height [pixels], focal length [pixels], age [s]."""

MAGIC = b"BTF1"

TIMEOUT = 1.0
"""Time within which a frame has to arrive [s]."""

MAX_DEPTH = 1000.0
"""Depths above it are refused [m]."""


class NetworkFrames:
    """Frames of a server, which sends one message to each client that connects.

    A message is `HEADER`, then the depths [m] as float32 and red, green and blue as uint8, the top
    row first, all little-endian. The age is the time since the exposure began. Frames that began
    before they were asked for are not used: so nobody has to synchronize clocks, and a camera that
    has stopped is noticed.

    Args:
        host: Address of the server.
        port: Its port.
        camera: The camera, whose size and angle of view the frames must have.
    """

    def __init__(self, host: str, port: int, camera: DepthCamera) -> None:
        self._address, self._camera = (host, port), camera

    def __call__(self) -> tuple[np.ndarray, np.ndarray]:
        """Return depth and colour of a frame that begins from now on.

        Raises:
            CellError: If none arrives within `TIMEOUT`, or it is not one of this camera.
        """
        host, port = self._address
        begin, why = time.monotonic(), ""
        try:
            while (left := begin + TIMEOUT - time.monotonic()) > 0.0:
                with socket.create_connection(self._address, left) as connection:
                    age, depth, colour = self._receive(connection, begin + TIMEOUT)
                if age <= time.monotonic() - begin:
                    return depth, colour
                why = f"the last one is {age:.1f} s old"
                time.sleep(0.01)
        except TimeoutError:
            why = why or f"none arrives within {TIMEOUT:g} s"
        except (OSError, ValueError) as error:
            why = str(error)
        raise CellError(f"frames of {host}:{port}: {why}")

    def _receive(
        self, connection: socket.socket, end: float
    ) -> tuple[float, np.ndarray, np.ndarray]:
        camera = self._camera
        magic, *size, focal_length, age = HEADER.unpack(_read(connection, HEADER.size, end))
        if magic != MAGIC:
            raise ValueError("this is no server of frames")
        if size != [camera.width, camera.height]:
            raise ValueError(
                f"they have {size[0]} x {size[1]} pixels, and the camera of the scene "
                f"{camera.width} x {camera.height}"
            )
        if not abs(focal_length / camera.focal_length - 1.0) < 0.01:
            raise ValueError(
                f"their focal length is {focal_length:.1f} pixels, and that of the camera of the "
                f"scene {camera.focal_length:.1f}"
            )
        if not 0.0 <= age < math.inf:
            raise ValueError(f"an age of {age} s")
        shape = camera.height, camera.width
        depth = np.frombuffer(_read(connection, 4 * math.prod(shape), end), "<f4").reshape(shape)
        colour = np.frombuffer(_read(connection, 3 * math.prod(shape), end), np.uint8)
        return age, *checked(depth, colour.reshape(*shape, 3), camera)


def _read(connection: socket.socket, size: int, end: float) -> bytearray:
    """Return bytes that arrive until a time of the monotonic clock [s]."""
    data, got = bytearray(size), 0
    while got < size:
        connection.settimeout(max(end - time.monotonic(), 1e-3))
        more = connection.recv_into(memoryview(data)[got:])
        if not more:
            raise ValueError(f"a message ends after {got} of {size} bytes")
        got += more
    return data


class RecordedFrames:
    """The frames of a folder one after the other: ``*.npz`` in the order of their names.

    Each has the arrays ``depth`` [m] and ``colour`` of a `Frame`.

    Args:
        folder: The folder.
        camera: The camera, whose size they must have.

    Raises:
        CellError: If there are none.
    """

    def __init__(self, folder: Path, camera: DepthCamera) -> None:
        self._folder, self._camera, self._paths = folder, camera, iter(sorted(folder.glob("*.npz")))
        if not any(folder.glob("*.npz")):
            raise CellError(f"{folder} has no recorded frames (*.npz)")

    def __call__(self) -> tuple[np.ndarray, np.ndarray]:
        """Return depth and colour of the next frame.

        Raises:
            CellError: If there is none, or it is not one of this camera.
        """
        path = next(self._paths, None)
        if path is None:
            raise CellError(f"{self._folder} has no further frame")
        try:
            with np.load(path, allow_pickle=False) as arrays:
                return checked(arrays["depth"], arrays["colour"], self._camera)
        except Exception as error:  # of whatever reads the file
            raise CellError(f"{path}: {error}") from error


def checked(depth: Any, colour: Any, camera: DepthCamera) -> tuple[np.ndarray, np.ndarray]:
    """Return depths as floats, and colours, that can be a frame of a camera.

    Raises:
        ValueError: If they cannot.
    """
    shape = camera.height, camera.width
    if depth.shape != shape or colour.shape != (*shape, 3):
        raise ValueError(f"images of {depth.shape} and {colour.shape}, not of {shape} pixels")
    if depth.dtype.kind != "f" or colour.dtype != np.uint8:
        raise ValueError(f"depths of {depth.dtype} and colours of {colour.dtype}")
    if not ((depth >= 0.0) & (depth <= MAX_DEPTH)).all():
        raise ValueError(f"depths are not from 0 (unknown) to {MAX_DEPTH:g} m")
    return depth.astype(float), colour


def connect(run: Run, texts: Sequence[str]) -> RunModifier:
    """Let cameras of a run get their frames from servers, which are asked for one, or folders.

    Args:
        run: The run.
        texts: For each ``NAME=PORT``, ``NAME=HOST:PORT`` or ``NAME=FOLDER``; by default, the host
            is this one.

    Raises:
        BtManipError: If there is no such camera, or there are no frames of it.
    """
    cameras = depth_cameras(run.station.cell.entities)
    for text in texts:
        name, _, where = text.partition("=")
        if name not in cameras:
            near = did_you_mean(name, cameras)
            raise BtManipError(f"--camera {text}: the scene has no depth_camera '{name}'{near}")
        camera, (host, _, port) = cameras[name], where.rpartition(":")
        if port.isdecimal() and 0 < int(port) < 2**16:
            camera.source = NetworkFrames(host or "127.0.0.1", int(port), camera)
            camera.source()
        elif where and Path(where).is_dir():
            camera.source = RecordedFrames(Path(where), camera)
        else:
            raise BtManipError(f"--camera wants NAME=[HOST:]PORT or NAME=FOLDER, got '{text}'")
    return RunModifier()
