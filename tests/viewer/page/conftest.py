"""A client of the page's messages, in place of a browser."""

import struct
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest

viser = pytest.importorskip("viser", reason="the extra [view] is not installed")

import websockets.sync.client  # noqa: E402
import zstandard  # noqa: E402

from bt_manip.viewer import Page  # noqa: E402


class Client:
    """Reads what viser sends to a page."""

    def __init__(self, url: str, **headers: str) -> None:
        address = url.replace("http:", "ws:")
        self.connection = websockets.sync.client.connect(
            address,
            subprotocols=[f"viser-v{viser.__version__}"],
            additional_headers=headers,
            max_size=None,
            compression=None,
            max_queue=None,
        )

    def read(self, quiet: float = 0.5) -> list[dict[str, Any]]:
        """Return the messages until none comes for some time [s]."""
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

    def open_client(**headers: str) -> Client:
        clients.append(Client(page.url, **headers))
        return clients[-1]

    yield open_client
    for client in clients:
        client.close()
