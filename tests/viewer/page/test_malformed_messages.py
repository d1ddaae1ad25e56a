"""Whatever a page sends, or does not read: the run stays as it is."""

import random
import socket
import threading
import time
from urllib.parse import urlsplit

import msgspec
import pytest
import viser
import websockets.exceptions

from bt_manip.behaviours import MoveHome, RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver
from bt_manip.viewer.page import server as page_server

FIELDS = {
    "ViewerCameraMessage": (
        "wxyz", "position", "fov", "near", "far", "image_height", "image_width", "look_at",
        "up_direction",
    ),
    "GuiUpdateMessage": ("uuid", "updates"),
    "GuiButtonHoldMessage": ("uuid", "frequency"),
    "GuiFormSubmitMessage": ("uuid",),
    "GuiFormDirtyMessage": ("uuid",),
    "CommandTriggerMessage": ("uuid",),
    "TransformControlsUpdateMessage": ("name", "wxyz", "position", "owner"),
    "TransformControlsDragStartMessage": ("name", "owner"),
    "SceneNodeClickMessage": (
        "name", "instance_index", "ray_origin", "ray_direction", "screen_pos", "modifier", "owner",
    ),
    "ScenePointerMessage": (
        "event_type", "ray_origin", "ray_direction", "screen_pos", "modifier",
    ),
    "FileTransferStartUpload": (
        "source_component_uuid", "transfer_uuid", "filename", "mime_type", "part_count",
        "size_bytes",
    ),
    "FileTransferPart": ("source_component_uuid", "transfer_uuid", "part_index", "content"),
    "GetRenderResponseMessage": ("payload", "render_uuid"),
    "ShareUrlRequest": (),
    "MeshMessage": ("name", "props"),
    "Message": (),
    "no such type": ("uuid",),
}  # fmt: skip

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.3, 0.0, 1.2),
    "fov": 1.0, "near": 0.1, "far": 9.0, "image_height": 9, "image_width": 9,
    "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip
"""The first message of a page; viser ignores what a page sends to inputs before it."""

PROPERTIES = ("removed", "update_cb", "props", "uuid", "label", "disabled", "sync_cb", "order")
"""Attributes of viser's state of an input that no page may set."""


def messages(number, uuids):
    """Give malformed messages of many kinds; `uuids` are of the inputs of the page."""
    rng = random.Random(1)
    encode = msgspec.msgpack.encode
    nested = b"\x91" * 100_000
    fixed = [b"", "text", b"\xc1", nested, b"\x81\xa4type" + nested, b"\xff" * 200_000, encode([]),
             encode({"type": 3}), encode({"type": "x" * 100_000}), encode({1: 2})]  # fmt: skip
    values = (0, -1, 10**18, 1.5, float("nan"), float("inf"), None, True, "", "x" * 20_000, b"x",
              [], [0] * 3, ["a"] * 4, [float("nan")] * 4, {}, {"value": None})  # fmt: skip
    for index in range(number):
        if index < len(fixed):
            yield fixed[index]
            continue
        kind = rng.choice(list(FIELDS))
        message = {name: rng.choice(values) for name in FIELDS[kind] if rng.random() < 0.95}
        if kind == "GuiUpdateMessage":
            message["uuid"] = rng.choice(uuids)
            message["updates"] = rng.choice(
                (
                    {rng.choice(PROPERTIES): rng.choice(values)},
                    {"value": rng.choice((None, [], {}, b"x", "no option" * 2000))},
                    {},
                    rng.choice(values),
                )
            )
        data = encode({"type": kind, **message})
        if rng.random() < 0.2:
            data = data[: rng.randrange(len(data))] + rng.randbytes(rng.randrange(20))
        yield data


def moving():
    return Sequence(
        SpawnObject(object="{cube}"), MoveHome(), Sleep(msec=500), RemoveObject(object="{cube}")
    )


def digest_of(make_run, *observers):
    recorder = Recorder("test", 0)
    make_run(moving()).execute([recorder, *observers])
    return recorder.report().state_digest


