"""The unchanged tree pick_place places real cubes, judged by the state of the simulated robot."""

import json

from cell_operator import SPEED, Operator


def test_the_cubes_of_the_scene_end_in_the_real_basket(start_robot, scene, real, tmp_path):
    model, cell = real
    robot = start_robot(model, "--patient")
    cubes, report = len(cell.objects), tmp_path / "report.json"
    run = Operator(robot, scene, cell, "--report", str(report), cycles=cubes)
    code = run.end(seconds=120.0 * cubes)
    found = json.loads(report.read_text())
    print(f"{cubes} cubes at speed {SPEED:g}; {found['real']}, {robot.ask('communication')}")
    assert code == 0, run.output
    assert sorted(run.placed) == sorted(cell.objects)
    assert {cycle["judged_by"] for cycle in found["cycles"]} == {"gripper and assumption"}
