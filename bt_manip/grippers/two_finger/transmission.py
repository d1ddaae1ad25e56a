"""Between the motors of a gripper and its fingers."""

from typing import Protocol

import mujoco
import numpy as np

from .mechanism import Mechanism

Fingers = tuple[float, float, float, float]
"""Distances of the two fingers from the middle [m], and their velocities [m/s]."""


class Transmission(Protocol):
    """Turns joint motion into finger motion, and finger forces into what the motors make.

    Attributes:
        mass: What the force of one finger has to accelerate [kg].
        loss: Viscous friction of one finger [N s/m].
    """

    mass: float
    loss: float

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Look at a compiled model."""

    def read(self) -> Fingers:
        """Give where the fingers are and how they move."""

    def push(self, first: float, second: float) -> None:
        """Push each finger with a force, opening ones being positive [N]."""


def make_transmission(mechanism: Mechanism) -> Transmission:
    """Choose by how the fingers are moved."""
    return LinkedFingers(mechanism) if mechanism.travel.mass else SlidingFingers(mechanism)


class SlidingFingers:
    """Each finger is a slide with a motor of its own."""

    def __init__(self, mechanism: Mechanism) -> None:
        """Take a mechanism, which need not be compiled yet."""
        self._mechanism = mechanism
        self.mass = self.loss = 0.0

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Look at a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        u1, u2 = mechanism.ctrl_adr.tolist()
        # Together, because looking up attributes one by one takes longer than computing with them.
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2)
        self._motors = (data.ctrl, u1, u2)
        self.mass = float(model.dof_M0[[d1, d2]].mean())
        self.loss = float(model.dof_damping[[d1, d2]].mean())

    def read(self) -> Fingers:
        """Give where the fingers are and how they move."""
        position, velocity, p1, p2, d1, d2 = self._bound
        return position(p1), position(p2), velocity(d1), velocity(d2)

    def push(self, first: float, second: float) -> None:
        """Push each finger with a force, opening ones being positive [N]."""
        ctrl, u1, u2 = self._motors
        ctrl[u1] = first
        ctrl[u2] = second


class LinkedFingers:
    """Each finger follows a joint by a mechanism; one motor moves both, or one each.

    What a force at a finger is at the motor follows from the velocities: power is the same. What
    friction and springs of the mechanism take is left to who measures the force.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Take a mechanism, which need not be compiled yet."""
        self._mechanism = mechanism
        travel = mechanism.travel
        self.mass, self.loss = travel.mass, travel.loss
        self._ways = [tuple(way.tolist()) for way in travel.polynomials]
        self._slopes = [
            tuple((np.arange(1, way.size) * way[1:]).tolist()) for way in travel.polynomials
        ]
        self._r1, self._r2 = travel.ratios.tolist()
        self._at = (0.0, 0.0)

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Look at a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2)
        self._ctrl, self._motors = data.ctrl, mechanism.ctrl_adr.tolist()

    def read(self) -> Fingers:
        """Give where the fingers are and how they move."""
        position, velocity, p1, p2, d1, d2 = self._bound
        q1, q2 = self._at = position(p1), position(p2)
        (way1, way2), (slope1, slope2) = self._ways, self._slopes
        return (
            _polynomial(way1, q1),
            _polynomial(way2, q2),
            _polynomial(slope1, q1) * velocity(d1),
            _polynomial(slope2, q2) * velocity(d2),
        )

    def push(self, first: float, second: float) -> None:
        """Push each finger with a force, opening ones being positive [N]; where last read."""
        q1, q2 = self._at
        slope1, slope2 = self._slopes
        effort1 = first * _polynomial(slope1, q1) * self._r1
        effort2 = second * _polynomial(slope2, q2) * self._r2
        if len(self._motors) == 1:
            self._ctrl[self._motors[0]] = effort1 + effort2
        else:
            self._ctrl[self._motors[0]] = effort1
            self._ctrl[self._motors[1]] = effort2


def _polynomial(coefficients: tuple[float, ...], x: float) -> float:
    """Evaluate by Horner's rule, the constant coming first."""
    value = 0.0
    for c in reversed(coefficients):
        value = value * x + c
    return value
