"""The cup in a robot's model: its body, its lip and its adhesion actuator."""

from typing import Any

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.cell import literal_name
from bt_manip.exceptions import did_you_mean
from bt_manip.grippers import BodySurface
from bt_manip.robots import Robot, RobotError, site_pose

from ..touch import add_touch_sensor
from .lip import LIP_RADIUS, LIP_TRAVEL, MAX_SAG, ring
from .parameters import SuctionParameters

_NAME = "suction_cup"
_BELL = 0.5  # height of the bell in diameters
_STEM = 0.3  # diameter of the stem in diameters
_MASSES = (1e-3, 0.015, 0.03)  # [kg] of each sphere of the lip, of bell and stem
_SOLMIX = 1e6  # weight of the lip's contact parameters; that of other geoms is 1
_SOLREF = (0.004, 1.0)
_SOLIMP = (0.95, 0.95, 0.001)  # a stiffer lip bounces off light objects, a softer one creeps
_RUBBER = (0.13, 0.14, 0.16, 1.0)
_METAL = (0.62, 0.64, 0.67, 1.0)


def adhesion_actuators(root: Any) -> list[Any]:
    """Return the adhesion actuators of a PyMJCF model; the body of each is a suction cup.

    MuJoCo saves them as general actuators, of which no others act on a body.
    """
    found = root.find_all("actuator")
    return [actuator for actuator in found if getattr(actuator, "body", None) is not None]


class Cup:
    """A suction cup: a body with an adhesion actuator, which pulls along the contact normals.

    A cup built here has a ring of small spheres as its lip, so that balls reach into it. A cup of
    the model may have a single contact. A lip of radius r pressed on with a force F resists bending
    moments up to r F, beyond which it would tip over its edge; the lip's rolling and torsional
    friction model this. Sliding friction is the object's.

    Args:
        robot: The robot, not compiled yet.
        parameters: Parameters of the cup.

    Attributes:
        body: The cup's body (a PyMJCF element).
        actuator: Its adhesion actuator.
        radius: Radius of the lip [m].
        hollow: Whether round faces reach into it.

    Raises:
        RobotError: If the model lacks the described actuator, has several and none is named, or the
            cup has no collision geometry.
    """

    def __init__(self, robot: Robot, parameters: SuctionParameters) -> None:
        self.actuator = _find_actuator(robot, parameters.actuator)
        if self.actuator is None:
            self.body = _build(robot, parameters)
            self.actuator = self.body.root.actuator.add("adhesion", name=_NAME, body=self.body)
            lip = [geom for geom in self.body.geom if geom.type == "sphere"]
            self.hollow = True
        else:
            self.hollow = False
            self.body = self.actuator.body
            lip = self.body.find_all("geom", immediate_children_only=True)
        if parameters.holding_force is not None:
            key = "gain" if self.actuator.tag == "adhesion" else "gainprm"
            gain = {key: parameters.holding_force}
            self.actuator.set_attributes(ctrlrange=(0.0, 1.0), **gain)
        diameter = parameters.diameter or _measure(robot, self.body)
        self.radius = 0.5 * diameter
        lever = 0.5 * self.radius if self.hollow else self.radius
        for geom in lip:
            geom.set_attributes(
                gap=LIP_TRAVEL, condim=6, friction=(0.0, lever, lever),
                priority=0, solmix=_SOLMIX, solref=_SOLREF, solimp=_SOLIMP,
            )  # fmt: skip
        self._sensor = add_touch_sensor(self.body, f"{_NAME}_touch")

    def bind(self, model: mujoco.MjModel) -> None:
        """Bind to a compiled model.

        Sets ``max_force`` [N], the holding force, ``gain`` [N], the force for a control signal of
        1, the addresses ``ctrl`` and ``sensor``, and the ids ``geoms`` of the body's geoms.
        """
        actuator = model.actuator(self.actuator.full_identifier)
        self.ctrl, self.gain = int(actuator.id), float(actuator.gainprm[0])
        self.max_force = self.gain * float(actuator.ctrlrange[1])
        self.sensor = int(model.sensor(self._sensor.full_identifier).adr[0])
        body = int(model.body(self.body.full_identifier).id)
        self.geoms = np.flatnonzero(model.geom_bodyid == body)


def _find_actuator(robot: Robot, name: str | None) -> Any:
    """Return the adhesion actuator with a name, or the only one; None without any."""
    found = adhesion_actuators(robot.gripper_root)
    names = [literal_name(actuator.name or "") for actuator in found]
    where = robot.description.where
    if name is not None:
        if name not in names:
            raise RobotError(
                f"{where}: the model has no adhesion actuator '{name}'{did_you_mean(name, names)}"
            )
        return found[names.index(name)]
    if len(found) > 1:
        raise RobotError(
            f"{where}: the model has {len(found)} adhesion actuators: name one of "
            f"{', '.join(names)} as 'gripper.actuator'"
        )
    return found[0] if found else None


def _build(robot: Robot, parameters: SuctionParameters) -> Any:
    """Add a cup to the body of the tool frame, with its lip at the frame and its axis along z."""
    site = robot.tool_site
    pose = {
        key: value
        for key in ("pos", "quat", "euler", "axisangle", "xyaxes", "zaxis")
        if (value := getattr(site, key, None)) is not None
    }
    body = site.parent.add("body", name=_NAME, **pose)
    assert parameters.diameter is not None
    diameter, end = parameters.diameter, -parameters.length
    hollow = -0.5 * MAX_SAG * diameter - 2.0 * LIP_RADIUS  # a ball reaches into the cup
    bell = max(hollow - _BELL * diameter, 0.5 * (hollow + end))
    for number, point in enumerate(ring(0.5 * diameter - LIP_RADIUS)):
        body.add(
            "geom", name=f"{_NAME}_lip{number}", type="sphere", size=(LIP_RADIUS,),
            pos=(point[0], point[1], -LIP_RADIUS), mass=_MASSES[0], rgba=_RUBBER,
        )  # fmt: skip
    body.add(
        "geom", name=f"{_NAME}_skirt", type="cylinder", size=(0.5 * diameter - LIP_RADIUS,),
        fromto=(0, 0, -LIP_RADIUS, 0, 0, hollow), contype=0, conaffinity=0, mass=0, rgba=_RUBBER,
    )  # fmt: skip
    for name, first, last, width, mass, rgba in (
        ("bell", hollow, bell, diameter, _MASSES[1], _RUBBER),
        ("stem", bell, end, _STEM * diameter, _MASSES[2], _METAL),
    ):
        body.add(
            "geom", name=f"{_NAME}_{name}", type="cylinder", size=(0.5 * width,), mass=mass,
            fromto=(0, 0, first, 0, 0, last), rgba=rgba,
        )  # fmt: skip
    return body


def _measure(robot: Robot, body: Any) -> float:
    """Return the width of a cup orthogonal to the tool's z axis: the smaller of x and y [m]."""
    model, data = robot.alone, mujoco.MjData(robot.alone)
    mujoco.mj_kinematics(model, data)
    number, tool = (
        int(model.body(one.full_identifier).id) for one in (body, robot.tool_site.parent)
    )
    T_wc, T_wb = (spatial.pose(data.xpos[b], data.xquat[b]) for b in (number, tool))
    T_wt = T_wb * site_pose(model, robot.tool_site)
    surface = BodySurface(model, number).beyond(T_wt.actInv(T_wc), -np.inf)
    if not len(surface):
        where, name = robot.description.where, model.body(number).name
        raise RobotError(f"{where}: the cup '{name}' has no collision geometry")
    return float(np.ptp(surface, axis=0)[:2].min())
