"""A push button."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import ParametricEntity
from bt_manip.cell.objects import PrimitiveProp
from bt_manip.parameters import Parameter
from bt_manip.spatial import pointing_down

RADIUS = 0.025  # [m]
HOUSING = 0.02  # [m] height
PRESSED = 0.95
"""Fraction of the travel beyond which the cap counts as pressed; its stop is soft."""

HOVER = 0.07  # [m] height of the tool over the cap before pressing
PRELOAD = 0.2  # fraction of the full force at which the cap starts to move


class PushButton(ParametricEntity):
    """A housing with a cap on a spring; its origin is the centre of its bottom.

    Attributes:
        presses: Number of times that the cap was pressed since the creation of the button.
        pressed_at: Simulated time of the last press [s]; None if it was never pressed.
    """

    kind = "push_button"
    category = "button"
    free = False
    defaults = {
        "travel": Parameter("Travel of the cap", "m", 0.008, above=0.0, at_most=HOUSING),
        "force": Parameter("Force at the end of the travel", "N", 10.0, above=0.0),
        "colour": replace(PrimitiveProp.declared["colour"], default=(0.8, 0.1, 0.1)),
    }

    def _make_model(self, name: str) -> None:
        """Build the button."""
        travel, force, colour = (self._parameters[key] for key in self.defaults)
        self.travel = travel
        self.presses, self._down = 0, False
        self.pressed_at: float | None = None
        self._mjcf_root = root = mjcf.RootElement(model=name)
        housing = root.worldbody.add("body", name="housing")
        housing.add(
            "geom", name="housing", type="cylinder", size=(1.3 * RADIUS, HOUSING / 2),
            pos=(0, 0, HOUSING / 2), rgba=(0.25, 0.25, 0.27, 1),
        )  # fmt: skip
        # Without gravity, so that it works in any orientation.
        cap = housing.add("body", name="cap", pos=(0, 0, HOUSING), gravcomp=1)
        stiffness = (1.0 - PRELOAD) * force / travel
        self._joint = cap.add(
            "joint", name="press", type="slide", axis=(0, 0, -1), limited=True, range=(0, travel),
            stiffness=stiffness, springref=-PRELOAD * force / stiffness, damping=1.0,
            solreflimit=(0.004, 1),  # the default lets the preload lift the cap by 1.5 mm
        )  # fmt: skip
        cap.add(
            "geom", name="cap", type="cylinder", size=(RADIUS, travel / 2 + 0.001),
            pos=(0, 0, travel / 2 + 0.001), mass=0.05, rgba=(*colour, 1)[:4],
        )  # fmt: skip
        # The cap sinks into the housing.
        root.contact.add("exclude", name="cap_in_housing", body1=housing, body2=cap)

    @property
    def height(self) -> float:
        """Height of the released cap's top over the bottom [m]."""
        return HOUSING + self.travel + 0.002

    @property
    def tool_targets(self) -> list[list[pin.SE3]]:
        """Poses of the tool on the cap, and over it at the smallest height of `Hover`."""
        heights = (self.height, self.height + HOVER)
        return [[pointing_down((0.0, 0.0, z), k * np.pi / 4) for k in range(8)] for z in heights]

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model (composer's hook)."""
        self._data = physics.data.ptr
        self._address = int(physics.model.ptr.joint(self._joint.full_identifier).qposadr[0])

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Count the presses (composer's hook)."""
        depth = self.depth
        if self._down:
            self._down = self.pressed
        elif depth >= PRESSED * self.travel:
            self._down, self.presses = True, self.presses + 1
            self.pressed_at = float(self._data.time)

    @property
    def depth(self) -> float:
        """Depth of the cap below its released position [m]."""
        return float(self._data.qpos[self._address])

    @property
    def pressed(self) -> bool:
        """Whether the cap is below half of its travel."""
        return self.depth > 0.5 * self.travel

    def get_state(self) -> dict[str, Any]:
        """Return the presses, for snapshots."""
        return {"presses": self.presses, "pressed_at": self.pressed_at, "down": self._down}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`."""
        self.presses, self._down = state["presses"], state["down"]
        self.pressed_at = state["pressed_at"]
