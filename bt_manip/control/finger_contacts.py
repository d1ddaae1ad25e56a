"""What the fingers feel."""

import mujoco

from bt_manip.cell import BodyNames, entity_of
from bt_manip.robots import Robot

_REACH = 0.3  # [m] radius of the sensors' zone: all contacts of a finger, however long it is

Touched = tuple[tuple[str, ...], tuple[str, ...]]
"""Names of the entities that touch the first and the second finger."""


class FingerContacts:
    """Touch sensors in a robot's two fingers, and the names of what touches them.

    A touch sensor sums the normal forces of its body's contacts inside MuJoCo, so that a step
    costs no loop over contacts.
    """

    def __init__(self, robot: Robot):
        """Add the sensors to the robot's model, which must not be compiled yet."""
        self._robot = robot
        self.bound = False
        self._sensors = []
        for finger in robot.finger_bodies:
            name = f"{finger.name}_touch"
            # Group 5 is hidden in every viewer unless asked for.
            site = finger.add(
                "site", name=name, type="sphere", size=(_REACH,), group=5, rgba=(0, 0, 0, 0)
            )
            self._sensors.append(robot.mjcf_model.sensor.add("touch", name=name, site=site))

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Look at a compiled model."""
        left, right = (model.sensor(s.full_identifier).adr[0] for s in self._sensors)
        self._bound = data.sensordata.item, int(left), int(right)
        self._geoms = self._robot.finger_geom_ids
        self._model, self._data = model, data
        self._labels: BodyNames | None = None
        self.bound = True

    def forces(self) -> tuple[float, float]:
        """Give the normal force on each finger [N]."""
        force, left, right = self._bound
        return force(left), force(right)

    def names(self) -> Touched:
        """Name the entities that touch each finger, the robot itself apart."""
        left, right = (self._partners(geoms) for geoms in self._geoms)
        return left, right

    def _partners(self, geoms: tuple[int, ...]) -> tuple[str, ...]:
        if self._labels is None:
            self._labels = BodyNames(self._model)
        label = self._labels.of_geom
        own = entity_of(label[geoms[0]])
        found = set()
        for a, b in self._data.contact.geom.tolist():
            for mine, other in ((a, b), (b, a)):
                if mine in geoms and entity_of(label[other]) != own:
                    found.add(entity_of(label[other]))
        return tuple(sorted(found))
