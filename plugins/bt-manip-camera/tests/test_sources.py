"""Frames of servers and of recorded sequences; nothing is drawn."""

import contextlib
import re
import socket
import struct
import threading
import time
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.bt import NodeStatus
from bt_manip.cell import CellError, looking_at
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.runner import RunLoop, prepare, request_of
from bt_manip_camera import sources
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.sources import NetworkFrames, RecordedFrames, connect
from tests.support.program import DEVICES

from .test_segmentation import EYE, FOVY, HEIGHT, TARGET, WIDTH, cast

SMALL = SimpleNamespace(width=4, height=3, focal_length=5.0)
DEPTH, COLOUR = np.arange(12.0).reshape(3, 4), np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


def message(age=0.0, size=(4, 3), focal_length=5.0, depth=DEPTH, colour=COLOUR):
    """Return a message as the README describes it."""
    header = b"BTF1" + struct.pack("<HH", *size) + struct.pack("<dd", focal_length, age)
    return header + depth.astype("<f4").tobytes() + colour.tobytes()


@pytest.fixture
def serve():
    """Serve messages, each to one client, the last one to all others; give the port."""
    servers = []

    def start(messages, before=lambda: None):
        server = socket.create_server(("127.0.0.1", 0))
        servers.append(server)

        def answer():
            with contextlib.suppress(OSError):
                while True:
                    client, _ = server.accept()
                    with client:
                        before()
                        client.sendall(messages.pop(0) if len(messages) > 1 else messages[0])

        threading.Thread(target=answer, daemon=True).start()
        return server.getsockname()[1]

    yield start
    for server in servers:
        server.shutdown(socket.SHUT_RDWR)
        server.close()


def frames(port, camera=SMALL):
    return NetworkFrames("127.0.0.1", port, camera)


def test_a_frame_of_a_server_is_that_which_it_sends(serve):
    depth, colour = frames(serve([message(focal_length=4.96)]))()
    assert depth.tolist() == DEPTH.tolist() and depth.dtype == float
    assert colour.tolist() == COLOUR.tolist()


def test_a_frame_that_began_before_it_was_asked_for_is_not_used(serve):
    depth, _ = frames(serve([message(age=0.5), message(depth=DEPTH + 900.0)]))()
    assert depth[0, 0] == 900.0


@pytest.mark.parametrize(
    ("sent", "why"),
    [
        (message(size=(640, 480)), "640 x 480 pixels, and the camera of the scene 4 x 3"),
        (message(focal_length=4.94), "focal length is 4.9 pixels, and that .* 5.0"),
        (message(depth=DEPTH + 990.0), "depths are not from 0 .unknown. to 1000 m"),
        (message(focal_length=np.nan), "focal length is nan"),
        (message(depth=-DEPTH), "depths are not from 0 .unknown. to 1000 m"),
        (message(depth=DEPTH * np.nan), "depths are not from 0"),
        (message(age=-1.0), "an age of -1.0 s"),
        (message()[:60], "ends after 36 of 48 bytes"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "no server of frames"),
        (b"", "ends after 0 of 24 bytes"),
    ],
)
def test_what_is_no_frame_of_the_camera_is_refused(serve, sent, why):
    with pytest.raises(CellError, match=f"frames of 127.0.0.1:.*{why}"):
        frames(serve([sent]))()


def test_no_server_a_silent_one_and_one_that_has_stopped_are_told_apart(serve, monkeypatch):
    monkeypatch.setattr(sources, "TIMEOUT", 0.1)
    with socket.create_server(("127.0.0.1", 0)) as closed:
        port = closed.getsockname()[1]
    with pytest.raises(CellError, match="refused"):
        frames(port)()
    with pytest.raises(CellError, match=r"none arrives within 0\.1 s"):
        frames(serve([message()], before=lambda: time.sleep(0.3)))()
    with pytest.raises(CellError, match=r"the last one is 7\.0 s old"):
        frames(serve([message(age=7.0)]))()


