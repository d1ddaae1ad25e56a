"""A client of the publisher, as Groot2 is one."""

import itertools
import json
import socket
import struct

import zmq


def free_ports() -> int:
    """Give the first of two neighbouring ports that are free."""
    for _ in range(100):
        with socket.socket() as first, socket.socket() as second:
            first.bind(("127.0.0.1", 0))
            port = first.getsockname()[1]
            try:
                second.bind(("127.0.0.1", port + 1))
            except (OSError, OverflowError):
                continue
            return port
    raise AssertionError("no free ports")


class Client:
    """Sends requests as Groot2 does."""

    def __init__(self, port: int) -> None:
        self._context = zmq.Context()
        self._context.linger = 0
        self.requests = self._context.socket(zmq.REQ)
        self.requests.connect(f"tcp://127.0.0.1:{port}")
        self._notifications = self._context.socket(zmq.SUB)
        self._notifications.subscribe(b"")
        self._notifications.connect(f"tcp://127.0.0.1:{port + 1}")
        self._numbers = itertools.count(1)
        for one in (self.requests, self._notifications):
            one.rcvtimeo = 10_000

    def send(self, parts: list[bytes]) -> list[bytes]:
        """Send the parts of a request and give those of the reply."""
        self.requests.send_multipart(parts)
        return self.requests.recv_multipart()

    def ask(self, kind: str, payload=None) -> bytes | None:
        """Send a request of a type; give the second part of the reply."""
        header = struct.pack("<BsI", 2, kind.encode(), next(self._numbers))
        if payload is not None and not isinstance(payload, bytes):
            payload = json.dumps(payload).encode()
        first, *rest = self.send([header] if payload is None else [header, payload])
        assert first != b"error", rest
        assert first[:6] == header and len(first) == 22
        return rest[0] if rest else None

    def statuses(self) -> dict[int, int]:
        return dict(struct.iter_unpack("<HB", self.ask("S")))

    def hooks(self) -> list[dict]:
        return json.loads(self.ask("D"))

    def reached(self) -> int:
        """Wait until the run has reached a breakpoint; give the node's uid."""
        return int(self._notifications.recv_multipart()[1])

    def close(self) -> None:
        self._context.destroy()


def hook(uid, status="SKIPPED", mode=0, *, position=0, once=False, enabled=True):
    return {
        "uid": uid, "desired_status": status, "mode": mode, "position": position, "once": once,
        "enabled": enabled,
    }  # fmt: skip


def unlock(uid, status="SKIPPED", *, position=0, remove=False):
    return {
        "uid": uid, "desired_status": status, "position": position, "remove_when_done": remove
    }  # fmt: skip
