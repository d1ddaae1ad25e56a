"""What inverse kinematics is asked with, refused by name before anything is searched."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import (
    IKProblem,
    InverseKinematics,
    PoseTarget,
    PositionTarget,
    RotationTarget,
    manipulability,
)

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


def refused(make, message):
    """Tell that a call is refused as bad input, in one line that has a message in it."""
    with pytest.raises(MotionError, match=message) as raised:
        make()
    assert raised.value.reason == "target"
    assert "\n" not in str(raised.value)


# Targets


@pytest.mark.parametrize(
    "tolerance",
    [
        (1e-3,),
        (),
        [],
        (1e-3, 1e-3, 1e-3),
        np.full((2, 1), 1e-3),
        ([1e-3], [1e-3, 1e-3]),
        (1e-3, -1e-3),
        (1e-3, 0.0),
        (1e-3, "wide"),
        (1e-3, None),
        -1e-3,
        0.0,
        np.nan,
        np.array(np.nan),
        np.inf,
        10**400,
        True,
        "0.001",
        np.array("0.001"),
        {"position": 1e-3},
    ],
)
def test_a_tolerance_of_a_pose_that_is_neither_a_number_nor_a_pair_is_refused(tolerance):
    refused(
        lambda: PoseTarget("tool", DOWN, tolerance=tolerance),
        "target of frame 'tool': tolerance must be above 0, or a pair of position and rotation",
    )


@pytest.mark.parametrize("tolerance", [(1e-3,), (1e-3, 1e-3), [1e-3], "0.001", np.nan, -1.0])
def test_a_tolerance_of_a_position_or_a_rotation_is_one_number(tolerance):
    message = "frame 'tool': tolerance must be above 0, got"
    refused(lambda: PositionTarget("tool", np.zeros(3), tolerance=tolerance), message)
    refused(lambda: RotationTarget("tool", np.eye(3), tolerance=tolerance), message)


@pytest.mark.parametrize("pair", [(1e-3, 1e-2), [1e-3, 1e-2], np.array([1e-3, 1e-2])])
def test_a_pair_of_tolerances_may_be_any_kind_of_list(pair):
    assert PoseTarget("tool", DOWN, tolerance=pair).tolerances == (1e-3, 1e-2)


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, "1.0", [1.0], True])
def test_a_weight_is_a_number_above_nought(weight):
    refused(lambda: PoseTarget("tool", DOWN, weight=weight), "'tool': weight must be above 0, got")


def test_numbers_written_as_text_are_no_place_and_no_configuration(model, ik):
    refused(lambda: PositionTarget("tool", ["0.1", "0.2", "0.3"]), "3 finite numbers .m., got")
    refused(lambda: ik.solve(DOWN, ["0.1"] * 7), "configuration must be 7 finite numbers")


# Problems


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            {"targets": 3},
            "a target must be a PositionTarget, RotationTarget or PoseTarget, got int",
        ),
        ({"targets": None}, "got NoneType"),
        ({"targets": "tool"}, "got str"),
        ({"targets": [GRIP, 3]}, "got int"),
        ({"targets": np.array("tool")}, "got ndarray"),
        ({"joints": np.array("joint1")}, "a list of names, got array"),
        ({"joints": 3}, "joints must be a list of names, got 3"),
        ({"joints": "joint1"}, "a list of names, got 'joint1'"),
        ({"joints": ["joint1", 2]}, r"a list of names, got \['joint1', 2\]"),
        ({"world": 3}, "world must be a CollisionWorld, got int"),
        ({"posture_weight": "1"}, "posture_weight must be above 0, got '1'"),
        ({"posture_weight": np.ones(2)}, "posture_weight must be above 0, got array"),
        ({"manipulability": -1.0}, "manipulability must be at least 0, got -1.0"),
        ({"manipulability": np.zeros(2)}, "manipulability must be at least 0, got array"),
        ({"clearance": -1e-3}, "clearance must be at least 0 .m., got -0.001"),
        ({"clearance": "1 mm"}, "clearance must be at least 0 .m., got '1 mm'"),
        ({"clearance": 1e-3}, "a clearance of 0.001 m needs a CollisionWorld, got world=None"),
        ({"base": 3}, "base must be a pin.SE3, got int"),
    ],
)
def test_what_states_no_problem_is_refused_when_it_is_stated(stated, message):
    refused(lambda: IKProblem(**{"targets": GRIP, **stated}), message)


@pytest.mark.parametrize("margin", [np.nan, "0.1", None, [], [0.1] * 6, [["0.1"]], np.full(7, -1)])
def test_a_margin_is_one_number_or_one_for_each_joint(model, ik, margin):
    problem = IKProblem(targets=GRIP, margin=margin)
    refused(
        lambda: ik.solve(problem, model.home), "margin must be at least 0 .rad., one number or 7"
    )


@pytest.mark.parametrize("posture", ["up", 0.0, ["0"] * 7, np.full(7, np.inf)])
def test_a_posture_is_a_configuration(model, ik, posture):
    problem = IKProblem(targets=GRIP, posture=posture)
    refused(lambda: ik.solve(problem, model.home), "posture must be 7 finite")


def test_names_that_can_be_read_once_serve_every_time(model, ik):
    moving = ("joint1", "joint2", "joint4", "joint6")
    place = PositionTarget("tool", DOWN.translation)
    problem = IKProblem(targets=place, joints=(name for name in moving))
    first, second = (ik.solve(problem, model.home) for _ in range(2))
    assert first.solved and np.array_equal(first.q, second.q)
    assert problem.joints == moving


# Clearance


def test_a_clearance_beyond_what_the_world_sees_is_refused_with_the_reason(walled):
    grip = PoseTarget("panda/tool", walled.left)
    for clearance in (0.0081, 0.05):
        refused(
            lambda clearance=clearance: IKProblem(
                targets=grip, world=walled.world, clearance=clearance
            ),
            f"clearance must be at most 0.008 m, .* CollisionWorld measures, got {clearance:g}",
        )


def wall_distance(walled, q):
    """Give the distance of the arm from the wall, by MuJoCo's own search for nearest points."""
    model, data = walled.robot.mj_model, mujoco.MjData(walled.robot.mj_model)
    data.qpos[:] = walled.robot.mj_data.qpos
    data.qpos[np.array(walled.robot.qpos_adr)] = q
    mujoco.mj_kinematics(model, data)
    wall = next(i for i in range(model.ngeom) if "wall" in model.geom(i).name)
    arm = [
        i
        for i in range(model.ngeom)
        if model.geom(i).contype and model.body(model.geom_bodyid[i]).name.startswith("panda")
    ]
    return min(mujoco.mj_geomDistance(model, data, i, wall, 1.0, None) for i in arm)


