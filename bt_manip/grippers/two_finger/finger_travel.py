"""Travel of the fingers of a gripper as a function of its joints."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

_MARGIN = 1.2  # factor on the motors' efforts, for friction


@dataclass(frozen=True, eq=False)
class FingerTravel:
    """Travel of two fingers as a function of their joints.

    The opening is the distance between the parts of the fingers from the tool centre point to the
    tips, along their relative motion. Each finger has a distance s from the centre; the opening is
    the sum of both. With one motor, each s is half the opening, even if only one finger moves. By
    the principle of virtual work, a force of 1 N at the finger requires an effort of ds/dq at the
    joint.

    Attributes:
        open_width: Maximum opening [m].
        min_width: Minimum opening [m].
        polynomials: Coefficients of s(q) for each finger, the constant first.
        holding: Coefficients of each motor's effort against springs as a function of q.
        ratios: Velocity of each finger's joint per velocity of the motor.  # (2,)
        mass: Effective mass of one finger along s [kg]; 0: that of the joint in the model.
        loss: Viscous friction of one finger, along s [N s/m].
        friction: Dry friction of one finger, along s [N].
        joints: Names of all joints that move with the fingers.
        widths: Openings at which `positions` were measured, increasing [m].  # (m,)
        positions: Positions of the joints at `widths`.  # (m, len(joints))
        columns: Indices of the joints of the two fingers in `joints`.
        closing: Direction from the second to the first finger in the tool frame; unit.  # (3,)
        centre: Coordinate along `closing` of the midpoint between the fingers in the tool frame, at
            zero opening [m], and its change per opening: 0.5 if the second finger is fixed.
    """

    open_width: float
    min_width: float
    polynomials: tuple[np.ndarray, np.ndarray]
    holding: tuple[np.ndarray, np.ndarray]
    ratios: np.ndarray
    mass: float
    loss: float
    friction: float
    joints: tuple[str, ...]
    widths: np.ndarray
    positions: np.ndarray
    columns: tuple[int, int]
    closing: np.ndarray
    centre: tuple[float, float]

    @property
    def one_moves(self) -> bool:
        """Whether the second finger is fixed."""
        return self.centre[1] != 0.0

    def configuration(self, width: float) -> np.ndarray:
        """Return the positions of all moving joints at an opening [m]."""  # (len(joints),)
        return np.array([np.interp(width, self.widths, column) for column in self.positions.T])

    def efforts(self, force: float, *, together: bool) -> list[float]:
        """Return the maximum effort of each motor for a finger force, plus 20 % for friction.

        Args:
            force: Force of each finger [N].
            together: Whether one motor moves both.
        """
        efforts, springs = [], []
        for polynomial, holding, ratio, column in zip(
            self.polynomials, self.holding, self.ratios, self.columns, strict=True
        ):
            q = self.positions[:, column]
            slope = Polynomial(polynomial).deriv()(q)
            efforts.append(_MARGIN * force * float(np.abs(slope * ratio).max()))
            springs.append(float(np.abs(Polynomial(holding)(q)).max()))
        if together:
            return [sum(efforts) + springs[0]]
        return [effort + spring for effort, spring in zip(efforts, springs, strict=True)]

    def force(self, effort: float, *, together: bool) -> float:
        """Return the force of each finger that a motor effort ensures at all openings [N]."""
        zero = self.efforts(0.0, together=together)[0]
        one = self.efforts(1.0, together=together)
        return max(effort - zero, 0.0) / (max(one) - zero)
