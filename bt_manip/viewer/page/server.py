"""The web server of the page: viser on loopback, closed to other sites."""

import contextlib
import http
import io
import logging
import threading
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server

HOST = "127.0.0.1"
"""The only address that the page is served on."""

PORT = 8080
"""The first port that is tried."""

LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""Names of this computer in the header Host; the port differs behind ``ssh -L``."""

_serving = threading.Lock()


def open_server(port: int = PORT) -> viser.ViserServer:
    """Start viser on loopback, in a thread of its own.

    Connections whose Host is not this computer, or whose Origin is another site, are closed
    before anything is sent.

    Args:
        port: The first port that is tried; 0 lets the system choose.
    """
    # viser prints a line, and websockets a traceback, for each connection that it cannot use.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    # viser draws its addresses on standard output.
    with _serving, _checked_connections(), contextlib.redirect_stdout(io.StringIO()):
        return viser.ViserServer(host=HOST, port=port, verbose=False)


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


@contextlib.contextmanager
def _checked_connections() -> Iterator[None]:
    """Let servers that are started meanwhile check connections: viser has no option for it."""
    module: Any = websockets.asyncio.server
    serve = module.serve

    def checked(*args: Any, process_request: Callable[..., Any], **options: Any) -> Any:
        def process(connection: Any, request: Any) -> Any:
            if is_local(request.headers):
                return process_request(connection, request)
            connection.transport.abort()
            return connection.respond(http.HTTPStatus.FORBIDDEN, "")

        return serve(*args, process_request=process, **options)

    module.serve = checked
    try:
        yield
    finally:
        module.serve = serve
