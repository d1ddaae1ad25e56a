"""The arm picks what a camera of the simulated real cell sees: nothing else is shared."""

import json

import numpy as np
from cell_operator import Operator, in_basket
from real_cell import BEFORE_THE_FR3, CUBES, write_model, write_seen_scene
from simulation import ARM

from tests.support.drawing import opengl as opengl

SIZE = (640, 480)


def test_cubes_that_the_camera_sees_end_in_the_real_basket(opengl, start_robot, tmp_path):
    scene, model, report = (tmp_path / name for name in ("scene.toml", "real.xml", "report.json"))
    write_seen_scene(scene)
    cell = write_model(scene, ARM, model)
    robot = start_robot(model, "--patient")
    port = robot.ask("camera", name="eye", size=SIZE)
    rng, height = np.random.default_rng(0), cell.objects["cube"].translation[2]

    def put():
        at, yaw = rng.uniform(BEFORE_THE_FR3.lowest, BEFORE_THE_FR3.highest), rng.uniform(-3, 3)
        quat = (np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0))
        robot.ask("place", body="cube", position=[*at, height], quat=quat)

    put()
    run = Operator(
        robot, scene, cell, "--camera", f"eye={robot.host}:{port}", "--tool-speed", "0.5",
        "--set", "attempts=6", "--report", str(report),
        cycles=CUBES, task=("pick_place_seen", "seen"),
    )  # fmt: skip
    placed = 0
    for number in range(1, CUBES + 1):
        run.until(rf"cycle {number}/{CUBES}: ", seconds=300.0)
        placed += in_basket(robot, cell, "cube")
        put()  # on the table again, while the arm sets off to look into the basket
    code, found = run.end(), json.loads(report.read_text())
    times = [cycle["duration_s"] for cycle in found["cycles"]]
    print(f"{placed} of {CUBES} cubes; {found['real']}, {robot.ask('communication')}, {times} s")
    assert (code, placed) == (0, CUBES), run.output
