"""Check commanded positions with franka-sim's own tables, in an environment that has that package.

``python check_with_franka_sim.py MOTIONS.npz``, with the positions of each motion at 1 kHz [rad],
(n, 7), prints the number of motions, and the first violation of each that has one.
"""

import logging
import sys

import numpy as np
from franka_sim.control_modes import ControlMode
from franka_sim.limits.checker import MotionLimitChecker


def violation(rows: list[list[float]]) -> str:
    """Return the first violation of a motion from rest to rest; empty without one."""
    checker, zero = MotionLimitChecker(enforce=True), [0.0] * 7
    state = {"q": rows[0], "q_d": rows[0], "dq_d": zero, "ddq_d": zero}
    checker.start_motion(ControlMode.POSITION, state)
    for number, row in enumerate(rows):
        command = {"q_c": row, "message_id": number + 1}
        found = checker.check(command, row)
        if found is not None:
            return f"row {number}: {found.describe()}"
        checker.record(command)
    return ""


if __name__ == "__main__":
    logging.disable(logging.ERROR)
    motions = np.load(sys.argv[1])
    found = {name: violation(motions[name].tolist()) for name in motions}
    print(len(found))
    for name, text in found.items():
        if text:
            print(f"{name}: {text}")
