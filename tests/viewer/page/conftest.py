"""Clients of the page's sockets, in place of a browser."""

import itertools
import json
import struct
import time
from collections import deque
from collections.abc import Callable, Collection, Iterator
from typing import Any

import msgspec
import pytest

viser = pytest.importorskip("viser", reason="the extra [view] is not installed")

import websockets.sync.client  # noqa: E402
import zstandard  # noqa: E402

from bt_manip.viewer import Page  # noqa: E402

PROTOCOLS = {"scene": f"viser-v{viser.__version__}", "page": "bt-manip"}


class Client:
    """A browser that shows the scene, or the page around it.

    Attributes:
        elements: Of a page: the properties of the elements by uid, with ``kind`` and ``parent``.
    """

    def __init__(
        self, url: str, what: str = "scene", received: Collection[Any] = (), **headers: str
    ) -> None:
        self._received, self._numbers = received, itertools.count()
        self.connection = websockets.sync.client.connect(
            url.replace("http:", "ws:") + f"/{what}",
            subprotocols=[PROTOCOLS[what]],
            additional_headers=headers,
            max_size=None,
            compression=None,
            max_queue=None,
        )
        self.elements: dict[int, dict[str, Any]] = {}

    def read(self, quiet: float = 0.5) -> list[dict[str, Any]]:
        """Return the messages of the scene until none comes for some time [s]."""
        messages: list[dict[str, Any]] = []
        try:
            while True:
                data = self.connection.recv(quiet)
                assert isinstance(data, bytes)
                _, size = struct.unpack("<QQ", data[:16])
                packed = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
                messages += msgspec.msgpack.decode(packed)["messages"]
        except TimeoutError:
            return messages

    def see(self, quiet: float = 0.5) -> "Client":
        """Apply the changes of the page until none comes for some time [s]."""
        try:
            while True:
                for change in json.loads(self.connection.recv(quiet)):
                    self._apply(*change)
        except TimeoutError:
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

    def send(self, uid: int, event: str, value: Any = None) -> None:
        """Use an element; return when the page has taken the message."""
        message = {"id": uid, "event": event, "value": value, "number": next(self._numbers)}
        self.connection.send(data := json.dumps(message))
        end = time.monotonic() + 5.0
        while data not in self._received and time.monotonic() < end:
            time.sleep(1e-3)

    def close(self) -> None:
        self.connection.close()


@pytest.fixture
def page(parts) -> Iterator[Page]:
    panels = {name: parts.panels.get(name) for name in parts.panels.in_order()}
    page = Page(panels, port=0, speed=None)
    yield page
    page.close()


@pytest.fixture
def connect(page) -> Iterator[Callable[..., Client]]:
    clients: list[Client] = []
    received: deque[Any] = deque(maxlen=100)
    receive = page.gui.receive

    def note(data: Any) -> bool:
        try:
            return receive(data)
        finally:
            received.append(data)

    page.gui.receive = note

    def open_client(what: str = "scene", **headers: str) -> Client:
        clients.append(Client(page.url, what, received, **headers))
        return clients[-1]

    yield open_client
    for client in clients:
        client.close()