def test_the_widest_clearance_is_kept(walled):
    ik, world = walled.ik, walled.world
    rng = np.random.default_rng(4)
    nearer = 0
    for _ in range(12):
        target = PositionTarget("panda/tool", rng.uniform([0.3, -0.09, 0.1], [0.6, -0.05, 0.35]))
        careless = ik.solve(IKProblem(targets=target, world=world), ik.model.home)
        careful = ik.solve(IKProblem(targets=target, world=world, clearance=0.008), ik.model.home)
        if careful.solved:
            assert wall_distance(walled, careful.q) >= 0.008 - 1e-6
            nearer += wall_distance(walled, careless.q) < 0.008
    assert nearer > 0


def test_a_world_of_another_arm_is_refused(model, ik, walled):
    problem = IKProblem(targets=GRIP, world=walled.world)
    message = "the CollisionWorld is that of an arm with panda/joint1, .* this one has joint1,"
    refused(lambda: ik.solve(problem, model.home), message)
    refused(lambda: ik.follow(problem, model.home), message)


# What searches are asked with


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"restarts": 2.5}, "restarts must be an integer of at least 0, got 2.5"),
        ({"restarts": "many"}, "restarts must be an integer of at least 0, got 'many'"),
        ({"restarts": True}, "restarts must be an integer of at least 0, got True"),
        ({"rng": 3}, "rng must be a numpy.random.Generator, got 3"),
        ({"rng": 0}, "rng must be a numpy.random.Generator, got 0"),
        ({"rng": np.random.RandomState(0)}, "rng must be a numpy.random.Generator"),
    ],
)
def test_solve_refuses_what_it_cannot_search_with(model, ik, asked, message):
    refused(lambda: ik.solve(DOWN, model.home, **asked), message)
    refused(lambda: ik.solve(IKProblem(targets=GRIP), model.home, **asked), message)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"restarts": 1.5}, "restarts must be an integer of at least 0, got 1.5"),
        ({"distinct": -0.1}, "distinct must be at least 0 .rad., got -0.1"),
        ({"distinct": np.nan}, "distinct must be at least 0 .rad., got nan"),
        ({"distinct": "0.1"}, "distinct must be at least 0 .rad., got '0.1'"),
        ({"rng": "seed"}, "rng must be a numpy.random.Generator, got 'seed'"),
        ({"margin": -0.1}, "margin must be at least 0 .rad., got -0.1"),
        ({"margin": np.nan}, "margin must be at least 0 .rad., got nan"),
    ],
)
def test_solutions_refuses_what_it_cannot_list_with(model, ik, asked, message):
    refused(lambda: ik.solutions(DOWN, model.home, **asked), message)
    refused(lambda: ik.solutions(IKProblem(targets=GRIP), model.home, **asked), message)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"max_step": 0.0}, "max_step must be above 0 .rad., got 0.0"),
        ({"max_step": -0.2}, "max_step must be above 0 .rad., got -0.2"),
        ({"max_step": np.nan}, "max_step must be above 0 .rad., got nan"),
        ({"max_step": "0.2"}, "max_step must be above 0 .rad., got '0.2'"),
        ({"max_step": np.full(7, 0.2)}, "max_step must be above 0 .rad., got array"),
        ({"margin": -0.1}, "margin must be at least 0 .rad., got -0.1"),
        ({"margin": np.nan}, "margin must be at least 0 .rad., got nan"),
        ({"margin": np.full(7, 0.1)}, "margin must be at least 0 .rad., got array"),
        ({"tolerance": 0.0}, "tolerance must be above 0 .m, rad., got 0.0"),
        ({"tolerance": (1e-3, 1e-3)}, "tolerance must be above 0 .m, rad., got"),
        ({"tolerance": np.nan}, "tolerance must be above 0 .m, rad., got nan"),
        ({"retry": "no"}, "retry must be True or False, got 'no'"),
        ({"retry": np.zeros(2)}, "retry must be True or False, got array"),
    ],
)
def test_follow_refuses_what_it_cannot_follow_with(model, ik, asked, message):
    refused(lambda: ik.follow(model.pose(model.home), model.home, **asked), message)
    refused(lambda: ik.follow(IKProblem(targets=GRIP), model.home, **asked), message)


