"""The gripper: a magnet, with the methods of every kind and `is_free`."""

import numpy as np
from bt_manip.exceptions import MotionError
from bt_manip.robots import GraspCandidates, Gripper

SETTLING = 0.05  # [s] duration of contact after which a grip is steady
GAP = 1e-3  # [m] distance of the face from the object at a grasp


class Gear(Gripper):
    """Holds an object at its face by adhesion."""

    kind = "gear"  # its registered name
    memory = ("_force", "_contact")  # state that changes during a run

    def _build(self, robot):
        super()._build(robot)
        table = self._description.read(robot.description.name)  # a TomlTable
        self._face = robot.find("body", table.needed_text("face"))
        table.finish()  # no other keys under [gripper]
        self._actuator = self._face.root.actuator.add(
            "adhesion", name="magnet", body=self._face, ctrlrange=[0.0, 1.0], gain=self.max_force
        )
        self._force, self._contact = 0.0, 0.0  # [N], [s]

    def open(self):
        """Switch the magnet off."""
        self._force, self._contact = 0.0, 0.0

    def close(self, force):
        """Switch the magnet on, with a force [N]."""
        self._force, self._contact = self.check_force(force), 0.0

    @property
    def is_open(self):
        """Whether the magnet is off."""
        return self._force == 0.0

    @property
    def steady(self):
        """Whether an object has been held for `SETTLING`."""
        return self._contact >= SETTLING

    @property
    def forces(self):
        """Force on the held object [N]."""
        return (self._force if self._contact else 0.0,)

    @property
    def is_free(self):
        """Whether nothing presses the face, so that the tool may move away."""
        return not self._roots(self.robot.mj_data.contact.efc_address >= 0).size

    def held_root(self):
        """Return the root body of the free object at the face; 0: none."""
        roots = self._roots(slice(None))
        free = roots[self.robot.mj_model.body_dofnum[roots] == 6]
        return int(free.min()) if free.size and self._force else 0

    def _roots(self, contacts):
        """Return the root bodies that touch the face in the given contacts."""
        model, data = self.robot.mj_model, self.robot.mj_data
        pairs = model.geom_bodyid[data.contact.geom[contacts]]
        return model.body_rootid[pairs[:, ::-1][np.isin(pairs, self.contact_body_ids)]]

    def set_opening(self, qpos, share=1.0):
        """Do nothing: the gripper has no joints."""

    def grasp_generator(self, name, solids, geom_poses, com, rng):
        """Return the grasps of an object."""
        return TopFace(name, solids, com)

    # Composer calls these.

    def after_compile(self, physics, random_state):
        """Find the actuator in the compiled model."""
        self._ctrl = physics.model.ptr.actuator(self._actuator.full_identifier).id

    def initialize_episode(self, physics, random_state):
        """Start open."""
        self.open()

    def before_substep(self, physics, random_state):
        """Command the actuator."""
        self.robot.mj_data.ctrl[self._ctrl] = self._force / self.max_force

    def after_substep(self, physics, random_state):
        """Measure the duration of the contact."""
        step = self.robot.mj_model.opt.timestep
        self._contact = self._contact + step if self.held_root() else 0.0


class TopFace:
    """Generates one grasp: from above, at the centre of mass of an object of boxes."""

    def __init__(self, name, solids, com):
        """Store the object."""
        self.name, self.solids, self.com = name, solids, np.array(com)

    def candidates(self, down):
        """Return the grasp; the z axis of the tool is the approach direction."""
        if any(solid.kind != "box" for solid in self.solids):
            raise MotionError(f"'{self.name}' has no flat top", reason="grasp")
        height = max(float(solid.support(-down[np.newaxis])[0]) for solid in self.solids)
        x = np.cross(down, np.eye(3)[int(np.argmin(np.abs(down)))])
        x /= np.linalg.norm(x)
        return GraspCandidates(
            rotation=np.stack([x, np.cross(down, x), down], axis=1)[np.newaxis],
            position=(self.com - (height + self.com @ down + GAP) * down)[np.newaxis],
            width=np.zeros(1), opening=np.ones(1), costs={}, clear=True,
        )  # fmt: skip
