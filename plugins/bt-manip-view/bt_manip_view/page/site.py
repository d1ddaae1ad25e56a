"""Files of the page and sockets of its browsers, on the server of the scene."""

import asyncio
import contextlib
import functools
import gzip
import http
from collections import deque
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import websockets.exceptions
from websockets import Headers
from websockets.http11 import Response

from .gui import Gui
from .viser_internals import client_html

PROTOCOL = "bt-manip"
"""Subprotocol of the page's sockets; the scene's sockets use that of viser."""

SCENE_PATH = "/scene"
"""Path of the scene, which the page frames."""

STATIC = Path(__file__).parent / "static"

FILES = {
    "/": "page.html", "/page.css": "page.css", "/page.js": "page.js", "/widgets.js": "widgets.js",
    "/tree.js": "tree.js", "/timeline.js": "timeline.js",
}  # fmt: skip
"""Files by path."""

TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}

PAGE_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page, which no other page may frame."""

FRAMED = "frame-ancestors 'self'"
"""Content security policy of the scene: only the page may frame it."""

LONGEST_QUEUE = 1 << 20
"""Pending bytes above which a browser gets the whole state instead."""


class Site:
    """Serves a `Gui` to browsers, in the thread of the server.

    For a browser that reads slowly, pending messages are replaced by one with the whole state.

    Args:
        gui: The elements of the page.

    Attributes:
        downloads: Makers of files by path: each returns the name and the content, or None, in a
            thread of its own.
    """

    def __init__(self, gui: Gui) -> None:
        self.gui = gui
        self.downloads: dict[str, Callable[[], tuple[str, bytes] | None]] = {}
        self._browsers: dict[Any, _Browser] = {}  # by connection

    @property
    def is_open(self) -> bool:
        """Whether any browser shows the page."""
        return bool(self._browsers)

    def publish(self) -> None:
        """Send the changes."""
        self._deliver(self.gui.flush())

    def close(self) -> None:
        """Close all connections."""
        for connection in list(self._browsers):
            connection.transport.abort()

    def response(self, path: str, compressed: bool) -> Response | Awaitable[Response]:
        """Return the response to a request.

        Args:
            path: The path, with or without a query.
            compressed: Whether the browser accepts gzip.
        """
        path = urlsplit(path).path
        if path in self.downloads:
            return asyncio.to_thread(_download, self.downloads[path])
        path = "/" if path == "/index.html" else path
        headers = Headers({"Cache-Control": "no-cache", "X-Content-Type-Options": "nosniff"})
        headers["Content-Security-Policy"] = FRAMED if path == SCENE_PATH else PAGE_POLICY
        if path == SCENE_PATH:
            name, data = "scene.html", _scene()
        elif (name := FILES.get(path, "")) != "":
            data = _packed((STATIC / name).read_bytes())
        else:
            return Response(http.HTTPStatus.NOT_FOUND, "Not Found", headers)
        body = data if compressed else gzip.decompress(data)
        headers["Content-Type"] = f"{TYPES[Path(name).suffix]}; charset=utf-8"
        headers["Content-Length"] = str(len(body))
        if compressed:
            headers["Content-Encoding"] = "gzip"
        return Response(http.HTTPStatus.OK, "OK", headers, body)

    async def serve(self, connection: Any) -> None:
        """Serve a browser until it disconnects."""
        browser = self._browsers[connection] = _Browser()
        sender = asyncio.create_task(self._send(connection, browser))
        try:
            while True:
                data = await connection.recv()
                self.gui.receive(data)
        except websockets.exceptions.ConnectionClosed:
            pass
        finally:
            del self._browsers[connection]
            sender.cancel()

    # Internal

    async def _send(self, connection: Any, browser: "_Browser") -> None:
        with contextlib.suppress(websockets.exceptions.ConnectionClosed, TimeoutError):
            while True:
                await browser.wake.wait()
                if browser.queue is None:
                    changes, data = self.gui.snapshot()
                    self._deliver(changes)
                    browser.queue, browser.size = deque(), 0
                else:
                    data = browser.queue.popleft()
                    browser.size -= len(data)
                if not browser.queue:
                    browser.wake.clear()
                await connection.send(data, text=True)

    def _deliver(self, data: bytes | None) -> None:
        if data is None:
            return
        for browser in self._browsers.values():
            if browser.queue is not None:
                browser.queue.append(data)
                browser.size += len(data)
                if browser.size > LONGEST_QUEUE:
                    browser.queue = None
            browser.wake.set()


def _download(make: Callable[[], tuple[str, bytes] | None]) -> Response:
    headers = Headers({"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"})
    if (made := make()) is None:
        return Response(http.HTTPStatus.NOT_FOUND, "Not Found", headers)
    name, body = made
    headers["Content-Type"] = "application/octet-stream"
    headers["Content-Disposition"] = f'attachment; filename="{name}"'
    headers["Content-Length"] = str(len(body))
    return Response(http.HTTPStatus.OK, "OK", headers, body)


class _Browser:
    """Messages pending for a browser; None: it needs the whole state."""

    def __init__(self) -> None:
        self.queue: deque[bytes] | None = None
        self.size = 0
        self.wake = asyncio.Event()
        self.wake.set()


def _packed(data: bytes) -> bytes:
    return gzip.compress(data, 5, mtime=0)


@functools.cache
def _scene() -> bytes:
    """Return viser's client without its panel, compressed."""
    return _packed(client_html().encode())
