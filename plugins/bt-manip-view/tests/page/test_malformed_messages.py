"""Whatever a page sends, or does not read: the run stays as it is."""

import gc
import json
import random
import socket
import threading
import time
import tracemalloc
from urllib.parse import urlsplit

import msgspec
import numpy as np
import pytest
import websockets.exceptions

from bt_manip.behaviours import MoveHome, RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver
from bt_manip_view.page import server as page_server
from bt_manip_view.page.gui import Gui
from bt_manip_view.page.viser_internals import viser_messages

from .conftest import CAMERA, PROTOCOLS, wait_until

KINDS = (
    "ViewerCameraMessage", "GuiUpdateMessage", "GuiButtonHoldMessage", "GuiFormSubmitMessage",
    "GuiFormDirtyMessage", "CommandTriggerMessage", "TransformControlsUpdateMessage",
    "TransformControlsDragStartMessage", "SceneNodeClickMessage", "ScenePointerMessage",
    "FileTransferStartUpload", "FileTransferPart", "GetRenderResponseMessage", "ShareUrlRequest",
    "MeshMessage", "Message", "no such type",
)  # fmt: skip
"""Types of messages of the scene."""

NESTED = b"\x91" * 100_000
VALUES = (0, -1, 10**18, 1.5, float("nan"), float("inf"), None, True, "", "x" * 20_000, [], [0] * 3,
          ["a"] * 4, {}, {"value": None})  # fmt: skip


def scene_messages(number):
    """Give malformed messages of many kinds for the scene."""
    rng = random.Random(1)
    encode = msgspec.msgpack.encode
    fixed = [b"", "text", b"\xc1", NESTED, b"\x81\xa4type" + NESTED, b"\xff" * 200_000, encode([]),
             encode({"type": 3}), encode({"type": "x" * 100_000}), encode({1: 2})]  # fmt: skip
    yield from fixed
    for _ in range(number - len(fixed)):
        kind = rng.choice(KINDS)
        fields = getattr(getattr(viser_messages, kind, None), "__dataclass_fields__", ("uuid",))
        values = (*VALUES, b"x", [float("nan")] * 4)
        message = {name: rng.choice(values) for name in fields if rng.random() < 0.95}
        data = encode({"type": kind, **message})
        if rng.random() < 0.2:
            data = data[: rng.randrange(len(data))] + rng.randbytes(rng.randrange(20))
        yield data


def page_messages(number, elements):
    """Give malformed messages for the elements of the page, and values that they do not offer."""
    rng = random.Random(2)
    fixed = [b"", "", "null", "[]", "3", '"text"', b"\xff" * 200_000, "[" * 100_000,
             '{"id":' * 20_000, '{"id": 1}', '{"event": "click"}', "{" * 1000]  # fmt: skip
    # What they offer is chosen by valid messages, which are left out here.
    events = ("value", "click", "breakpoint", "seek", "", "set", "no event")
    yield from fixed
    for _ in range(number - len(fixed)):
        element = rng.choice([*elements])
        value = rng.choice(VALUES)
        event = rng.choice(events)
        if Gui().add(**elements[element]).accepts(value) or value is None or event == "seek":
            value = {"not": ["offered"]}
        uid = rng.choice((element, element, element, *VALUES))
        text = json.dumps({"id": uid, "event": rng.choice((event, event, *VALUES)), "value": value})
        yield text[: rng.randrange(len(text))] if rng.random() < 0.2 else text


def digest_of(make_run, *observers):
    recorder = Recorder("test", 0)
    root = Sequence(
        SpawnObject(object="{cube}"), MoveHome(), Sleep(msec=500), RemoveObject(object="{cube}")
    )
    make_run(root).execute([recorder, *observers])
    return recorder.report().state_digest


def attack(make_run, page, connect, messages, what):
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
            client = connect(what)
            if what == "scene":
                client.connection.send(msgspec.msgpack.encode(CAMERA))
            return client

        def before_tick(self):
            time.sleep(0.02 if self.thread.is_alive() else 0.0)  # the run lasts as long

        def run_ended(self):
            self.thread.join()

    digest = digest_of(make_run, Attack(), page)
    return digest, len(sent)


