"""The models of simulated real cells, made from the scene files that bt-manip runs with."""

import os
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip import spatial
from bt_manip.plugins import build_station

PARKED = 3.0  # [m] above the floor, where objects wait without weight
TYPES = {
    int(t): t.name.removeprefix("mjGEOM_").lower() for t in mujoco.mjtGeom.__members__.values()
}

SCENE = """
[[robots]]
name = "arm"
position = [-0.1, 0.0, 1.015]

[[objects]]
model = "table"

[[objects]]
model = "basket"
on = "table"
position = [{x}, {y}]
rpy = [0.0, 0.0, {yaw}]
"""
CUBE = """
[[objects]]
model = "cube"
name = "cube_{number}"
on = "table"
position = [{x:.3f}, {y:.3f}]
rpy = [0.0, 0.0, {yaw:.3f}]
size = {size}
expected = true
"""
SEEN = """
[[objects]]
model = "cube"
on = "table"
position = [0.3, 0.0]
size = 0.07
expected = true

[[objects]]
model = "depth_camera"
name = "eye"
mount = "arm"
position = [0.07, 0.0, -0.06]
rpy = [3.141592653589793, 0.0, 0.0]
"""
CUBES = int(os.environ.get("CUBES", "1"))
CUBE_SIZE = 0.03  # [m]: twenty of them fit into the basket


class Places(NamedTuple):
    """Where a basket stands, and cubes come, on the table."""

    basket: tuple[float, float, float] = (0.6, 0.0, np.pi / 2)  # position [m] and angle [rad]
    lowest: tuple[float, float] = (0.2, -0.3)  # coordinates of cubes [m]
    highest: tuple[float, float] = (0.4, 0.3)


BEFORE_THE_FR3 = Places()


def write_scene(path: Path, cubes: int, places: Places = BEFORE_THE_FR3, seed: int = 0) -> None:
    """Write a scene file with a table, a basket and cubes to come at random poses."""
    rng = np.random.default_rng(seed)
    x, y, yaw = places.basket
    text = SCENE.format(x=x, y=y, yaw=yaw)
    for number in range(1, cubes + 1):
        (x, y), yaw = rng.uniform(places.lowest, places.highest), rng.uniform(-np.pi, np.pi)
        text += CUBE.format(number=number, x=x, y=y, yaw=yaw, size=CUBE_SIZE)
    path.write_text(text)


def write_seen_scene(path: Path, places: Places = BEFORE_THE_FR3) -> None:
    """Write a scene file with a table, a basket, a cube of 7 cm to come and a camera on the arm."""
    x, y, yaw = places.basket
    path.write_text(SCENE.format(x=x, y=y, yaw=yaw) + SEEN)


class RealCell(NamedTuple):
    """What the simulated cell has beside the arm: poses in the world."""

    objects: dict[str, pin.SE3]  # to come
    basket: pin.SE3


def write_model(scene: Path, arm: Path, path: Path, robot: str = "fr3") -> RealCell:
    """Write a model of the arm with the fixtures of a scene, and the objects that it expects.

    Args:
        scene: The scene file.
        arm: The arm's MJCF file.
        path: The file to write.
        robot: The arm's name in bt-manip.
    """
    station = build_station(scene=str(scene), robot=robot, poses="scene")
    cell, root = station.cell, ET.parse(arm).getroot()
    compiler = root.find("compiler")
    compiler.set("meshdir", str((arm.parent / compiler.get("meshdir", "")).resolve()))
    world = root.find("worldbody")
    (base,) = world
    data = station.robot.mj_data.body(f"arm/{base.get('name')}")
    _set_pose(base, spatial.pose(data.xpos, data.xquat))
    objects = {}
    for fixture in station.scene.objects:
        if fixture.expected:
            assert station.poses.add(station.poses.next().name)
        entity, pose = cell.find(fixture.name), cell.pose(fixture.name)
        if fixture.model == "depth_camera":
            flange = list(base.iter("body"))[-1]
            T_wt = station.arm.model.pose(station.robot.q)
            data = station.robot.mj_data.body(f"arm/{flange.get('name')}")
            camera = ET.SubElement(flange, "camera", name=fixture.name, fovy="50")
            _set_pose(camera, spatial.pose(data.xpos, data.xquat).actInv(T_wt * pose))
            continue
        body = ET.SubElement(world, "body", name=fixture.name)
        if fixture.expected:
            objects[fixture.name] = pose
            cell.remove(fixture.name)
            pose = pin.SE3(np.eye(3), np.array([0.2 * len(objects), 2.0, PARKED]))
            ET.SubElement(body, "freejoint")
        _set_pose(body, pose)
        _add_geoms(body, mjcf.Physics.from_mjcf_model(entity.mjcf_model).model.ptr)
    for key in root.findall("keyframe"):
        root.remove(key)
    ET.ElementTree(root).write(path)
    return RealCell(objects, cell.pose("basket"))


def _add_geoms(body: ET.Element, model: mujoco.MjModel) -> None:
    """Add the colliding geoms and the inertia of an object that is one body."""
    (number,) = set(model.geom_bodyid[model.geom_contype > 0])
    ET.SubElement(
        body, "inertial", pos=_text(model.body_ipos[number]), quat=_text(model.body_iquat[number]),
        mass=_text(model.body_mass[[number]]), diaginertia=_text(model.body_inertia[number]),
    )  # fmt: skip
    for geom in np.flatnonzero(model.geom_contype):
        ET.SubElement(
            body, "geom", type=TYPES[model.geom_type[geom]], size=_text(model.geom_size[geom]),
            pos=_text(model.geom_pos[geom]), quat=_text(model.geom_quat[geom]),
            friction=_text(model.geom_friction[geom]), solref=_text(model.geom_solref[geom]),
            solimp=_text(model.geom_solimp[geom]),
        )  # fmt: skip


def _set_pose(body: ET.Element, pose: pin.SE3) -> None:
    body.set("pos", _text(pose.translation))
    body.set("quat", _text(spatial.quat_wxyz(pose)))


def _text(numbers: np.ndarray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
