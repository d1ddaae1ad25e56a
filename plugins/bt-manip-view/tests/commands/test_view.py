"""``--view``: the page is announced, stays up after the run, and Ctrl-C ends it."""

import json
import re
import signal
import subprocess
import sys
import time
import urllib.request

import msgspec
import pytest
import viser
from websockets import Subprotocol
from websockets.sync.client import connect

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.3, 0.0, 1.2),
    "fov": 1.0, "near": 0.1, "far": 9.0, "image_height": 9, "image_width": 9,
    "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip
"""The first message of a scene."""


def test_the_page_stays_up_after_the_run_until_ctrl_c(trees, tmp_path):
    tree, report = f"{trees}:quick", tmp_path / "report.json"
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "bt_manip", "run", tree, "--view", "--report", str(report)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    try:
        seen, scene = "", None
        while "stays up" not in seen:
            line = process.stdout.readline()
            assert line, seen
            seen += line
            if (found := re.search(r"http://(127\.0\.0\.1:\d+)", line)) and scene is None:
                # A browser that shows the scene: without one, the run begins after 10 s.
                protocols = [Subprotocol(f"viser-v{viser.__version__}")]
                scene = connect(f"ws://{found[1]}/scene", subprotocols=protocols, max_size=None)
                scene.send(msgspec.msgpack.encode(CAMERA))
        url = re.findall(r"http://127\.0\.0\.1:\d+", seen)[0]
        assert urllib.request.urlopen(url, timeout=30).status == 200
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
    finally:
        process.kill()
    assert json.loads(report.read_text())["status"] == "SUCCESS"


@pytest.mark.parametrize("until", ["", "stays up"], ids=["while preparing", "later"])
def test_ctrl_c_ends_the_page_without_a_run(until):
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "bt_manip", "view"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        if until:
            assert re.search(r"http://127\.0\.0\.1:\d+", process.stdout.readline())
            assert until in process.stdout.readline()
        else:
            time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        # Python itself, while it starts, ends by the signal, which shells call 130, too.
        assert process.wait(30) in ((130,) if until else (130, -signal.SIGINT))
    finally:
        process.kill()


def test_a_mistyped_tree_is_bad_input(bt_manip):
    done = bt_manip("view", "pick_plaze")
    assert done.code == 2 and "did you mean 'pick_place'" in done.err


def test_a_breakpoint_at_an_unknown_node_is_bad_input(bt_manip, tmp_path):
    tree = tmp_path / "tree.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><Sleep msec="10"/></BehaviorTree></root>'
    )
    done = bt_manip("run", tree, "--view", "--view-port", "0", "--view-breakpoints", "Sleep; Slept")
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
