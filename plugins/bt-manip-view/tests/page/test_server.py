"""The page is served on loopback, and only to pages of its own."""

import socket
from contextlib import nullcontext
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
import websockets.exceptions
from websockets import Headers

from bt_manip.exceptions import BtManipError
from bt_manip_view.page.server import close_server, is_local, open_server


def answer(url: str, *lines: str) -> bytes:
    """Return all that the server answers to a request with these headers."""
    port = urlsplit(url).port
    with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
        client.sendall("\r\n".join(["GET / HTTP/1.1", *lines, "", ""]).encode())
        client.settimeout(10)
        try:
            return client.recv(4000)
        except ConnectionResetError:
            return b""


def test_the_server_listens_on_loopback_only(page):
    port, host = urlsplit(page.url).port, urlsplit(page.url).netloc
    assert urlsplit(page.url).hostname == "127.0.0.1"
    assert answer(page.url, f"Host: {host}").startswith(b"HTTP/1.1 200")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # sends nothing: it finds the address of this computer
        address = probe.getsockname()[0]
    if address.startswith("127."):
        pytest.skip("this computer has no address besides loopback")
    with pytest.raises(OSError):
        socket.create_connection((address, port), timeout=5)


def test_a_server_takes_another_port_than_a_taken_one_and_prints_nothing(page, capfd):
    taken = urlsplit(page.url).port
    server = open_server(taken)
    try:
        assert server.get_port() != taken
    finally:
        close_server(server)
    assert capfd.readouterr() == ("", "")


def test_where_no_port_can_be_opened_an_error_says_so(monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(socket.socket, "bind", refuse)
    with pytest.raises(BtManipError, match="no page can be served on 127.0.0.1: Permission denied"):
        open_server(0)


@pytest.mark.parametrize("path", ["/", "/page.js", "/scene", "/missing", "/../page.py"])
def test_no_other_page_shows_this_one_in_a_frame(page, path):
    missing = path in ("/missing", "/../page.py")
    with pytest.raises(HTTPError) if missing else nullcontext() as error:
        response = urlopen(page.url + path, timeout=10)
    headers = error.value.headers if error else response.headers
    if error:
        error.value.close()
    (policy,) = headers.get_all("Content-Security-Policy")
    if path == "/scene":
        assert policy == "frame-ancestors 'self'"
    else:
        assert "frame-ancestors 'none'" in policy and "script-src" not in policy
        assert "default-src 'self'" in policy


@pytest.mark.parametrize(
    "lines",
    [
        ("Host: attacker.example",),
        ("Host: 127.0.0.1.attacker.example",),
        ("Accept: */*",),
        ("Host: localhost:1", "Host: attacker.example"),
        ("Host: localhost:1", "Origin: http://attacker.example"),
        ("Host: localhost:1", "Origin: http://localhost:2"),
        ("Host: localhost:1", "Origin: null"),
    ],
    ids=" ".join,
)
def test_a_foreign_request_is_closed_without_an_answer(page, lines):
    assert answer(page.url, *lines) == b""


@pytest.mark.parametrize("what", ["scene", "page"])
def test_a_page_of_the_server_connects_and_a_foreign_one_gets_no_message(page, connect, what):
    with pytest.raises((websockets.exceptions.WebSocketException, EOFError, OSError)):
        connect(what, Origin="http://attacker.example")
    assert connect(what, Origin=page.url).read()


def test_a_forwarded_port_is_local():
    """A page behind ``ssh -L 9000:localhost:8080`` has another port than the server."""
    assert is_local(Headers(Host="localhost:9000", Origin="http://localhost:9000"))
    assert is_local(Headers(Host="[::1]:9000"))
    assert not is_local(Headers(Host="[::1"))
