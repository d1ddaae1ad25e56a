"""The publisher that Groot2 connects to, to show a running tree and to intervene in it."""

import json
import struct
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable
from typing import Any

import msgpack
import zmq

from bt_manip.bt import Node, NodeStatus, Tree, instance_to_xml, tree_instances
from bt_manip.exceptions import BtManipError
from bt_manip.runner import Run, RunEvent, RunView
from bt_manip_groot.hooks import HookTable, key_of
from bt_manip_groot.messages import (
    HEADER_LENGTH,
    HIGHEST_UID,
    PROTOCOL_VERSION,
    RequestError,
    transition,
)

HOST = "127.0.0.1"

LARGEST_REQUEST = 1 << 18
"""Size of a part of a request above which the client is disconnected [bytes]."""

LONGEST_VALUE = 10_000
"""Largest number of characters of a blackboard text that are sent."""

MOST_NAMES = 1000
"""Largest number of names of sub-trees that are read from a request."""

TRANSITIONS = 1000
"""Number of transitions that are kept for Groot2, as in the engine."""

POLL = 20
"""Longest delay of a notification [ms]."""

REST = 5e-4
"""Pause after each request, so that many requests do not starve the run's thread [s]."""

HEARTBEAT = 5.0
"""Time without a request after which hooks have no effect, as in the engine [s]."""


class TreeImage:
    """Description of a tree that stays the same while it runs.

    Attributes:
        uuid: Sent with each reply; Groot2 reads the tree again when it is another one.
        xml: The tree.
        scopes: Paths of the blackboard scopes by the names that Groot2 uses.
        nodes: Nodes that can have a hook, by uid.
        offsets: Positions of all nodes in the statuses, by uid.
    """

    def __init__(self, tree: Tree) -> None:
        instances = tree_instances(tree)
        links = [n for i in instances for n in i.nodes if n.uid <= HIGHEST_UID]
        self.uuid = uuid.uuid4().bytes
        self.xml = instance_to_xml(tree).encode(errors="replace")
        self.scopes = {tree.tree_id: ""} | {i.path: i.path for i in instances[1:]}
        self.nodes = {link.uid: link for link in links if isinstance(link, Node)}
        self.offsets = {link.uid: 3 * index + 2 for index, link in enumerate(links)}


