"""The handler of Ctrl-C, as in the program, a short recording, and the sockets of a process."""

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from bt_manip.bt import Sleep
from bt_manip.cli import Interrupt
from bt_manip_recording import McapRecorder

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU)

LOOPBACK = {"0100007F", "0" * 24 + "01000000", "0000000000000000FFFF00000100007F"}
"""127.0.0.1, ::1, and 127.0.0.1 as an IPv6 address, as the kernel writes them."""

LISTENING = "0A"


@pytest.fixture
def interrupt():
    """Handle signals as the program does."""
    interrupt, handlers = Interrupt(), {number: signal.getsignal(number) for number in SIGNALS}
    interrupt.install()
    yield interrupt
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(scope="session")
def recording(make_run, tmp_path_factory) -> Path:
    """Record a short run."""
    path: Path = tmp_path_factory.mktemp("recording") / "run.mcap"
    make_run(Sleep("rest", msec=50)).execute([McapRecorder(path)])
    return path


@contextmanager
def using_loopback_only(process: subprocess.Popen) -> Iterator[None]:
    """Check that a process listens meanwhile, and neither listens nor connects beyond loopback."""
    if not Path("/proc/net/tcp").exists():
        yield
        return
    seen: set[tuple[str, str, str]] = set()
    done = threading.Event()

    def watch() -> None:
        while not done.wait(0.05):
            seen.update(sockets_of(process))

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
    assert LISTENING in {state for _, _, state in seen}
    assert {local for local, _, _ in seen} <= LOOPBACK, seen
    assert {remote for _, remote, _ in seen if remote.strip("0")} <= LOOPBACK, seen


def sockets_of(process: subprocess.Popen) -> list[tuple[str, str, str]]:
    """Return local address, remote address and state of the TCP and UDP sockets of a process."""
    folder = Path("/proc", str(process.pid))
    inodes = set()
    for file in (folder / "fd").iterdir():
        try:
            target = os.readlink(file)
        except OSError:  # closed meanwhile
            continue
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    found = []
    for kind in ("tcp", "tcp6", "udp", "udp6"):
        for line in (folder / "net" / kind).read_text().splitlines()[1:]:
            _, local, remote, state, *_, inode = line.split()[:10]
            if inode in inodes:
                found.append((local.split(":")[0], remote.split(":")[0], state))
    return found
