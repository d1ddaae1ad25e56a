"""The web server of the page: viser on loopback, closed to other sites and invalid messages."""

import asyncio
import contextlib
import http
import io
import logging
import math
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import msgspec
import viser
import viser._messages as viser_messages
import websockets.asyncio.server

HOST = "127.0.0.1"
"""The only address that the page is served on."""

PORT = 8080
"""The first port that is tried."""

LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""Names of this computer in the header Host; the port differs behind ``ssh -L``."""

NOT_FRAMED = "frame-ancestors 'none'"
"""Content security policy of all responses: no page may show this one in a frame."""

LARGEST_MESSAGE = 1 << 18
"""Size of a message of a page above which it is disconnected [bytes]; viser has 50 MB."""

LONGEST_TEXT = 10_000
"""Characters of a text that is typed on a page."""

REST = 5e-4
"""Pause after each message, so that a flood of them leaves the interpreter to the run [s]."""

STALLED = 20.0
"""Time after which a page that does not read what it is sent is disconnected [s]."""

UNUSED = (
    viser_messages.ShareUrlRequest,  # connects to a server of viser in the internet
    viser_messages.ShareUrlDisconnect,
    viser_messages.FileTransferStartUpload,
    viser_messages.FileTransferPart,
    viser_messages.GuiFormDirtyMessage,  # sent on to all pages, whatever they name
    viser_messages.GuiFormSubmitMessage,
)
"""Messages of pages that have no effect here."""

_serving = threading.Lock()


def open_server(port: int = PORT) -> viser.ViserServer:
    """Start viser on loopback, in a thread of its own.

    Connections whose Host is not this computer, or whose Origin is another site, are closed
    before anything is sent. No page shows this one in a frame. Invalid messages, which viser
    would fail on, have no effect.

    Args:
        port: The first port that is tried; 0 lets the system choose.
    """
    # viser prints a line, and websockets a traceback, for each connection that it cannot use.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    # viser draws its addresses on standard output.
    with _serving, _checked_connections(), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    sockets = server._websock_server
    for kind in UNUSED:
        sockets.unregister_handler(kind)
    update: Any
    (update,) = sockets._incoming_handlers[viser_messages.GuiUpdateMessage]

    async def checked(client_id: Any, message: Any) -> None:
        handle = server.gui._gui_input_handle_from_uuid.get(message.uuid)
        if handle is not None and is_valid_update(handle._impl, message.updates):
            await update(client_id, message)

    sockets._incoming_handlers[viser_messages.GuiUpdateMessage] = [checked]
    # What is valid, but fails all the same, would be printed with its traceback.
    server.get_event_loop().set_exception_handler(lambda loop, context: None)
    return server


def is_open(server: viser.ViserServer) -> bool:
    """Return whether any page is open."""
    return bool(server._websock_server._live_connections)


def processor_time(server: viser.ViserServer) -> float:
    """Return the processor time of the server's thread; 0 where it cannot be measured [s]."""
    thread: Any = server._websock_server._server_thread
    if not thread.is_alive() or not hasattr(time, "pthread_getcpuclockid"):
        return 0.0
    return time.clock_gettime(time.pthread_getcpuclockid(thread.ident))


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without the line that viser prints."""
    connections = server._websock_server._live_connections  # closing politely takes seconds
    for connection in list(connections.values()):
        server.get_event_loop().call_soon_threadsafe(connection.transport.abort)
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def is_local(headers: Any) -> bool:
    """Return whether a request comes from a page of this server, or from no page at all.

    A page of another site can reach the server by its address, with its own Origin, or by a name
    that it lets point to loopback, with that name as Host (DNS rebinding).

    Args:
        headers: The ``websockets.Headers`` of the request.
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
    """Return whether data of a page are a message of viser with fields of the right types."""
    try:
        message = msgspec.msgpack.decode(data)
        kind = getattr(viser_messages, message["type"])
        if not issubclass(kind, viser_messages.Message) or not _is_finite(message):
            return False
        fields = {key: value for key, value in message.items() if key != "type"}
        msgspec.convert(fields, kind)
        return fields.keys() <= kind.__dataclass_fields__.keys()
    except Exception:  # whatever was sent must not end the connection
        return False


def is_valid_update(state: Any, updates: dict[str, Any]) -> bool:
    """Return whether a page may update an input so.

    Args:
        state: viser's state of the input, of which a page may only set the value.
        updates: The new properties.
    """
    if updates.keys() != {"value"}:
        return False
    old, new = state.value, updates["value"]
    limits = [getattr(state.props, name, None) for name in ("options", "min", "max", "disabled")]
    options, low, high, disabled = limits
    if disabled or (options is not None and new not in options):
        return False
    if isinstance(old, tuple):
        return isinstance(new, list) and len(new) == len(old) and all(map(_is_number, new))
    if isinstance(old, bool):
        return isinstance(new, bool)
    if isinstance(old, int | float):
        in_limits = (low is None or new >= low) and (high is None or new <= high)
        return _is_number(new) and in_limits
    return isinstance(new, str) and len(new) <= LONGEST_TEXT


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_finite(value: Any) -> bool:
    """Return whether all numbers of a message are finite."""
    if isinstance(value, dict):
        return all(map(_is_finite, value.values()))
    if isinstance(value, list):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


@contextlib.contextmanager
def _checked_connections() -> Iterator[None]:
    """Let servers that are started meanwhile check connections: viser has no option for it."""
    module: Any = websockets.asyncio.server
    serve = module.serve
    protocol = f"viser-v{viser.__version__}"

    def checked(
        handler: Callable[..., Any],
        *args: Any,
        process_request: Callable[..., Any],
        **options: Any,
    ) -> Any:
        def process(connection: Any, request: Any) -> Any:
            headers = request.headers
            if is_local(headers) and (
                "Upgrade" not in headers or headers.get_all("Sec-WebSocket-Protocol") == [protocol]
            ):
                response = process_request(connection, request)
                if response is not None:  # not a WebSocket
                    response.headers["Content-Security-Policy"] = NOT_FRAMED
                return response
            connection.transport.abort()
            return connection.respond(http.HTTPStatus.FORBIDDEN, "")

        async def handle(connection: Any) -> None:
            receive, send = connection.recv, connection.send

            async def receive_valid() -> Any:
                while True:
                    data = await receive()
                    await asyncio.sleep(REST)
                    if is_valid(data):
                        return data

            async def send_in_time(data: bytes) -> None:
                try:
                    await asyncio.wait_for(send(data), STALLED)
                except TimeoutError:
                    connection.transport.abort()
                    raise

            connection.recv, connection.send = receive_valid, send_in_time
            await handler(connection)

        options["max_size"] = LARGEST_MESSAGE
        return serve(handle, *args, process_request=process, **options)

    module.serve = checked
    try:
        yield
    finally:
        module.serve = serve
