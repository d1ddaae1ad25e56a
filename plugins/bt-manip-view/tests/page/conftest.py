"""Clients of the page's sockets, in place of a browser."""

import itertools
import json
import math
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import msgspec
import mujoco
import numpy as np
import pytest
import viser
import websockets.sync.client
import zstandard

from bt_manip_view import Page

PROTOCOLS = {"scene": f"viser-v{viser.__version__}", "page": "bt-manip"}

NO_ROTATION = (1.0, 0.0, 0.0, 0.0)

AT_ORIGIN = {"visible": True, "position": (0.0, 0.0, 0.0), "wxyz": NO_ROTATION}

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": NO_ROTATION, "position": (0.3, 0.0, 1.2), "fov": 1.0,
    "near": 0.1, "far": 9.0, "image_height": 9, "image_width": 9, "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip
"""The first message of a scene; viser ignores inputs before it."""


THING = """
<mujoco><worldbody>
  <body name="thing/"><freejoint/><geom type="box" size=".1 .1 .1" pos="0 0 1"/></body>
</worldbody></mujoco>"""


def box_called(name: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a model of a box that can move, and its state."""
    model = mujoco.MjModel.from_xml_string(THING.replace("thing", name))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30.0  # [s] of a hopeless wait, not of a passing test
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(2e-3)


class Client:
    """A browser that shows the page around the scene.

    Attributes:
        elements: Properties of the elements by uid, with ``kind`` and ``parent``.
    """

    what = "page"

    def __init__(self, page: Any, **headers: str) -> None:
        self.page, self._numbers, self._taken = page, itertools.count(1), threading.Event()
        self.elements: dict[int, dict[str, Any]] = {}
        self.connection = websockets.sync.client.connect(
            f"{page.url.replace('http:', 'ws:')}/{self.what}",
            subprotocols=[PROTOCOLS[self.what]],
            additional_headers=headers,
            max_size=None,
            compression=None,
            max_queue=None,
        )
        self._mark = page.gui.add("mark", number=0)
        self._mark.on("mark", lambda _: self._taken.set())

    def read(self) -> list[Any]:
        """Return the changes of the page since the last call."""
        self._mark.number = number = next(self._numbers)
        self.page.server.get_event_loop().call_soon_threadsafe(self.page.site.publish)
        changes: list[Any] = []
        while not any(
            change[1:2] == [self._mark.uid] and change[-1]["number"] == number for change in changes
        ):
            changes += json.loads(self.connection.recv(30))
        return changes

    def see(self) -> "Client":
        """Apply the changes of the page."""
        for change in self.read():
            self._apply(*change)
        return self

    def _apply(self, what: str, uid: int = 0, *rest: Any) -> None:
        if what == "reset":
            self.elements.clear()
        elif what == "add":
            parent, kind, props = rest
            self.elements[uid] = {"parent": parent, "kind": kind, **props}
        elif what == "remove":
            del self.elements[uid]
        elif what == "set":
            self.elements[uid] |= rest[0]
        elif what == "merge":
            self.elements[uid][rest[0]] |= rest[1]
        else:
            name, values, keep = rest
            self.elements[uid][name] = [*self.elements[uid][name], *values][-keep:]

    def find(self, kind: str, label: str | None = None) -> dict[str, Any]:
        """Return the properties of the element of a kind."""
        return self.elements[self.uid(kind, label)]

    def uid(self, kind: str, label: str | None = None) -> int:
        found = [
            uid
            for uid, one in self.elements.items()
            if one["kind"] == kind and label in (None, one.get("label"))
        ]
        assert len(found) == 1, (kind, label, found)
        return found[0]

    def text(self) -> str:
        """Return the texts of the page as HTML."""
        elements = self.see().elements.values()
        return "\n".join(one["content"] for one in elements if one["kind"] == "html")

    def send(self, uid: int, event: str, value: Any = None) -> None:
        """Use an element; return when the page has taken the message."""
        self._taken.clear()
        for message in (
            {"id": uid, "event": event, "value": value},
            {"id": self._mark.uid, "event": "mark"},
        ):
            self.connection.send(json.dumps(message))
        assert self._taken.wait(30)

    def press(self, label: str) -> None:
        """Press a button."""
        self.send(self.see().uid("button", label), "click")

    def toggle(self) -> None:
        """Press Pause, or Continue or Play where it is paused."""
        elements = self.see().elements.items()
        labels = ("Pause", "Continue", "Play")
        self.send(next(uid for uid, one in elements if one.get("label") in labels), "click")

    def set(self, kind: str, label: str, value: Any) -> None:
        """Change the value of an input."""
        self.send(self.see().uid(kind, label), "value", value)

    def close(self) -> None:
        self.connection.close()


class SceneClient(Client):
    """A browser that shows the scene.

    Attributes:
        nodes: Properties of the nodes by name, with ``position`` and ``visible``.
        camera: Where the page has put the camera: ``position``, ``look_at``, ``fov``.
    """

    what = "scene"

    def __init__(self, page: Any, **headers: str) -> None:
        super().__init__(page, **headers)
        self.nodes: dict[str, dict[str, Any]] = {}
        self.camera: dict[str, Any] = {}

    def read(self) -> list[Any]:
        """Return the messages of the scene since the last call."""
        mark = f"{id(self)} {next(self._numbers)}"
        self.page.server.gui.set_panel_label(mark)
        messages: list[Any] = []
        while not any(message.get("label") == mark for message in messages):
            data = self.connection.recv(30)
            assert isinstance(data, bytes)
            _, size = struct.unpack("<QQ", data[:16])
            packed = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
            window, end, arrays = msgspec.msgpack.decode(packed), 16 + size, []
            for length in window["binaryBufferLengths"]:
                start = end + -end % 8
                arrays.append(data[start : (end := start + length)])
            messages += _with_arrays(window["messages"], arrays)
        return messages

    def see(self) -> "SceneClient":
        """Apply the changes of the scene."""
        for message in self.read():
            name, node = message.get("name"), self.nodes.get(message.get("name"), {})
            if message.get("initial") is False:  # not where viser puts a new camera
                self.camera |= message
            elif message["type"] == "RemoveSceneNodeMessage":
                gone = [one for one in self.nodes if f"{one}/".startswith(f"{name}/")]
                for one in gone:
                    del self.nodes[one]
            elif "props" in message and name is not None:
                self.nodes[name] = {**AT_ORIGIN, **message["props"]}
            elif "updates" in message:
                node |= message["updates"]
            else:
                keys = "position", "wxyz", "visible"
                node |= {key: message[key] for key in keys if key in message}
        return self

    def segments(self, name: str) -> np.ndarray | None:
        """Return the ends of the lines of a node, if it is there."""  # (n, 2, 3)
        node = self.see().nodes.get(name)
        return None if node is None else node["points"].reshape(-1, 2, 3)

    def act(self, *messages: dict[str, Any]) -> None:
        """Send messages, with ``type``; return when the page has taken them."""
        position = (0.3, 0.0, next(self._numbers) + 0.5)
        mark = msgspec.msgpack.encode(CAMERA | {"position": position})
        for message in (CAMERA, *messages):
            self.connection.send(msgspec.msgpack.encode(message))
        clients, sent = self.page.server.get_clients, -math.inf

        def taken() -> bool:
            nonlocal sent
            if time.monotonic() > sent + 1.0:  # a page may place the camera of a new client later
                self.connection.send(mark)
                sent = time.monotonic()
            return any(tuple(one.camera.position) == position for one in clients().values())

        wait_until(taken)

    def drag(self, name: str, position: Any = None, *, start: bool = False) -> None:
        """Drag a handle to a position [m], or let it go where there is none."""
        node = {"name": name, "owner": ""}
        begin = [{"type": "TransformControlsDragStartMessage", **node}] if start else []
        if position is None:
            self.act({"type": "TransformControlsDragEndMessage", **node})
        else:
            pose = {"wxyz": self.nodes[name]["wxyz"], "position": tuple(map(float, position))}
            self.nodes[name] |= pose
            self.act(*begin, {"type": "TransformControlsUpdateMessage", **node, **pose})


def _with_arrays(value: Any, arrays: list[bytes]) -> Any:
    """Put arrays in their places."""
    if isinstance(value, list):
        return [_with_arrays(one, arrays) for one in value]
    if not isinstance(value, dict):
        return value
    if "__binary_index" in value:
        return np.frombuffer(arrays[value["__binary_index"]], value["dtype"])
    return {key: _with_arrays(one, arrays) for key, one in value.items()}


@pytest.fixture
def page(parts) -> Iterator[Page]:
    registered = parts.of("panels")
    panels = {name: registered.get(name) for name in registered.in_order()}
    page = Page(panels, port=0, speed=None)
    yield page
    page.close()


@pytest.fixture
def connect(page) -> Iterator[Callable[..., Any]]:
    """Give a function that opens the scene of the page, or the page around it."""
    with ExitStack() as stack:

        def open_client(what: str = "scene", **headers: str) -> Client:
            client = (SceneClient if what == "scene" else Client)(page, **headers)
            return stack.enter_context(closing(client))

        yield open_client


@pytest.fixture
def client(connect) -> Client:
    """Open the page."""
    client: Client = connect("page")
    return client


@pytest.fixture
def scene(connect) -> SceneClient:
    """Open the scene."""
    scene: SceneClient = connect()
    return scene
