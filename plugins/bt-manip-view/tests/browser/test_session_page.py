"""Jogging and runs from the page of a cell in which no tree runs (``bt-manip view``)."""

import numpy as np
import pytest

from .conftest import Window, wait_until

TOOL = 0.1034
"""Distance of the Panda's tool from its hand [m]."""


@pytest.fixture(scope="module")
def window(start, open_window) -> Window:
    window = open_window(start("view", "pick_place").url)
    window.wait_for_scene()
    return window


def test_a_joint_slider_moves_the_arm_which_is_saved_by_name(window):
    window.open_tab("Jog")
    before = window.pixel("/panda/panda:hand")
    joint1 = window.page.get_by_role("spinbutton", name="joint1 [rad] value")
    joint1.fill("0.5")
    joint1.press("Enter")

    def moved() -> bool:
        return abs(window.pixel("/panda/panda:hand")[0] - before[0]) > 20

    wait_until(moved)
    window.page.get_by_label("Save as").fill("beside")
    window.press("Save configuration")
    window.wait_for_text(r"beside.*configurations\.toml")
    window.keep("jog")


def test_the_tool_follows_the_handle_that_the_mouse_drags_by_an_arrow(window):
    window.open_tab("Jog")
    hand, handle = "/panda/panda:hand", "/jog/panda"

    def settled() -> bool:
        """Return whether the handle is at the tool, where it is while the arm rests."""
        return abs(np.linalg.norm(window.position(hand) - window.position(handle)) - TOOL) < 1e-3

    wait_until(settled)
    before = window.position(hand)
    arrow = (0.0, 0.0, -0.12)  # the tool points down, and so does the arrow of its z axis
    expected = before + (0.0, 0.0, 0.1)

    def is_at(position: np.ndarray) -> bool:
        return bool(np.abs(window.position(hand) - position).max() < 0.005)

    window.pull(handle, arrow, (0.0, 0.0, arrow[2] + 0.1), lambda: not is_at(before))
    window.page.mouse.up()
    wait_until(lambda: is_at(expected))
    wait_until(settled)
    out_of_reach = (0.0, 0.0, arrow[2] + 2.0)
    window.pull(handle, arrow, out_of_reach, lambda: "the pose is unreachable" in window.text())
    window.page.mouse.up()
    wait_until(settled)
    assert is_at(expected)


def test_a_tree_runs_is_stopped_and_the_cell_is_reset(window):
    assert "SpawnObject" in window.tree() and "s: ready" in window.text()
    window.set_breakpoint("SpawnObject")
    window.press("▶ Run")
    window.wait_for_text("s: paused at .*SpawnObject")
    window.press("Continue")
    window.wait_for_tree("▶ (Hover|Reach|Lift|Drop)")
    window.press("Stop")
    window.wait_for_text("INTERRUPTED")
    window.wait_for_text(r"recorded: bt-manip run pick_place .*--record run\.mcap")
    window.button("Reset").wait_for()
    window.press("▶ Run")  # again
    window.wait_for_text("s: paused at .*SpawnObject")
    window.set_breakpoint("SpawnObject")
    window.press("Continue")
    window.wait_for_text("cycle 1, .*running")
    window.press("Stop")
    window.button("Reset").wait_for()
    window.press("Reset")
    wait_until(lambda: window.time() < 1.0)
    window.keep("session")
    assert not window.log
