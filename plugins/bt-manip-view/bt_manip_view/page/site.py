"""Files of the page and sockets of its browsers, on the server of the scene."""

import asyncio
import contextlib
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

FILES = {"/": STATIC / "page.html", **{f"/{file.name}": file for file in STATIC.iterdir()}}
"""Files by path."""

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}

PAGE_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page, which no other page may frame."""

SCENE_POLICY = "frame-ancestors 'self'"
"""Content security policy of the scene: only the page may frame it."""

LONGEST_QUEUE = 1 << 20
"""Pending bytes above which a browser gets the whole state instead."""


class Site:
    """Serves a `Gui` to browsers, in the thread of the server.

    For a browser that reads slowly, pending messages are replaced by one with the whole state.

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

    def response(self, path: str) -> Response | Awaitable[Response]:
        """Return the response to a request of a path, with or without a query."""
        path = urlsplit(path).path
        if path in self.downloads:
            return asyncio.to_thread(_download, self.downloads[path])
        if path == SCENE_PATH:
            return _response(client_html().encode(), TYPES[".html"], SCENE_POLICY)
        if path not in FILES:
            return _response(None, "text/plain", PAGE_POLICY)
        file = FILES[path]
        return _response(file.read_bytes(), TYPES[file.suffix], PAGE_POLICY)

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
    name, body = make() or ("", None)
    response = _response(body, "application/octet-stream", PAGE_POLICY)
    response.headers["Content-Disposition"] = f'attachment; filename="{name}"'
    return response


def _response(body: bytes | None, kind: str, policy: str) -> Response:
    """Return the response with a body of a media type; Not Found for None."""
    status = http.HTTPStatus.NOT_FOUND if body is None else http.HTTPStatus.OK
    headers = Headers({"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"})
    headers["Content-Security-Policy"], headers["Content-Type"] = policy, kind
    headers["Content-Length"] = str(len(body or b""))
    return Response(status, status.phrase, headers, body or b"")


class _Browser:
    """Messages pending for a browser; None: it needs the whole state."""

    def __init__(self) -> None:
        self.queue: deque[bytes] | None = None
        self.size = 0
        self.wake = asyncio.Event()
        self.wake.set()
