"""The unchanged tree pick_place on a WidowX AI, judged by its simulator, and the contract."""

import json

import numpy as np
import pinocchio as pin
import pytest
from cell_operator import SPEED, Operator
from real_cell import CUBES, Places, write_model, write_scene
from widowx import start_widowx

from bt_manip import build_station, load_plugins
from bt_manip.robots import Robot, compile_alone
from bt_manip.scenes import Scene, SceneRobot
from bt_manip_contracts import DEVICE_CONTRACT, recovers_from_a_problem

ON_TABLE = Places(basket=(0.5, 0.17, 0.0), lowest=(0.45, -0.25), highest=(0.6, -0.02))
PERIOD = 2e-3  # [s] of references
TOOL_SPEED = 0.25  # [m/s] by default
ROUNDING = 0.3  # [rad/s2] of second differences of the protocol's numbers of 32 bits


@pytest.fixture(scope="module")
def parts():
    """The registered robots, where the driver is installed, and the model is there."""
    pytest.importorskip("trossen_arm")
    plugin = pytest.importorskip("bt_manip_trossen.plugin")
    if not (plugin.model_folder() / plugin.MODEL).is_file():
        pytest.skip(f"no model of the arm in {plugin.model_folder()}: see make rehearsal")
    return plugin.model_folder() / plugin.MODEL


@pytest.fixture(scope="module")
def robot(parts, start_simulator):
    return start_simulator(start_widowx)


@pytest.fixture(scope="module")
def station(robot):
    station = build_station(
        scene=Scene((SceneRobot(pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.0]))),)),
        robot="widowx_ai", backend=f"trossen={robot.host}", controller="position", speed=SPEED,
    )  # fmt: skip
    yield station
    station.hardware.close()


@pytest.mark.parametrize("check", DEVICE_CONTRACT, ids=lambda check: check.__name__)
def test_the_arm_keeps_the_contract(station, check):
    check(station)


def test_the_arm_recovers_from_a_fault(station, robot):
    recovers_from_a_problem(station, lambda: robot.ask("fault", reason="a joint is too hot"))


def exceeded(references: np.ndarray, speed: float) -> dict[str, float]:
    """Return the used parts of the limits, by differences of references and their clock.

    Args:
        references: Clock [s] and reference [rad] of each step.  # (n, 7)
        speed: Limit of the tool's speed [m/s].
    """
    arm = Robot(load_plugins().parts.robots.get("widowx_ai"))
    compile_alone(arm)
    model, q = arm.make_model(), references[:, 1:]
    dt = np.diff(references[:, :1], axis=0)
    v = np.diff(q, axis=0) / dt
    a = np.diff(v, axis=0) / dt[1:]
    tool = np.linalg.norm(np.diff(model.tool_positions(q), axis=0), axis=1) / dt[:, 0]
    outside = np.maximum(model.limits.lower - q, q - model.limits.upper)
    return {
        "steps": len(q),
        "beyond the positions [rad]": float(outside.max()),
        "velocity": float((np.abs(v) / model.limits.velocity).max()),
        "acceleration": float(((np.abs(a) - ROUNDING) / model.limits.acceleration).max()),
        "tool speed": float(tool.max() / speed),
    }


def test_the_cubes_of_the_scene_end_in_the_real_basket(parts, start_simulator, tmp_path):
    scene, model, report = (tmp_path / name for name in ("scene.toml", "cell.xml", "report.json"))
    write_scene(scene, CUBES, ON_TABLE)
    cell = write_model(scene, parts, model, "widowx_ai")
    robot = start_simulator(start_widowx, model)
    names = "widowx_ai", "trossen"
    run = Operator(robot, scene, cell, "--report", str(report), cycles=CUBES, names=names)
    try:
        code = run.end(seconds=180.0 * CUBES)
    finally:
        run.process.kill()
    found, steps = json.loads(report.read_text()), tmp_path / "steps.npy"
    robot.ask("save_references", file=str(steps))
    used = exceeded(np.load(steps), TOOL_SPEED)
    print(f"{CUBES} cubes at speed {SPEED:g}; {found['real']}, {used}")
    assert code == 0, run.output
    assert sorted(run.placed) == sorted(cell.objects)
    assert {cycle["judged_by"] for cycle in found["cycles"]} == {"gripper and assumption"}
    assert used["beyond the positions [rad]"] < 1e-6
    assert max(used["velocity"], used["acceleration"]) <= 1.0
    assert 0.9 < used["tool speed"] <= 1.001