def test_whole_numbers_serve_as_angles_too(model, ik):
    T = model.pose(model.home + 0.02)
    plain = ik.follow(T, model.home, max_step=1.0, margin=0.0)
    whole = ik.follow(T, model.home, max_step=1, margin=0)
    assert plain.solved and np.array_equal(plain.q, whole.q)


def test_a_margin_or_a_tolerance_beside_a_problem_is_refused_instead_of_forgotten(model, ik):
    problem = IKProblem(targets=GRIP)
    own = "a problem has its own margin: ask for IKProblem.margin=....*got margin=0.1"
    refused(lambda: ik.follow(problem, model.home, margin=0.1), own)
    refused(lambda: ik.solutions(problem, model.home, margin=0.1), own)
    each = "each target of a problem has its own tolerance: ask for PoseTarget"
    refused(lambda: ik.follow(problem, model.home, tolerance=1e-3), each)


def test_a_target_without_a_problem_is_refused_with_how_to_ask_for_it(model, ik):
    for ask in (ik.solve, ik.follow, ik.solutions):
        refused(
            lambda ask=ask: ask(GRIP, model.home),
            r"a pose or a problem, got the target of frame 'tool': ask for IKProblem",
        )


def test_nearest_refuses_a_margin_that_is_none_and_does_without_one_that_leaves_no_room(model, ik):
    for margin in (-0.1, np.nan, "wide"):
        refused(lambda margin=margin: ik.nearest(DOWN, model.home, margin=margin), "margin must be")
    found = ik.nearest(DOWN, model.home, margin=3.0)
    assert np.array_equal(found.q, ik.nearest(DOWN, model.home).q)
    assert ik.solutions(DOWN, model.home, margin=3.0) == []


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"iterations": 1.5}, "iterations must be an integer of at least 0, got 1.5"),
        (
            {"max_failed_iterations": -1},
            "max_failed_iterations must be an integer .*, got -1",
        ),
        (
            {"max_failed_iterations": np.nan},
            "max_failed_iterations must be an integer .*, got nan",
        ),
        (
            {"max_failed_iterations": "600"},
            "max_failed_iterations must be an integer .*, got '600'",
        ),
        ({"seed": -1}, "seed must be an integer of at least 0, got -1"),
        ({"seed": "one"}, "seed must be an integer of at least 0, got 'one'"),
        ({"position_tolerance": 0.0}, "position_tolerance must be above 0 .m., got 0.0"),
        ({"rotation_tolerance": np.nan}, "rotation_tolerance must be above 0 .rad., got nan"),
    ],
)
def test_bounds_that_nothing_is_searched_with_are_refused_when_they_are_given(
    model, given, message
):
    refused(lambda: InverseKinematics(model, **given), message)


