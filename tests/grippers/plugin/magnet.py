"""A plugin with a gripper that has no fingers: one face that things stick to."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bt_manip import hookimpl
from bt_manip.cell import BodyNames, entity_of
from bt_manip.exceptions import MotionError
from bt_manip.robots import GraspCandidates, Gripper

SETTLING = 0.05  # [s] of contact after which a grip is steady
PATIENCE = 0.2  # [s] without contact after which there is nothing to grip
GAP = 1e-3  # [m] between the face and the object at a grasp


class Magnet(Gripper):
    """Holds by MuJoCo's adhesion what its one contact body touches."""

    kind = "magnet"

    def _build(self, robot):
        super()._build(robot)
        table = self._description.read(robot.description.name)
        self._body = robot.find("body", table.needed_text("body"))
        table.finish()
        self._actuator = self._body.root.actuator.add(
            "adhesion", name="magnet", body=self._body, ctrlrange=[0.0, 1.0], gain=self.max_force
        )
        self._asked, self._touched, self._waited = 0.0, 0.0, 0.0

    def open(self):
        self._asked = self._touched = self._waited = 0.0

    def close(self, force):
        self._asked, self._touched, self._waited = self.check_force(force), 0.0, 0.0

    def stop(self):
        if not self.steady:
            self.open()

    @property
    def moving(self):
        return self._asked > 0.0 and not self.steady and not self.closed_on_nothing

    @property
    def is_open(self):
        return self._asked == 0.0

    @property
    def steady(self):
        return self._touched >= SETTLING

    @property
    def closed_on_nothing(self):
        return self._waited >= PATIENCE

    @property
    def is_free(self):
        return not self._touching(pressing=True)

    @property
    def held(self):
        names = BodyNames(self.robot.mj_model).of_body
        touching = {entity_of(names[body]) for body in self._touching()}
        return tuple(sorted(touching)) if self._asked else ()

    @property
    def forces(self):
        return (self._asked if self._touched else 0.0,)

    @property
    def status(self):
        return f"magnet pulls with {self._asked:.0f} N"

    @property
    def contact_bodies(self):
        return [self._body]

    def held_root(self):
        model = self.robot.mj_model
        roots = {int(model.body_rootid[body]) for body in self._touching()}
        free = [r for r in sorted(roots) if model.body_dofnum[r] == 6]
        return free[0] if free and self._asked else 0

    def set_opening(self, qpos, share=1.0):
        pass

    def grasp_generator(self, name, solids, geom_poses, com, rng):
        return TopFace(name, solids, com)

    def after_compile(self, physics, random_state):
        self._ctrl = physics.model.ptr.actuator(self._actuator.full_identifier).id

    def initialize_episode(self, physics, random_state):
        self.open()

    def before_substep(self, physics, random_state):
        self.robot.mj_data.ctrl[self._ctrl] = self._asked / self.max_force

    def after_substep(self, physics, random_state):
        if self._asked:
            dt = self.robot.mj_model.opt.timestep
            touches = bool(self._touching())
            self._touched = self._touched + dt if touches else 0.0
            self._waited = 0.0 if touches else self._waited + dt

    def _touching(self, pressing: bool = False) -> set[int]:
        """Give the bodies that press the face, or are near enough to be pulled by it."""
        model, data = self.robot.mj_model, self.robot.mj_data
        (face,) = self.contact_body_ids
        contact = data.contact
        counted = contact.efc_address >= 0 if pressing else slice(None)
        pairs = model.geom_bodyid[contact.geom[counted]]
        return {int(b) for b in pairs[:, ::-1][pairs == face]}

    def get_state(self) -> dict[str, Any]:
        return {"asked": self._asked, "touched": self._touched, "waited": self._waited}

    def set_state(self, state: Mapping[str, Any]) -> None:
        self._asked, self._touched = state["asked"], state["touched"]
        self._waited = state["waited"]


class TopFace:
    """Generates one grasp: straight from above, over the centre of mass."""

    def __init__(self, name, solids, com):
        self.name, self.solids, self.com = name, solids, np.array(com)

    def candidates(self, down):
        if any(solid.kind != "box" for solid in self.solids):
            raise MotionError(f"'{self.name}' has no flat top for a magnet", reason="grasp")
        height = max(float(s.support(-down[np.newaxis])[0]) for s in self.solids)
        x = np.cross(down, np.eye(3)[int(np.argmin(np.abs(down)))])
        x /= np.linalg.norm(x)
        return GraspCandidates(
            rotation=np.stack([x, np.cross(down, x), down], axis=1)[np.newaxis],
            position=(self.com - (height + self.com @ down + GAP) * down)[np.newaxis],
            width=np.zeros(1), opening=np.ones(1), costs={}, clear=True,
        )  # fmt: skip


@hookimpl
def register_grippers(register):
    register("magnet", Magnet)
