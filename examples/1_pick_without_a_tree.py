"""Put a cube into the basket without a tree: read its pose, move, step, read the result."""

import numpy as np

from bt_manip import build_station
from bt_manip.cell.objects import Cube
from bt_manip.spatial import pointing_down, pose


def main() -> None:
    """Pick a cube, carry it over the basket, and let it fall."""
    station = build_station()  # a Panda on a table, and a basket beside it
    cell, arm, gripper = station.cell, station.arm, station.gripper

    cube = cell.add(Cube(), pose((0.35, 0.1, 1.04)))  # [m] x, y, z of its centre in the world
    at = cell.pose(cube).translation  # (3,)
    print(f"'{cube}' lies at {np.round(at, 3)} m")

    # A motion is planned on request; the arm moves while the cell steps, 1 ms per step.
    arm.move_to_pose(pointing_down(at + (0, 0, 0.15)))
    station.step_until(lambda: not arm.moving)
    arm.move_linear(pointing_down(at + (0, 0, 0.015)))
    station.step_until(lambda: not arm.moving)

    gripper.close(force=50.0)  # [N] on each finger
    station.step_until(lambda: gripper.steady)
    left, right = gripper.forces
    print(f"the fingers hold {gripper.held} with {left:.1f} and {right:.1f} N")

    arm.move_linear(pointing_down(at + (0, 0, 0.3)))
    station.step_until(lambda: not arm.moving)
    over_basket = cell.pose("basket").translation + (0, 0, 0.25)
    arm.move_to_pose(pointing_down(over_basket))
    station.step_until(lambda: not arm.moving)
    error = np.abs(arm.q - arm.robot.q).max()
    print(f"over the basket after {cell.time:.2f} s, joints within {1e3 * error:.2f} mrad")

    gripper.open()
    station.step_until(lambda: cell.contacts.touching(cube, "basket"))
    print(f"'{cube}' has landed in the basket after {cell.time:.2f} s")


if __name__ == "__main__":
    main()