def test_what_is_no_model_of_an_arm_is_refused(robot):
    message = "model must be a RobotModel .Robot.make_model., got Robot"
    refused(lambda: InverseKinematics(robot), message)


def test_a_distance_is_between_configurations(model, ik):
    refused(lambda: ik.distance(np.zeros(6), model.home), "configuration must be 7 finite numbers")
    refused(lambda: ik.distance(model.home, None), "configuration must be 7 finite numbers")
    assert ik.distance([0.0] * 7, [0.0] * 7) == 0.0


@pytest.mark.parametrize("jacobian", [3.0, np.zeros(6), np.zeros((0, 7)), np.full((6, 7), np.nan)])
def test_the_manipulability_is_that_of_a_matrix(jacobian):
    refused(lambda: manipulability(jacobian), "a Jacobian must be a matrix of finite numbers, got")


# Following a problem


def step_aside(T, metres):
    return pin.SE3(T.rotation, T.translation + [0.0, metres, 0.0])


def tool_in_mujoco(walled, q):
    model, data = walled.robot.mj_model, mujoco.MjData(walled.robot.mj_model)
    data.qpos[np.array(walled.robot.qpos_adr)] = q
    mujoco.mj_kinematics(model, data)
    site = data.site("panda/tool")
    return pin.SE3(site.xmat.reshape(3, 3), site.xpos)


def test_a_problem_is_followed_from_a_near_start_in_one_small_step(walled):
    ik, world = walled.ik, walled.world
    q = ik.solve(walled.left, ik.model.home).q
    low = q - 0.5
    for i in range(1, 21):
        T = step_aside(walled.left, 0.004 * i)
        problem = IKProblem(
            targets=PoseTarget("panda/tool", T),
            joints=[f"joint{j}" for j in range(1, 8)],
            margin=0.05,
            posture=low,
            world=world,
            clearance=0.008,
        )
        found = ik.follow(problem, q)
        assert found.solved and found.reason == "" and found.restarts == 0
        assert np.abs(found.q - q).max() <= 0.2 + 1e-12
        assert np.linalg.norm(pin.log6(tool_in_mujoco(walled, found.q).actInv(T)).np) <= 2e-6
        assert found.residuals[0].met
        q = found.q


@pytest.mark.parametrize(
    "target",
    [
        PoseTarget("tool", spatial.pointing_down([0.3, 0.5, 0.3], 2.0)),
        PositionTarget("tool", [0.1, 0.6, 0.3]),
        RotationTarget("tool", spatial.pointing_down([0.0, 0.0, 0.0], 2.5).rotation),
    ],
)
def test_a_problem_is_not_followed_from_far_away_and_the_reason_says_that_it_is_far(
    model, ik, target
):
    problem = IKProblem(targets=target)
    assert ik.solve(problem, model.home).solved
    found = ik.follow(problem, model.home)
    assert not found.solved and not found.residuals[0].met
    assert found.reason == "a joint would have to jump by more than 0.2 rad"
    assert np.abs(found.q - model.home).max() <= 0.2 + 1e-12
    wide = ik.follow(problem, model.home, max_step=3.0)
    assert wide.solved


def test_what_is_given_back_from_far_away_came_nearest_of_all_that_was_tried(model, ik, rng):
    detoured = 0
    for _ in range(30):
        T = model.pose(rng.uniform(model.limits.lower, model.limits.upper))
        straight, found = (ik.follow(T, model.home, retry=retry) for retry in (False, True))
        if not found.solved:
            error, first = (
                np.linalg.norm(pin.log6(T.actInv(model.pose(result.q))).np)
                for result in (found, straight)
            )
            assert error <= first + 1e-12
            detoured += 1
    assert detoured > 20