class GrootPublisher(RunView):
    """Answers the requests of Groot2 on loopback, in a thread of its own.

    The run's thread leaves the statuses of the nodes here after each tick and takes the hooks
    before the next one; it never waits for a client, except at a breakpoint. Then simulated time
    stands still, until Groot2 unlocks it, is closed, or the run is interrupted.

    Args:
        port: Port of the replies; notifications are sent at the next one.
        tell: Called with a line when the run waits at a breakpoint.
        stays: Whether it answers after the end of a run, for several runs one after the other,
            until `close`.

    Raises:
        BtManipError: If a port is taken.
    """

    kinds = ("tree", "status", "blackboard", "cycle", "tick")

    _image: TreeImage  # from the first event of a tree on

    def __init__(
        self,
        port: int = 1667,
        tell: Callable[[str], None] = lambda message: None,
        *,
        stays: bool = False,
    ) -> None:
        self._tell, self._stays = tell, stays
        self._context = zmq.Context()
        self._context.linger = 0
        self._replies = self._bind(zmq.REP, port)
        self._notifications = self._bind(zmq.PUB, port + 1)
        self._thread = threading.Thread(target=self._serve, name="groot2", daemon=True)
        self._closing = False
        self._statuses = bytearray()
        self._published = b""
        self._values: dict[str, dict[str, Any]] = {}  # entries by the path of their scope
        self._now = 0.0
        self._recording = False
        self._recorded_from = 0.0
        self._transitions: deque[bytes] = deque(maxlen=TRANSITIONS)
        self._hooks = HookTable(self._paused, lambda: self._run.stop())

    def run_started(self, run: Run) -> None:
        """Prepare for the run; the first event of its tree begins to answer requests."""
        self._run, self._tree = run, run.tree

    def before_tick(self) -> None:
        """Apply new hooks."""
        self._hooks.apply(self._image.nodes, self._run.interventions)

    def run_ended(self) -> None:
        """Remove the hooks, and close the sockets unless it stays."""
        if not self._stays:
            self.close()
        self._hooks.clear()

    def close(self) -> None:
        """Stop answering requests, and close the sockets."""
        self._closing = True
        if self._thread.is_alive():
            self._thread.join()
        self._context.destroy()

    # The thread of the run

    def handle(self, event: RunEvent) -> None:
        """Keep the statuses and values that Groot2 shows."""
        self._now = event.time
        match event.kind:
            case "status":
                self._change_status(event.data)
            case "tick" | "cycle":
                self._published = bytes(self._statuses)
            case "blackboard":
                path, _, key = event.data["key"].rpartition("/")
                if path not in self._tree.scopes:
                    path, key = "", event.data["key"]
                value = event.data["value"]
                value = value[:LONGEST_VALUE] if isinstance(value, str) else value
                values = {**self._values.get(path, {}), key: value}
                if not event.data["type"]:
                    del values[key]
                self._values[path] = values
            case "tree":
                self._hooks.clear()
                image = TreeImage(self._tree)
                self._statuses = bytearray(
                    b"".join(struct.pack("<HB", uid, 0) for uid in image.offsets)
                )
                self._published = bytes(self._statuses)
                self._values = {}
                self._image = image
                if not self._thread.is_alive():
                    self._thread.start()

    def _change_status(self, data: dict[str, Any]) -> None:
        offset = self._image.offsets.get(data["uid"])
        if offset is None:
            return
        old, new = NodeStatus[data["old"]].value, NodeStatus[data["status"]].value
        self._statuses[offset] = new or (10 + old if old else 0)  # 10: idle, and the last result
        if self._recording:
            elapsed = max(0, round((self._now - self._recorded_from) * 1e6))
            self._transitions.append(transition(elapsed, data["uid"], new))

    def _paused(self, node: Node) -> None:
        self._published = bytes(self._statuses)
        self._tell(f"Paused at a breakpoint of Groot2: {node.path}")

    # The thread of the publisher

    def _bind(self, kind: int, port: int) -> zmq.Socket[bytes]:
        bound = self._context.socket(kind)
        bound.setsockopt(zmq.MAXMSGSIZE, LARGEST_REQUEST)
        try:
            bound.bind(f"tcp://{HOST}:{port}")
        except (zmq.ZMQError, OverflowError) as error:
            self._context.destroy()
            raise BtManipError(
                f"--groot: port {port} of {HOST} cannot be used: {error}; --groot-port chooses "
                "another one, and the next port must be free, too"
            ) from None
        return bound

    def _serve(self) -> None:
        """Answer requests, and tell which breakpoints were reached, until the run ends."""
        last, number = time.monotonic(), 0
        try:
            while not self._closing:
                if self._replies.poll(POLL):
                    self._hooks.suspend(False)
                    self._replies.send_multipart(self._answer(self._request()))
                    last = time.monotonic()
                    time.sleep(REST)
                elif time.monotonic() - last > HEARTBEAT:
                    self._hooks.suspend(True)
                while self._hooks.reached:
                    number += 1
                    header = PROTOCOL_VERSION + b"N" + struct.pack("<I", number)
                    uid = str(self._hooks.reached.popleft()).encode()
                    self._notifications.send_multipart([header, uid])
        finally:
            self._hooks.suspend(True)  # nobody could unlock a breakpoint any more

    def _request(self) -> list[bytes]:
        """Receive a request; of more than three parts the rest is dropped."""
        parts = [self._replies.recv()]
        while self._replies.getsockopt(zmq.RCVMORE):
            part = self._replies.recv()
            if len(parts) < 3:
                parts.append(part)
        return parts

    def _answer(self, parts: list[bytes]) -> list[bytes]:
        """Return the reply to a request."""
        try:
            if len(parts[0]) != HEADER_LENGTH:
                raise RequestError("wrong request header")
            image = self._image
            body = self._body(parts[0][1:2], parts[1:], image)
            header = PROTOCOL_VERSION + parts[0][1:] + image.uuid
            return [header] if body is None else [header, body]
        except Exception as error:  # whatever was sent must not end the thread
            text = str(error) if isinstance(error, RequestError) else type(error).__name__
            return [b"error", text.encode(errors="replace")]

    def _body(self, kind: bytes, payloads: list[bytes], image: TreeImage) -> bytes | None:
        """Return the second part of the reply; None if it has none."""
        if kind in b"BIRUr" and len(payloads) != 1:
            raise RequestError("must be 2 parts message")
        payload = payloads[0] if payloads else b""
        match kind:
            case b"T":
                return image.xml
            case b"S":
                return self._published
            case b"B":
                return self._blackboard(payload.decode(errors="replace"), image)
            case b"D":
                return json.dumps(self._hooks.dump(), separators=(",", ":")).encode()
            case b"I":
                self._hooks.insert(json.loads(payload), image.offsets, image.nodes)
            case b"R":
                self._hooks.remove(key_of(json.loads(payload)))
            case b"U":
                self._hooks.unlock(json.loads(payload))
            case b"A":
                self._hooks.clear()
            case b"X":
                self._hooks.disable()
            case b"r":
                return self._toggle_recording(payload)
            case b"t":
                taken = [self._transitions.popleft() for _ in range(len(self._transitions))]
                return b"".join(taken)
            case _:
                raise RequestError("Request not recognized")
        return None

    def _blackboard(self, names: str, image: TreeImage) -> bytes:
        """Return the entries of some sub-trees and of the root, as far as they can be read."""
        found: dict[str, Any] = {}
        for name in names.split(";", MOST_NAMES):
            path = image.scopes.get(name)
            if path is not None:
                found[name] = self._values.get(path) or None
                if path:
                    found["ROOT"] = self._values.get("") or None
        packed: bytes = msgpack.packb(found or None, default=str, unicode_errors="replace")
        return packed

    def _toggle_recording(self, command: bytes) -> bytes | None:
        if command == b"start":
            self._transitions.clear()
            self._recorded_from, self._recording = self._now, True
            return str(time.time_ns() // 1000).encode()
        if command == b"stop":
            self._recording = False
        return None