@pytest.mark.parametrize("number", [250, pytest.param(10_000, marks=pytest.mark.soak)])
@pytest.mark.parametrize("what", ["scene", "page"])
def test_malformed_messages_leave_the_run_and_the_page_as_they_are(
    make_run, page, connect, capfd, number, what
):
    before, scene = values_of(connect), connect()
    elements = connect("page").see().elements
    messages = scene_messages(number) if what == "scene" else page_messages(number, elements)
    digest, sent = attack(make_run, page, connect, messages, what)
    assert sent == number
    assert values_of(connect) == before and not page.controls.breakpoints and not page.stopped
    answers = [message["type"] for message in scene.read()]
    assert not [kind for kind in answers if kind.startswith(("ShareUrl", "FileTransfer"))]
    assert connect().read() and connect("page").see().elements
    assert digest == digest_of(make_run)
    assert capfd.readouterr().err == ""


def values_of(connect):
    elements = connect("page").see().elements.values()
    return {one["label"]: one["value"] for one in elements if "value" in one}


def test_a_valid_message_that_is_sent_like_those_changes_the_run(make_run, page, connect):
    stop = connect("page").see().uid("button", "Stop")
    press = json.dumps({"id": stop, "event": "click", "value": None})
    digest, sent = attack(make_run, page, connect, [press], "page")
    assert sent == 1 and page.stopped
    assert digest != digest_of(make_run)


def test_a_message_that_is_too_large_closes_only_its_page(page, connect):
    large, other = connect("page"), connect()
    large.connection.send(b"x" * (page_server.LARGEST_MESSAGE + 1))
    with pytest.raises(websockets.exceptions.ConnectionClosed):
        while True:
            large.connection.recv(30)
    assert other.read()


def test_the_inputs_of_a_page_accept_only_values_that_they_offer():
    gui = Gui()
    offers = {
        gui.add_dropdown("Speed", ("1/2", "1")): ["1/2", "no speed", 1, None],
        gui.add_text("Name", ""): ["arm", "x" * 20_000, 3],
        gui.add_slider("q", -1.0, 1.0, 0.1, 0.0): [0.5, 1.5, "0.5", True, float("nan"), [0.5]],
        gui.add_number("Seed", 0, low=0): [7, -1, "7", float("inf")],
        gui.add_checkbox("Shown", True): [False, 0, "no"],
        gui.add_html(""): [],
    }  # fmt: skip
    for one, values in offers.items():
        taken = [
            gui.receive(json.dumps({"id": one.uid, "event": "value", "value": v})) for v in values
        ]
        assert taken == [index == 0 for index in range(len(values))], one.kind
        one.disabled = True
        assert not gui.receive(json.dumps({"id": one.uid, "event": "value", "value": values[:1]}))


@pytest.fixture(params=PROTOCOLS.values())
def unread(page, request):
    """Open the page, and the scene, by a socket that nobody reads."""
    address = urlsplit(page.url)
    with socket.create_connection((address.hostname, address.port), timeout=10) as client:
        lines = (
            "GET / HTTP/1.1", f"Host: {address.netloc}", "Upgrade: websocket",
            "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            f"Sec-WebSocket-Protocol: {request.param}", "", "",
        )  # fmt: skip
        client.sendall("\r\n".join(lines).encode())
        assert client.recv(12) == b"HTTP/1.1 101"
        wait_until(lambda: page.is_open)
        yield client


def send_much(page, text):
    """Send 200 kB to the page, and to the scene."""
    text.content = random.randbytes(100_000).hex()
    page.server.gui.set_panel_label(text.content)
    page.server.get_event_loop().call_soon_threadsafe(page.site.publish)
    time.sleep(0.02)


def test_a_page_that_stops_reading_is_disconnected(page, unread, monkeypatch):
    monkeypatch.setattr(page_server, "STALLED", 0.5)
    text = page.gui.add_html("")

    def is_closed():
        send_much(page, text)
        return not page.is_open

    wait_until(is_closed)


@pytest.mark.soak
def test_a_page_that_does_not_read_keeps_memory_flat(make_run, page, unread, monkeypatch):
    monkeypatch.setattr(page_server, "STALLED", 1000.0)
    text, sizes = page.gui.add_html(""), []

    class Memory(RunObserver):
        """Measures memory after each cycle, in which 2.4 MB are sent."""

        def after_tick(self):
            send_much(page, text)

        def cycle_ended(self, status, reason):
            gc.collect()
            sizes.append(tracemalloc.get_traced_memory()[0])

    root = Sequence(SpawnObject(object="{cube}"), Sleep(msec=100), RemoveObject(object="{cube}"))
    tracemalloc.start()
    try:
        make_run(root, cycles=40).execute([page, Memory()])
    finally:
        tracemalloc.stop()
    assert np.median(sizes[-3:]) - np.median(sizes[25:28]) < 2e6  # sockets buffer less than 60 MB
