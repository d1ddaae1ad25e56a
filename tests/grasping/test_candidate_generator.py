"""Generation of grasp candidates: which objects have any, and the same ones for the same seed."""

import numpy as np
import pytest
import trimesh

from bt_manip.exceptions import MotionError
from bt_manip.grasping import CandidateGenerator
from tests.grasping.shapes import DOWN, HAND, candidates, convex, solid, wedge


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_an_object_that_is_too_wide_fails_with_its_width_and_the_stroke(kind):
    with pytest.raises(MotionError, match="at least 100 mm wide; the fingers open to 80 mm"):
        candidates(solid(kind, 0.05, 0.05, 0.05))


def test_a_mesh_that_is_too_wide_fails_too():
    with pytest.raises(MotionError, match="120 mm wide; the fingers open to 80 mm"):
        candidates(convex(trimesh.creation.box((0.12, 0.13, 0.14))))


def test_the_same_seed_gives_the_same_grasps():
    made = [candidates(convex(wedge()), seed=seed) for seed in (3, 3, 4)]
    texts = [[grasp.to_text() for grasp in table] for table in made]
    assert texts[0] == texts[1] != texts[2]


def test_a_palm_too_near_to_the_fingertips_fails_with_the_length_of_the_fingers():
    cube, gripper = [solid("box", 0.025, 0.025, 0.025)], HAND._replace(palm=-0.0045)
    generator = CandidateGenerator("it", cube, gripper, np.zeros(3), np.random.default_rng(0))
    with pytest.raises(MotionError, match="deep enough: the fingers extend 5 mm beyond the palm"):
        generator.candidates(DOWN)
