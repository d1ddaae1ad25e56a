"""``--view``: the page is announced, stays up after the run, and Ctrl-C ends it."""

import json
import signal
import subprocess
import sys
import time
import urllib.request

import msgspec
from websockets.sync.client import connect

from ..page.conftest import CAMERA, PROTOCOLS
from .conftest import using_loopback_only


def test_the_page_is_served_on_loopback_until_ctrl_c(start, trees, tmp_path):
    report = tmp_path / "report.json"
    program = start("run", f"{trees}:quick", "--view", "--report", report)
    with using_loopback_only(program.process):
        # A browser that shows the scene: without one, the run begins after 10 s.
        address = f"{program.url.replace('http', 'ws')}/scene"
        scene = connect(address, subprotocols=[PROTOCOLS["scene"]], max_size=None)
        scene.send(msgspec.msgpack.encode(CAMERA))
        program.wait_for("stays up")
        assert urllib.request.urlopen(program.url, timeout=30).status == 200
    assert program.interrupt() == 0
    assert json.loads(report.read_text())["status"] == "SUCCESS"


def test_ctrl_c_ends_a_page_that_is_prepared():
    process = subprocess.Popen([sys.executable, "-u", "-m", "bt_manip", "view"])
    try:
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        # Python itself, while it starts, ends by the signal, which shells call 130, too.
        assert process.wait(30) in (130, -signal.SIGINT)
    finally:
        process.kill()


def test_a_breakpoint_at_an_unknown_node_is_bad_input(bt_manip, task):
    options = ("--view", "--view-port", "0", "--view-breakpoints", "Sleep; Slept")
    done = bt_manip("run", task('<Sleep msec="10"/>'), *options)
    assert done.code == 2
    assert "breakpoint: no node is called 'Slept'; did you mean 'Sleep'?" in done.err


def test_a_tree_that_raises_at_its_setup_opens_no_page(bt_manip, tmp_path):
    tree = tmp_path / "unready.py"
    tree.write_text(
        "from bt_manip.bt import Sleep\n\n\nclass Unready(Sleep):\n"
        "    def setup(self, **infrastructure):\n        raise ValueError('not ready')\n\n\n"
        "def unready():\n    return Unready(msec=10)\n"
    )
    done = bt_manip("run", f"{tree}:unready", "--view")
    assert done.code == 3 and "not ready" in done.err and "http" not in done.out
