"""Web server of page and scene: loopback only, refuses other sites and invalid messages."""

import asyncio
import contextlib
import http
import io
import logging
import math
import socket
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import msgspec
import viser
import websockets.asyncio.server

from bt_manip.exceptions import BtManipError

from .gui import Gui
from .site import PROTOCOL, Site
from .viser_internals import SCENE_PROTOCOL, check_message, connections, ignore_unused_messages

HOST = "127.0.0.1"
"""The only address on which the page is served."""

PORT = 8080
"""The first port to try."""

LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""Accepted names in the header Host; with ``ssh -L`` the port differs."""

LARGEST_MESSAGE = 1 << 18
"""Size above which a browser's message closes its connection [bytes]; viser: 50 MB."""

REST = 5e-4
"""Pause after each message, so that a flood of messages does not starve the run [s]."""

LONGEST_ANSWER = 60.0
"""Time in which a request is answered, also for a recording that is written for it [s]."""

STALLED = 20.0
"""Time after which a browser that does not read is disconnected [s]."""

_serving = threading.Lock()


def open_server(port: int = PORT, site: Site | None = None) -> viser.ViserServer:
    """Start viser on loopback in its own thread.

    Connections whose Host is not this computer, or whose Origin is another site, are closed before
    anything is sent. Other pages cannot frame this one. Invalid messages are ignored.

    Args:
        port: The first port to try; 0: chosen by the system.
        site: The page around the scene; default: an empty one.

    Raises:
        BtManipError: If the computer lets no port be opened.
    """
    try:
        socket.create_server((HOST, 0)).close()
    except OSError as error:  # viser would wait for ever
        raise BtManipError(f"no page can be served on {HOST}: {error.strerror}") from error
    # viser prints a line, and websockets a traceback, for each unusable connection.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    # viser warns if a browser disconnects while its camera is being moved.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # viser prints its addresses.
    with (
        _serving,
        _checked_connections(site or Site(Gui())),
        contextlib.redirect_stdout(io.StringIO()),
    ):
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    ignore_unused_messages(server)
    # Valid messages that fail would print a traceback.
    server.get_event_loop().set_exception_handler(lambda loop, context: None)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without the line that viser prints."""
    for connection in list(connections(server)):  # a closing handshake takes seconds
        server.get_event_loop().call_soon_threadsafe(connection.transport.abort)
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def is_local(headers: Any) -> bool:
    """Return whether a request comes from a page of this server, or not from a page.

    A page of another site can reach the server by address, with its own Origin, or by a name that
    resolves to loopback, with that name as Host (DNS rebinding).
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or len(origins) > 1:
        return False
    try:
        if urlsplit(f"//{hosts[0]}").hostname not in LOCAL_NAMES:
            return False
        return not origins or urlsplit(origins[0]).netloc.lower() == hosts[0].lower()
    except ValueError:
        return False


def is_valid(data: Any) -> bool:
    """Return whether data are a message of viser with fields of the right types."""
    try:
        message = msgspec.msgpack.decode(data)
        check_message(message)
        return _is_finite(message)
    except Exception:  # no data may end the connection
        return False


def _is_finite(value: Any) -> bool:
    """Return whether all numbers of a message are finite."""
    if isinstance(value, dict):
        return all(map(_is_finite, value.values()))
    if isinstance(value, list):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


@contextlib.contextmanager
def _checked_connections(site: Site) -> Iterator[None]:
    """Make servers started meanwhile check connections; viser has no option for this."""
    module: Any = websockets.asyncio.server
    serve = module.serve
    protocols = SCENE_PROTOCOL, PROTOCOL

    def checked(
        handler: Callable[..., Any],
        *args: Any,
        process_request: Callable[..., Any],
        **options: Any,
    ) -> Any:
        def process(connection: Any, request: Any) -> Any:
            headers = request.headers
            asked = headers.get_all("Sec-WebSocket-Protocol")
            if is_local(headers) and "Upgrade" not in headers:
                return site.response(request.path)
            if is_local(headers) and len(asked) == 1 and asked[0] in protocols:
                return process_request(connection, request)
            connection.transport.abort()
            return connection.respond(http.HTTPStatus.FORBIDDEN, "")

        async def handle(connection: Any) -> None:
            receive, send = connection.recv, connection.send
            of_page = connection.subprotocol == PROTOCOL

            async def receive_valid() -> Any:
                while True:
                    data = await receive()
                    await asyncio.sleep(REST)
                    if of_page or is_valid(data):
                        return data

            async def send_in_time(data: bytes, **options: Any) -> None:
                try:
                    await asyncio.wait_for(send(data, **options), STALLED)
                except TimeoutError:
                    connection.transport.abort()
                    raise

            connection.recv, connection.send = receive_valid, send_in_time
            if of_page:
                await site.serve(connection)
            else:
                await handler(connection)

        options |= {
            "max_size": LARGEST_MESSAGE,
            "open_timeout": LONGEST_ANSWER,
            "select_subprotocol": lambda _, asked: asked[0] if asked[0] in protocols else None,
        }
        return serve(handle, *args, process_request=process, **options)

    module.serve = checked
    try:
        yield
    finally:
        module.serve = serve