def attack(make_run, page, connect, messages):
    """Watch a run while messages arrive; return its digest, and how many were sent."""
    sent = []

    class Attack(RunObserver):
        """Sends messages while the run goes on."""

        def run_started(self, run):
            self.thread = threading.Thread(target=self.send)
            self.thread.start()

        def send(self):
            client = self.open()
            for message in messages:
                try:
                    client.connection.send(message)
                    client.connection.ping(ack_on_close=True).wait(5)  # until it has been read
                except websockets.exceptions.ConnectionClosed:
                    client = self.open()
                sent.append(message)

        def open(self):
            client = connect()
            client.connection.send(msgspec.msgpack.encode(CAMERA))
            return client

        def before_tick(self):
            time.sleep(0.02 if self.thread.is_alive() else 0.0)  # the run lasts as long

        def run_ended(self):
            self.thread.join()

    digest = digest_of(make_run, Attack(), page)
    return digest, len(sent)


@pytest.mark.parametrize("number", [1_000, pytest.param(10_000, marks=pytest.mark.soak)])
def test_malformed_messages_leave_the_run_and_the_page_as_they_are(
    make_run, page, connect, capfd, number
):
    inputs = {key: vars(one._impl).copy() for key, one in inputs_of(page).items()}
    digest, sent = attack(make_run, page, connect, messages(number, list(inputs)))
    assert sent == number
    for key, one in inputs_of(page).items():
        for name in ("value", "removed", "update_cb", "uuid"):
            assert getattr(one._impl, name) == inputs[key][name] or name == "value"
    assert len(page.server.gui._current_file_upload_states) == 0
    assert page.server._share_tunnel is None
    assert connect().read()
    assert digest == digest_of(make_run)
    assert capfd.readouterr().err == ""


def test_a_valid_message_that_is_sent_like_those_changes_the_run(make_run, page, connect):
    (stop,) = (key for key, one in inputs_of(page).items() if one._impl.props.label == "Stop")
    press = {"type": "GuiUpdateMessage", "uuid": stop, "updates": {"value": True}}
    digest, sent = attack(make_run, page, connect, [msgspec.msgpack.encode(press)])
    assert sent == 1 and page.stopped
    assert digest != digest_of(make_run)


def inputs_of(page):
    return dict(page.server.gui._gui_input_handle_from_uuid)


def test_a_message_that_is_too_large_closes_only_its_page(page, connect):
    large, other = connect(), connect()
    large.connection.send(b"x" * (page_server.LARGEST_MESSAGE + 1))
    with pytest.raises(websockets.exceptions.ConnectionClosed):
        while True:
            large.connection.recv(30)
    assert other.read()


def test_the_inputs_of_a_page_accept_only_values_that_they_offer(page):
    updates = {
        "Speed": ["1/2", "no speed", 1, None], "Search": ["arm", "x" * 20_000, 3],
    }  # fmt: skip
    for one in inputs_of(page).values():
        label = one._impl.props.label
        for index, value in enumerate(updates.get(label, ())):
            valid = page_server.is_valid_update(one._impl, {"value": value})
            assert valid == (index == 0), (label, value)


def test_a_page_that_stops_reading_is_disconnected(page, monkeypatch):
    monkeypatch.setattr(page_server, "STALLED", 0.5)
    address = urlsplit(page.url)
    with socket.create_connection((address.hostname, address.port), timeout=10) as client:
        lines = (
            "GET / HTTP/1.1", f"Host: {address.netloc}", "Upgrade: websocket",
            "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            f"Sec-WebSocket-Protocol: viser-v{viser.__version__}", "", "",
        )  # fmt: skip
        client.sendall("\r\n".join(lines).encode())
        assert client.recv(12) == b"HTTP/1.1 101"
        deadline = time.monotonic() + 60.0  # [s] of a hopeless wait, not of a passing test
        while not page_server.is_open(page.server):
            assert time.monotonic() < deadline
        while page_server.is_open(page.server):
            assert time.monotonic() < deadline
            page.server.gui.set_panel_label(random.randbytes(200_000).hex())
            time.sleep(0.02)