def test_recorded_frames_come_in_the_order_of_their_names(tmp_path):
    for number in (2, 1):
        np.savez(tmp_path / f"{number}.npz", depth=DEPTH + number, colour=COLOUR)
    np.savez(tmp_path / "3.npz", depth=np.array([{}]), colour=COLOUR)  # pickled
    np.savez(tmp_path / "4.npz", depth=DEPTH, colour=COLOUR[:2])
    np.savez(tmp_path / "5.npz", depth=DEPTH.astype(int), colour=COLOUR)
    recorded = RecordedFrames(tmp_path, SMALL)
    assert [recorded()[0][0, 0] for _ in range(2)] == [1.0, 2.0]
    with pytest.raises(CellError, match=r"3\.npz: .*allow_pickle"):
        recorded()
    with pytest.raises(CellError, match=r"4\.npz: images of \(3, 4\) and \(2, 4, 3\)"):
        recorded()
    with pytest.raises(CellError, match=r"5\.npz: depths of int64 and colours of uint8"):
        recorded()
    with pytest.raises(CellError, match="no further frame"):
        recorded()


# A real arm: the fake one of the tests of bt-manip, in a process of its own.

T_WC = looking_at(EYE, TARGET)
SCENE = f"""
robots = [{{name = "arm", position = [-0.3, 0.0, 1.0]}}]
[[objects]]
model = "table"
height = 1.0
[[objects]]
model = "cube"
on = "table"
position = [0.1, 0.3]
size = 0.05
expected = true
[[objects]]
model = "depth_camera"
name = "above"
position = {T_WC.translation.tolist()}
rpy = {pin.rpy.matrixToRpy(T_WC.rotation).tolist()}
fovy = {FOVY}
width = {WIDTH}
height = {HEIGHT}
"""
TREE = """<root BTCPP_format="4"><BehaviorTree ID="Look"><EstimatePose object="cube"/>
</BehaviorTree></root>"""


@pytest.fixture
def prepare_real(tmp_path, monkeypatch):
    """Give a function that prepares a run of `TREE` with the fake arm, for a ``--camera``."""
    monkeypatch.syspath_prepend(str(DEVICES))
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(DEVICES))
    parts = load_plugins(warn=lambda text: None).parts
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "look.xml").write_text(TREE)
    with contextlib.ExitStack() as stack:

        def make(camera):
            run = prepare(request_of(
                str(tmp_path / "look.xml"), parts, scene=str(tmp_path / "scene.toml"), poses="seen",
                backend="fake=0.5", modifiers={"camera": [camera]},
            ), parts)  # fmt: skip
            stack.callback(run.station.hardware.close)
            return run

        yield make


def sent(frame, age=0.0):
    size = frame.depth.shape[::-1]
    return message(age, size, frame.focal_length, frame.depth, frame.colour)


def test_a_real_arm_knows_what_the_frames_of_a_server_show_and_not_what_is_old(
    serve, prepare_real, monkeypatch
):
    frame = cast(size=(0.05, 0.05, 0.05), at=(0.32, 0.03), yaw=0.4)
    messages = [sent(frame)]
    run = prepare_real(f"above={serve(messages)}")
    cell, ticks = run.station.cell, 0
    messages[:] = [sent(frame, age=3.0)]
    with monkeypatch.context() as patch, RunLoop(run) as loop:
        patch.setattr(sources, "TIMEOUT", 0.2)
        loop.begin()
        while loop.advance() is NodeStatus.RUNNING:
            ticks += 1
        assert "the last one is 3.0 s old" in run.tree.failure_reason()
    assert ticks > 2  # the loop goes on while a frame is awaited
    assert "cube" not in cell.entities
    messages[:] = [sent(frame)]
    with RunLoop(run) as loop:
        ended = loop.cycle()
    assert ended.succeeded, ended.reason
    assert np.abs(cell.pose("cube").translation - (0.32, 0.03, 1.025)).max() < 2e-3
    message = run.tree.nodes[-1].feedback_message
    said = re.fullmatch(r"'cube' at \((.*), (.*)\) m, within (.*) mm", message)
    x, y, error = map(float, said.groups())
    assert (x, y) == pytest.approx((0.32, 0.03), abs=2e-3) and 0.2 < error < 3.0


def test_what_cannot_be_a_source_is_refused_before_the_run(serve, tmp_path):
    cell = SimpleNamespace(entities={"eye": DepthCamera(width=40, height=30), "table": None})
    run = SimpleNamespace(station=SimpleNamespace(cell=cell))
    for text, why in {
        "ey=1": "no depth_camera 'ey'; did you mean 'eye'",
        "eye=": r"wants NAME=\[HOST:\]PORT or NAME=FOLDER, got 'eye='",
        "eye=127.0.0.1:99999": "wants NAME=",
        f"eye={tmp_path}": "no recorded frames",
        f"eye={serve([message()])}": "4 x 3 pixels, and the camera of the scene 40 x 30",
    }.items():
        with pytest.raises(BtManipError, match=why):
            connect(run, [text])
