"""bt-manip run --groot, and the log files of --record."""

import json
import signal
import socket
import subprocess
import sys
import time

import pytest

from .client import Client, free_ports, hook


@pytest.fixture
def path(task):
    """Give the file of an endless tree."""
    return task('<Sequence><Sleep name="rest" msec="10000000"/></Sequence>')


def test_ctrl_c_at_a_breakpoint_ends_the_run_and_writes_its_files(path, tmp_path):
    port = free_ports()
    waiting = Client(port)
    waiting.requests.rcvtimeo = 120_000
    report, log = tmp_path / "report.json", tmp_path / "run.btlog"
    options = ["--groot", "--groot-port", str(port), "--report", report, "--record", log]
    process = subprocess.Popen(
        [sys.executable, "-m", "bt_manip", "run", path, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        waiting.ask("S")  # the publisher is there: notifications of the next client are not lost
        waiting.close()
        client = Client(port)
        client.ask("S")
        time.sleep(0.5)
        client.ask("I", hook(2))
        assert client.reached() == 2
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=120)
    finally:
        process.kill()
    client.close()
    assert process.returncode == 130, output
    assert f"Groot2 can connect to 127.0.0.1, port {port}." in output
    assert "Paused at a breakpoint of Groot2: rest" in output
    assert json.loads(report.read_text())["status"] == "INTERRUPTED"
    assert log.read_bytes().startswith(b"BTCPP4-FileLogger2\x01")


def test_a_port_that_is_taken_is_bad_input(bt_manip, path):
    port = free_ports()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port + 1))
        done = bt_manip("run", path, "--groot", "--groot-port", port)
    assert done.code == 2
    assert f"port {port + 1} of 127.0.0.1 cannot be used: Address already in use" in done.err
