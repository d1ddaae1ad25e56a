"""Nothing listens, or connects, beyond loopback."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

LOOPBACK = ("0100007F", "0" * 24 + "01000000", "0000000000000000FFFF00000100007F")
"""127.0.0.1, ::1, and 127.0.0.1 as an IPv6 address, as the kernel writes them."""

LISTENING = "0A"

pytestmark = pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="no /proc here")


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
        lines = (folder / "net" / kind).read_text().splitlines()[1:]
        for _, local, remote, state, *_, inode in (
            (*line.split()[:4], line.split()[9]) for line in lines
        ):
            if inode in inodes:
                found.append((local.split(":")[0], remote.split(":")[0], state))
    return found


def watch(seconds: float, *arguments: object, cwd: Path) -> list[tuple[str, str, str]]:
    """Run a command for some time at most; return all sockets that it had."""
    command = [sys.executable, "-m", "bt_manip", *map(str, arguments)]
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.DEVNULL)
    seen: set[tuple[str, str, str]] = set()
    end: float | None = None
    try:
        while process.poll() is None and (end is None or time.monotonic() < end):
            try:
                seen.update(sockets_of(process))
            except FileNotFoundError:  # it has ended
                break
            if end is None and any(state == LISTENING for _, _, state in seen):
                end = time.monotonic() + seconds  # from when it listens
            time.sleep(0.05)
    finally:
        process.kill()
        process.wait()
    return sorted(seen)


def test_a_run_with_all_viewers_a_replay_and_a_report_use_loopback_only(bt_manip, trees, tmp_path):
    slow = ("--real-time", "1")
    commands = {
        "run": ("run", f"{trees}:endless", "--view", *slow),
        "replay": ("replay", "run.mcap"),
        "report": ("report", "run.mcap"),
    }
    assert bt_manip("run", f"{trees}:quick", "--record", tmp_path / "run.mcap").code == 0
    for name, arguments in commands.items():
        seen = watch(0.5, *arguments, cwd=tmp_path)
        addresses = {local for local, _, _ in seen}
        remotes = {remote for _, remote, _ in seen if remote.strip("0")}
        assert addresses <= set(LOOPBACK), (name, seen)
        assert remotes <= set(LOOPBACK), (name, seen)
        listening = [one for one in seen if one[2] == LISTENING]
        assert listening or name == "report", name
