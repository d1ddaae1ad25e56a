"""A cabinet with a drawer."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import ParametricEntity
from bt_manip.cell.objects import PrimitiveProp
from bt_manip.parameters import Parameter
from bt_manip.spatial import pointing_down

SIZE = (0.3, 0.24, 0.12)  # [m] of the cabinet along x, y and z
WALL = 0.01  # [m] thickness of all boards
GAP = 0.002  # [m] between the front of the drawer and the boards around it
HANDLE = (0.06, 0.016, 0.04)  # [m] length along x, thickness, height
GRIP = 0.04  # [m] distance of the handle's grasp from the front, for clearance of the fingers
PULLED = 0.18  # [m] displacement of the handle by `PullOpen` with an opening of 0.15 m
OVER, CLEAR = 0.12, 0.03  # [m] heights over the handle of the approach and the retreat
MASS = 1.5  # [kg] of the drawer
DAMPING = 10.0  # [N s/m] of the slide


class Drawer(ParametricEntity):
    """A cabinet with a drawer that slides towards -x; its origin is the centre of its bottom."""

    kind = "drawer"
    category = "drawer"
    free = False
    defaults = {
        "travel": Parameter("Travel", "m", 0.2, above=0.0, below=SIZE[0] - 2 * WALL),
        "resistance": Parameter(
            "Friction of the slide: force that moves the drawer slowly", "N", 5.0, above=0.0
        ),
        "colour": replace(PrimitiveProp.declared["colour"], default=(0.72, 0.53, 0.33)),
    }

    def _make_model(self, name: str) -> None:
        """Build the drawer, closed."""
        travel, resistance, colour = (self._parameters[key] for key in self.defaults)
        x, y, z = (0.5 * length for length in SIZE)
        self.travel = travel
        self._mjcf_root = root = mjcf.RootElement(model=name)
        root.default.geom.set_attributes(
            type="box", solref=(0.004, 1.0), friction=(0.8, 0.005, 1e-4)
        )
        half, pale_colour = 0.5 * WALL, (*(0.5 + 0.5 * part for part in colour), 1)[:4]
        cabinet = root.worldbody.add("body", name="cabinet")
        for size, pos in (
            ((x, y, half), (0, 0, half)),
            ((x, y, half), (0, 0, 2 * z - half)),
            ((x, half, z - WALL), (0, y - half, z)),
            ((x, half, z - WALL), (0, half - y, z)),
            ((half, y - WALL, z - WALL), (x - half, 0, z)),
        ):
            cabinet.add("geom", size=size, pos=pos, rgba=(*colour, 1)[:4])
        tray = cabinet.add("body", name="tray", pos=(-x, 0, z), gravcomp=1)
        self._joint = tray.add(
            "joint", name="slide", type="slide", axis=(-1, 0, 0), limited=True, range=(0, travel),
            damping=DAMPING, frictionloss=resistance, solimpfriction=(0.99, 0.99, 0.001, 0.5, 2),
        )  # fmt: skip
        wide, high, deep = y - WALL - GAP, z - WALL - GAP, x - WALL
        handle = tuple(0.5 * length for length in HANDLE)
        parts: tuple[tuple[Sequence[float], Sequence[float]], ...] = (
            ((half, wide, high), (half, 0, 0)),
            ((deep, wide, half), (deep, 0, half - high)),
            ((deep, half, 0.5 * high), (deep, wide - half, -0.5 * high)),
            ((deep, half, 0.5 * high), (deep, half - wide, -0.5 * high)),
            (handle, (-handle[0], 0, 0)),
        )
        for half_lengths, centre in parts:
            tray.add("geom", size=half_lengths, pos=centre, rgba=pale_colour, mass=MASS / 5)
        # The slide guides the drawer, not contacts of its boards.
        root.contact.add("exclude", name="tray_in_cabinet", body1=cabinet, body2=tray)

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model (composer's hook)."""
        self._data = physics.data.ptr
        joint = physics.model.ptr.joint(self._joint.full_identifier)
        self._position, self._velocity = int(joint.qposadr[0]), int(joint.dofadr[0])

    @property
    def opening(self) -> float:
        """Distance of the drawer from closed [m]."""
        return float(self._data.qpos[self._position])

    @property
    def speed(self) -> float:
        """Opening speed, negative while it closes [m/s]."""
        return float(self._data.qvel[self._velocity])

    @property
    def tool_targets(self) -> list[list[pin.SE3]]:
        """Poses of the tool at and over the handle, with the drawer closed and open by `PULLED`."""
        grasp, (x, _, z) = [], (-0.5 * SIZE[0] - GRIP, 0.0, 0.5 * SIZE[2])
        for pulled, height in ((0.0, OVER), (0.0, 0.0), (PULLED, 0.0), (PULLED, CLEAR)):
            position = (x - pulled, 0.0, z + height)
            grasp.append([pointing_down(position, yaw) for yaw in (0.0, np.pi)])
        return grasp

    @property
    def T_oh(self) -> pin.SE3:
        """Present pose of the grasp of its handle; the fingers close along y."""
        x = -0.5 * SIZE[0] - self.opening - GRIP
        return pin.SE3(np.eye(3), np.array([x, 0.0, 0.5 * SIZE[2]]))
