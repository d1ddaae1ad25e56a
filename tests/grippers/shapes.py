"""Shapes to grip, and a gripper to grip them with."""

import math

import numpy as np
import pinocchio as pin
import trimesh

from bt_manip.grippers import Solid
from bt_manip.grippers.two_finger.antipodal_grasps import AntipodalGraspGenerator
from bt_manip.grippers.two_finger.hand import Hand

DOWN = np.array([0.0, 0.0, -1.0])
# Similar to the Panda's.
HAND = Hand(np.array([0.0, 1.0, 0.0]), 0.08, 0.0, 0.0095, 0.0234, 0.00875)


def solid(kind, *size, at=(0.0, 0.0, 0.0), rotation=None):
    T = pin.SE3(np.eye(3) if rotation is None else rotation, np.array(at))
    return Solid(kind, np.array([*size, 0.0, 0.0][:3]), T, 0.7)


def convex(mesh):
    return Solid("mesh", np.zeros(3), pin.SE3.Identity(), 0.7, np.array(mesh.convex_hull.triangles))


def candidates(*solids, seed=0, hand=HAND):
    rng = np.random.default_rng(seed)
    generator = AntipodalGraspGenerator("it", solids, hand, np.zeros(3), rng)
    return generator.candidates(DOWN)


def wedge():
    """Return a prism whose sides are not parallel, narrower above than below."""
    corners = np.array([[-0.03, -0.02], [0.03, -0.02], [0.02, 0.02], [-0.01, 0.03]])
    below = np.column_stack([corners, np.full(4, -0.02)])
    above = np.column_stack([0.8 * corners, np.full(4, 0.02)])
    return trimesh.convex.convex_hull(np.vstack([below, above]))


def mug():
    """Return walls of 4 mm around a hollow of 56 mm."""
    walls = []
    for i in range(4):
        angle = 0.5 * math.pi * i
        position = (0.030 * math.cos(angle), 0.030 * math.sin(angle), 0.0)
        rotation = pin.utils.rotate("z", angle)
        walls.append(solid("box", 0.002, 0.032, 0.04, at=position, rotation=rotation))
    return walls
