"""Switching between the controllers of a robot."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from bt_manip.packages import suggestion
from bt_manip.robots import Robot

from .controller import Controller
from .exceptions import ControlError
from .reference import Reference

Factory = Callable[[Robot], Controller]


class ControllerManager(composer.Entity):
    """Runs one of several controllers of a robot, and switches without a step in torque.

    The manager is attached to the robot (``robot.attach(manager)``) before the model is compiled,
    and passes composer's hooks on to the active controller. Other controllers are created on first
    use; this needs no compilation, because controllers do not change the physics.

    Attributes:
        controller: The active controller.
        active: Its name.
        default: Name of the controller at the start of a cycle.
    """

    def _build(self, robot: Robot, factories: Mapping[str, Factory], default: str) -> None:
        """Create the default controller.

        Args:
            robot: The robot to control.
            factories: Factories of the controllers, by name.
            default: Name of the controller at the start of a cycle.

        Raises:
            ControlError: If there is no such controller.
        """
        self._mjcf_root = mjcf.RootElement(model="controllers")
        self._robot, self._factories, self.default = robot, factories, default
        self._made: dict[str, Controller] = {}
        self._compiled: tuple[mjcf.Physics, np.random.RandomState] | None = None
        self.active, self._returning = default, False
        self.controller: Controller = self.get(default)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model for composer to attach."""
        return self._mjcf_root

    @property
    def reference(self) -> Reference:
        """The reference of the active controller."""
        return self.controller.reference

    @reference.setter
    def reference(self, reference: Reference | None) -> None:
        self.controller.reference = reference

    def get(self, name: str) -> Controller:
        """Return a controller by name, active or not.

        Raises:
            ControlError: If there is no such controller.
        """
        if name not in self._made:
            if name not in self._factories:
                near = suggestion("controller", name, self._factories)
                raise ControlError(f"no controller is called '{name}'{near}")
            made = self._factories[name](self._robot)
            if self._compiled:
                made.share_model(self.controller)
                made.after_compile(*self._compiled)
            self._made[name] = made
        return self._made[name]

    def switch(self, name: str) -> None:
        """Activate another controller without a step in torque, see `Controller.take_over`.

        Raises:
            ControlError: If there is no such controller.
            ControllerFault: If it cannot compute torques for the present state.
        """
        controller = self.get(name)
        self._returning = False
        if controller is not self.controller:
            controller.take_over(self.controller)
            self.active, self.controller = name, controller

    def add(self, name: str, factory: Factory) -> None:
        """Add or replace the factory of a controller, which is created on first use."""
        self._factories = {**self._factories, name: factory}

    def activate(self, name: str) -> None:
        """Activate another controller immediately, without a transfer of torques.

        Raises:
            ControlError: If there is no such controller.
        """
        previous, controller = self.controller, self.get(name)
        if controller is not previous:  # it starts anew
            controller.reset()
            controller.saturated_steps = previous.saturated_steps
        controller.reference = previous.reference
        self.active, self.controller, self._returning = name, controller, False

    def return_to_default(self) -> None:
        """Switch to the default controller as soon as the reference is at rest.

        An arm in contact may be far from a moving reference, and another controller would pull it
        there. At rest, the new controller holds the measured configuration.
        """
        self._returning = self.active != self.default

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind all controllers to the compiled model."""
        self._compiled = physics, random_state
        for controller in self._made.values():
            controller.after_compile(physics, random_state)

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Activate the default controller, without a transfer."""
        self.activate(self.default)
        self.controller.initialize_episode(physics, random_state)

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the torques of the active controller."""
        if self._returning and not self.controller.reference.v.any():
            self.switch(self.default)
        self.controller.before_substep(physics, random_state)

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Advance the reference."""
        self.controller.after_substep(physics, random_state)

    # State

    def get_state(self) -> dict[str, Any]:
        """Return the active controller and its state as plain data."""
        return {
            "active": self.active,
            "returning": self._returning,
            "controller": self.controller.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of ``get_state``.

        Raises:
            ControlError: If the controller of the state is unknown.
        """
        reference, controller = self.controller.reference, self.get(state["active"])
        controller.reference = reference
        controller.set_state(state["controller"])
        self.active, self.controller = state["active"], controller
        self._returning = state["returning"]
