"""The window shows the robot, stays open after the run, and its view is that of the cell."""

import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.runner import Station
from bt_manip.viewer import render
from bt_manip.viewer.window import aim
from tests.support.program import trees as trees

PROBE = """
import glfw
assert glfw.init()
glfw.window_hint(glfw.VISIBLE, False)
window = glfw.create_window(16, 16, "probe", None, None)
assert window
glfw.make_context_current(window)
import mujoco
context = mujoco.MjrContext(mujoco.MjModel.from_xml_string("<mujoco/>"), 150)
"""


class Display(NamedTuple):
    environment: dict[str, str]
    file: Path

    def pixels(self) -> np.ndarray:
        """Read the screen, which Xvfb keeps as an X window dump."""  # (height, width, 3)
        data = self.file.read_bytes()
        header = struct.unpack(">25I", data[:100])
        width, height, stride, colours = header[4], header[5], header[12], header[19]
        start = header[0] + 12 * colours
        rows = np.frombuffer(data, np.uint8, stride * height, start).reshape(height, -1, 4)
        return rows[:, :width, 2::-1]  # stored as blue, green, red, unused


@pytest.fixture(scope="module")
def display(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Display]:
    """Start a virtual display, or skip the test where there is none to draw on."""
    xvfb = shutil.which("Xvfb")
    if xvfb is None:
        pytest.skip("no virtual display here: Xvfb is not installed")
    folder = tmp_path_factory.mktemp("display")
    read, write = os.pipe()
    command = [xvfb, "-displayfd", str(write), "-screen", "0", "480x300x24", "-fbdir", str(folder)]
    server = subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    try:
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        if not number:
            pytest.skip("no virtual display here: Xvfb does not start")
        environment = {k: v for k, v in os.environ.items() if k != "MUJOCO_GL"}
        environment["DISPLAY"] = f":{number}"
        probe = subprocess.run(
            [sys.executable, "-c", PROBE], env=environment, capture_output=True, check=False
        )
        if probe.returncode:
            pytest.skip("no OpenGL on the virtual display: a window cannot be opened")
        yield Display(environment, folder / "Xvfb_screen0")
    finally:
        server.terminate()
        server.wait()


def wait_for(condition: Callable[[], bool], process: subprocess.Popen, timeout: float) -> None:
    """Wait for something that a process does [s]."""
    end = time.monotonic() + timeout
    while not condition():
        assert process.poll() is None, f"it ended with {process.returncode}"
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.1)


def without_robot(station: Station, size: tuple[int, int]) -> np.ndarray:
    model = station.cell.model
    bodies = [model.body(body).name for body in model.geom_bodyid]
    robot = [i for i, body in enumerate(bodies) if body.startswith("panda/")]
    kept = model.geom_rgba.copy(), model.geom_matid.copy()
    model.geom_matid[robot] = -1
    model.geom_rgba[robot] = 0.0
    picture = render(station.cell, width=size[0], height=size[1])
    model.geom_rgba[:], model.geom_matid[:] = kept
    return picture


def test_the_window_shows_the_robot_and_stays_open_until_ctrl_c(opengl, display, trees, tmp_path):
    report, trace = tmp_path / "report.json", tmp_path / "trace.npz"
    process = subprocess.Popen(
        [sys.executable, "-m", "bt_manip", "run", f"{trees}:quick", "--window",
         "--report", report, "--trace", trace],
        env=display.environment, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        station = build_station()
        size = 320, 200  # MuJoCo opens its window at two thirds of the screen, in the corner
        expected = render(station.cell, width=size[0], height=size[1]).astype(int)
        without = without_robot(station, size).astype(int)
        robot = abs(expected - without).max(axis=2) > 40
        assert robot.sum() > 750

        def shows_robot() -> bool:
            if not display.file.exists():
                return False
            shown = display.pixels()[: size[1], : size[0]].astype(int)
            seen = robot & (abs(shown - without).max(axis=2) > 40)
            alike = abs(shown - expected)[robot].mean() < 25
            return bool(alike and seen.mean() == pytest.approx(robot.mean(), rel=0.2))

        wait_for(shows_robot, process, 120)
        wait_for(lambda: report.exists() and trace.exists(), process, 120)
        time.sleep(0.3)
        assert process.poll() is None and shows_robot()
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=30)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0  # the run was over and had succeeded
    assert json.loads(report.read_text())["status"] == "SUCCESS"
    assert "The window stays open; close it or press Ctrl-C to leave." in out


def test_the_first_viewpoint_is_the_overview_camera_of_the_cell():
    cell = build_station().cell
    camera = mujoco.MjvCamera()
    data = mujoco.MjData(cell.model)
    mujoco.mj_forward(cell.model, data)
    aim(camera, cell.model, data)
    overview = cell.model.camera("overview").id
    azimuth, elevation = np.deg2rad([camera.azimuth, camera.elevation])
    forward = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
               np.sin(elevation)]  # fmt: skip
    axes = data.cam_xmat[overview].reshape(3, 3)
    np.testing.assert_allclose(forward, -axes[:, 2], atol=1e-9)
    sight = camera.lookat - data.cam_xpos[overview]
    np.testing.assert_allclose(np.cross(sight, forward), 0.0, atol=1e-9)


def test_without_that_camera_the_whole_model_is_in_view():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom size='0.5' pos='3 2 1'/></worldbody></mujoco>"
    )
    camera, data = mujoco.MjvCamera(), mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    aim(camera, model, data)
    np.testing.assert_allclose(camera.lookat, [3, 2, 1], atol=1e-9)
    half_angle = np.deg2rad(model.vis.global_.fovy) / 2
    assert camera.distance * np.sin(half_angle) > 0.5
