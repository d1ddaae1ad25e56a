"""Transmissions between the motors of a gripper and its fingers."""

import mujoco
import numpy as np

from .mechanism import Mechanism

Fingers = tuple[float, float, float, float]
"""Distances of the two fingers from the centre [m], and their velocities [m/s]."""


class SlidingFingers:
    """Transmission of fingers on slides with a motor each: s = offset + sign * q.

    Attributes:
        mass: Effective mass of one finger [kg].
        loss: Viscous friction of one finger [N s/m].
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self.mass = self.loss = 0.0

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Bind to a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        u1, u2 = mechanism.ctrl_adr.tolist()
        (b1, a1), (b2, a2) = (p.tolist() for p in mechanism.travel.polynomials)
        # One tuple: separate attribute lookups would take longer than the computation.
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2, b1, b2, a1, a2)
        self._motors = (data.ctrl, u1, u2, a1, a2)
        self.mass = float(model.dof_M0[[d1, d2]].mean())
        self.loss = float(model.dof_damping[[d1, d2]].mean())

    def read(self) -> Fingers:
        """Return the positions and velocities of the fingers."""
        position, velocity, p1, p2, d1, d2, b1, b2, a1, a2 = self._bound
        return (
            b1 + a1 * position(p1),
            b2 + a2 * position(p2),
            a1 * velocity(d1),
            a2 * velocity(d2),
        )

    def push(self, first: float, second: float) -> None:
        """Apply a force to each finger, positive to open [N]."""
        ctrl, u1, u2, a1, a2 = self._motors
        ctrl[u1] = a1 * first
        ctrl[u2] = a2 * second


class LinkedFingers:
    """Transmission of fingers that follow a joint each, with one motor for both or one each.

    Motor efforts follow from finger forces by the principle of virtual work, plus the efforts that
    balance springs. Friction of the mechanism is compensated by force feedback, not here.

    Attributes:
        mass: Effective mass of one finger [kg].
        loss: Viscous friction of one finger [N s/m].
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        travel = mechanism.travel
        self.mass, self.loss = travel.mass, travel.loss
        self._travels = [tuple(p.tolist()) for p in travel.polynomials]
        self._slopes = [tuple((np.arange(1, p.size) * p[1:]).tolist()) for p in travel.polynomials]
        self._hold1, self._hold2 = (tuple(p.tolist()) for p in travel.holding)
        self._r1, self._r2 = travel.ratios.tolist()
        self._at = (0.0, 0.0)

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Bind to a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2)
        self._ctrl, self._motors = data.ctrl, mechanism.ctrl_adr.tolist()

    def read(self) -> Fingers:
        """Return the positions and velocities of the fingers."""
        position, velocity, p1, p2, d1, d2 = self._bound
        q1, q2 = self._at = position(p1), position(p2)
        (travel1, travel2), (slope1, slope2) = self._travels, self._slopes
        return (
            _polynomial(travel1, q1),
            _polynomial(travel2, q2),
            _polynomial(slope1, q1) * velocity(d1),
            _polynomial(slope2, q2) * velocity(d2),
        )

    def push(self, first: float, second: float) -> None:
        """Apply a force to each finger, positive to open [N], at the last read positions."""
        q1, q2 = self._at
        slope1, slope2 = self._slopes
        effort1 = first * _polynomial(slope1, q1) * self._r1 + _polynomial(self._hold1, q1)
        effort2 = second * _polynomial(slope2, q2) * self._r2 + _polynomial(self._hold2, q2)
        if len(self._motors) == 1:
            self._ctrl[self._motors[0]] = effort1 + effort2
        else:
            self._ctrl[self._motors[0]] = effort1
            self._ctrl[self._motors[1]] = effort2


def _polynomial(coefficients: tuple[float, ...], x: float) -> float:
    """Evaluate a polynomial by Horner's rule, constant coefficient first."""
    value = 0.0
    for c in reversed(coefficients):
        value = value * x + c
    return value
