"""What behaviours do with frames, and when; nothing is drawn."""

from itertools import chain, repeat
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell, CellError, looking_at
from bt_manip.exceptions import MotionError
from bt_manip.scenes import ExpectedObjects, SceneObject
from bt_manip.spatial import pose
from bt_manip_camera import behaviours
from bt_manip_camera.behaviours import (
    DetectTags,
    EstimatePose,
    IsSeen,
    LookAt,
    SeeObjects,
    chosen_camera,
)
from bt_manip_camera.behaviours import WaitUntilSeen as Wait
from bt_manip_camera.beliefs import beliefs, latest_detections
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.detections import Detections
from bt_manip_camera.estimation import Estimate
from bt_manip_camera.perception import Perception
from bt_manip_camera.seen import SeenPoses
from bt_manip_camera.tags import SeenTag

from .test_segmentation import EYE, FOVY, HEIGHT, TARGET, WIDTH, cast, painted

EMPTY, CUBE = cast(size=(0.3, 0.3, 0.01)), cast(size=(0.05, 0.05, 0.05), yaw=0.4)


@pytest.fixture
def cell(parts):
    """Make a cell with a table of 1 m and a camera over it, which takes 10 frames a second."""
    cell = Cell()
    camera = DepthCamera(fovy=FOVY, width=WIDTH, height=HEIGHT, rate=10.0, delay=0.25)
    with cell.editing():
        table = parts.objects.create("table", height=1.0)
        cell.add(table, pose((0.3, 0.0, 0.0)), name="table", free=False)
        cell.add(camera, looking_at(EYE, TARGET), name="eye", free=False)
    return cell


@pytest.fixture
def models(parts):
    return SimpleNamespace(create=parts.objects.create, nominal=parts.objects.create)


@pytest.fixture
def poses(cell, models):
    """Expect a cube and a box in it, which are where they are seen."""
    objects = [
        SceneObject(name, name, pose((0, 0, 1)), {"size": size}, free=True, expected=True)
        for name, size in (("cube", 0.05), ("box", (0.06, 0.04, 0.1)))
    ]
    return ExpectedObjects(SeenPoses(objects), cell, models)


@pytest.fixture
def until_done(cell, poses, models):
    """Tick a leaf every 10 ms from 35 ms on; give its status and the time."""

    def play(leaf):
        camera = cell.find("eye")
        play.tree, rng = Tree(leaf), np.random.default_rng(0)
        given = {"cell": cell, "poses": poses, "robots": {}, "rng": rng, "models": models}
        play.tree.setup(sensors={"eye": camera}, **given)
        cell.step(35)
        while (status := play.tree.tick()) is NodeStatus.RUNNING:
            cell.step(10)
            while camera.waiting:
                pass
        return status, cell.time

    return play


@pytest.mark.parametrize("make", [Wait, SeeObjects])
@pytest.mark.parametrize(
    ("period", "empty", "requested", "ended"),
    [(0.1, 3, 0.305, 0.405), (0.1, 99, None, 0.605), (0.045, 3, 0.135, 0.185)],  # ticks at 45 ms
)
def test_a_thing_is_looked_for_in_each_frame_until_it_is_seen_or_the_time_is_over(
    cell, poses, until_done, make, period, empty, requested, ended
):
    frames = chain(repeat(EMPTY, empty), repeat(CUBE))
    cell.find("eye").rate = 1.0 / period
    cell.find("eye").source = lambda: next(frames)[:2]
    leaf = make(**{"object" if make is Wait else "objects": "cube"}, timeout=0.48)
    status, time = until_done(leaf)
    assert time == pytest.approx(ended)
    assert (status is NodeStatus.SUCCESS) == ("cube" in cell.entities) == (empty == 3)
    if empty == 3:
        assert np.abs(cell.pose("cube").translation - (0.32, 0.03, 1.025)).max() < 2e-3
        assert poses.source.seen["cube"].time == pytest.approx(requested)
    else:
        assert "'cube' is not seen; seen is " in leaf.feedback_message


def test_tags_are_written_by_their_numbers_and_wanted_ones_must_be_seen(
    cell, until_done, monkeypatch
):
    tags = [SeenTag(n, pose((n, 2, 1)), np.zeros(2), np.ones((4, 2))) for n in (3, 7)]
    monkeypatch.setattr(behaviours, "tag_detector", lambda: None)
    monkeypatch.setattr(
        behaviours, "detect_tags", lambda *given: tags * (given[1:] == (0.05, None))
    )
    cell.find("eye").source = lambda: CUBE[:2]
    leaf = DetectTags(size=0.05, wanted=[7], numbers="{n}", poses="{p}")
    assert until_done(leaf)[0] is NodeStatus.SUCCESS and leaf.feedback_message == "tags: 3, 7"
    written = until_done.tree.blackboard
    assert written["n"] == [3, 7] and [T.translation[0] for T in written["p"]] == [3.0, 7.0]
    leaf = DetectTags(size=0.05, wanted=[7, 8])
    assert until_done(leaf)[0] is NodeStatus.FAILURE
    assert leaf.feedback_message == "tag 8 is not seen; seen: 3, 7"


def test_a_rendered_frame_begins_at_the_next_period_and_arrives_after_the_delay(
    cell, poses, until_done, monkeypatch
):
    taken = []
    monkeypatch.setattr(behaviours, "check_opengl", lambda: None)
    monkeypatch.setattr(DepthCamera, "expose", lambda *_: taken.append(cell.time) or CUBE)
    status, time = until_done(leaf := EstimatePose(object="cube"))
    assert status is NodeStatus.SUCCESS
    assert (*taken, time) == pytest.approx((0.105, 0.355))
    error = 1e3 * poses.source.seen["cube"].position_error
    assert leaf.feedback_message == f"'cube' at (0.320, 0.030) m, within {error:.1f} mm"


def test_a_real_arm_needs_frames_of_a_camera_and_a_simulated_one_opengl_without_them(monkeypatch):
    drawn, cameras = [], {name: DepthCamera() for name in "ab"}
    monkeypatch.setattr(behaviours, "check_opengl", lambda: drawn.append(1))

    def setup(camera, connection=None, **sources):
        for name, one in cameras.items():
            one.source = sources.get(name)
        robots = {"arm": SimpleNamespace(arm=SimpleNamespace(connection=connection))}
        rest = {"cell": None, "rng": None, "models": None, "sensors": cameras}
        EstimatePose(object="cube", camera=camera).setup(robots=robots, **rest)
        return len(drawn)

    assert (setup("b", a=next), setup("b", a=next, b=next), setup("a", "real", a=next)) == (1, 1, 1)
    with pytest.raises(CellError, match="camera 'b': a real robot needs frames of a real camera"):
        setup("b", "real", a=next)
    with pytest.raises(CellError, match="^a real robot needs frames of a real camera: --camera"):
        setup("b", "real")


def test_a_camera_is_the_named_or_the_only_one_and_one_that_looks_is_on_a_robot():
    one, other = DepthCamera(), DepthCamera(mount="arm")
    assert chosen_camera("", {"a": one}) == ("a", one)
    assert chosen_camera("b", {"a": one, "b": other}) == ("b", other)
    for name, cameras, why in (
        ("", {}, "the scene has no depth_camera"),
        ("", {"a": one, "b": other}, r"which camera\? The scene has a, b"),
        ("aye", {"eye": one}, "no depth_camera 'aye'; did you mean 'eye'"),
    ):
        with pytest.raises(CellError, match=why):
            chosen_camera(name, cameras)
    with pytest.raises(CellError, match="camera 'a' is on no robot that could move it"):
        LookAt().setup(cell=Cell(), sensors={"a": one}, robots={"": SimpleNamespace(arm=None)})


def test_frames_of_a_moving_camera_are_not_used_and_not_waited_for_longer_than_1_s(
    cell, until_done, monkeypatch
):
    cell.find("eye").source = lambda: CUBE[:2]
    monkeypatch.setattr(DepthCamera, "moved", lambda *_: cell.time < 0.7)
    status, time = until_done(EstimatePose(object="cube"))
    assert status is NodeStatus.SUCCESS and time == pytest.approx(0.705)
    monkeypatch.setattr(DepthCamera, "moved", lambda *_: True)
    leaf = EstimatePose(object="cube")
    status, later = until_done(leaf)
    assert later == pytest.approx(time + 0.035 + 1.0, abs=0.011)
    assert "has moved while its frame was taken" in leaf.feedback_message


def test_a_camera_has_moved_from_2_mm_or_2_mrad_on(cell):
    camera, T_wc, rng = cell.find("eye"), cell.pose("eye"), np.random.default_rng(0)
    assert not camera.moved()
    camera.source = lambda: CUBE[:2]
    for length, angle in ((1.9e-3, 1e-3), (1e-3, 1.9e-3), (2.1e-3, 1e-3), (1e-3, 2.1e-3)):
        cell.move("eye", T_wc)
        camera.request()
        cell.move(
            "eye", T_wc * pin.SE3(pin.exp3(np.array([0, angle, 0])), np.array([0, length, 0]))
        )
        assert camera.moved() == (max(length, angle) > 2e-3)
        if not camera.moved():
            assert camera.expose(rng).T_wc.isApprox(T_wc)
    with pytest.raises(CellError, match="camera 'eye' has moved"):
        camera.expose(rng)


def test_a_camera_is_by_default_as_the_readme_says():
    camera = DepthCamera()
    assert camera.focal_length == pytest.approx(240.0 / np.tan(np.radians(25.0)))
    assert (camera.width, camera.height, camera.rate, camera.delay) == (640, 480, 30.0, 0.03)
    wrong = camera.errors
    assert (wrong.noise, wrong.smooth_noise, wrong.dropout) == (1.5e-3, 2e-3, 0.5)
    assert camera.miscalibration.isApprox(pin.SE3.Identity(), 1e-12) and wrong.bias == 0.0
    assert Wait().timeout == SeeObjects().timeout == 1.0 and DetectTags().size == 0.032
    assert (LookAt().distance, *LookAt().point) == (0.5, 0.3, 0.0, 1.015)
    assert (IsSeen().max_age, IsSeen().max_error) == (1e6, 5e-3)


def test_what_is_seen_within_half_a_millimetre_stays_where_it_is_believed(cell, poses):
    perception, at = Perception(cell, poses, {}, None), np.array([0.3, 0.1, 1.0251])
    cases = [(0, 0, 0), (4e-4, 0, 0), (0, 0, 5e-3), (6e-4, 0, 0), (0, -8e-3, 0), (0, 0, 0.05)]
    for moves, (x, z, yaw) in zip((0, 0, 0, 1, 1, 1), cases, strict=True):
        T_wo = pose(at + (x, 0, z), (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)))
        perception.believe(Estimate("cube", T_wo, 1e-3, 0.0, 0.2), "eye")
        expected = T_wo if moves else pose(at)
        assert cell.pose("cube").isApprox(expected, 1e-9) and poses.source.seen["cube"].T_wo == T_wo
    with pytest.raises(CellError):  # into the table
        perception.believe(Estimate("cube", pose(at - (0, 0, 0.02)), 1e-3, 0.0, 0.2), "eye")


def test_a_thing_is_gone_where_what_is_seen_is_lower_than_a_quarter_of_it(
    cell, poses, models, until_done
):
    perception = Perception(cell, poses, {}, models)
    T_wo = pose((0.25, -0.25, 1.05))  # 0.75 m below the camera of the frames
    perception.believe(Estimate("box", T_wo, 1e-3, 0.0, 0.2), "eye")
    for height, gone in ((0.0, True), (0.024, True), (0.026, False)):
        seen = perception.see(painted(((50, 130), (60, 170), height)), 1.0)
        assert seen.gone == ({"box"} if gone else set()) and not seen.found
    perception.believe(Estimate("box", pose((0.32, 0.03, 1.05)), 1e-3, 0.0, 0.2), "eye")
    cell.find("eye").source = lambda: EMPTY[:2]
    assert not poses.source.lost and until_done(SeeObjects())[0] is NodeStatus.SUCCESS
    assert poses.source.lost == {"box"} and not poses.source.seen
    poses.source.lost.clear()
    holding = {"arm": SimpleNamespace(gripper=SimpleNamespace(held=("box",)))}
    with_box = Perception(cell, poses, holding, models)
    with_box.lose(["box", "cube"])
    assert poses.source.lost == {"cube"}  # the box is in the hand
    frame = cast(size=(0.06, 0.04, 0.1))
    for wanted, found in (((), set()), (("box",), {"box"})):  # it is another one, but for a wish
        assert with_box.see(frame, 1.0, wanted).found.keys() == found


def test_the_latest_detections_are_shown_and_beliefs_beside_the_truth(cell, poses):
    eyes = [
        SimpleNamespace(detections=time and Detections(CUBE._replace(time=time)))
        for time in (0.5, 0.9, None, 0.7)
    ]
    found = SimpleNamespace(entities=dict(zip("abcd", eyes, strict=True)))
    assert latest_detections(SimpleNamespace(cell=found)) == ("b", eyes[1].detections)
    found.entities = {"c": eyes[2], "table": None}
    assert latest_detections(SimpleNamespace(cell=found)) == ("", None)
    T_wo, true = (pose(at, (np.cos(0.2), 0, 0, np.sin(0.2))) for at in ((1, 2, 3), (2, 4, 5)))
    physics = SimpleNamespace(time=2.5, entities=("box", "cube"), pose=lambda name: true)
    believed = SimpleNamespace(
        poses=poses, cell=SimpleNamespace(entities=("box",), pose=lambda name: T_wo)
    )
    poses.source.report(Estimate("box", T_wo, 3e-3, 0.1, 0.9, "eye"))
    rows = beliefs(SimpleNamespace(believed=believed, cell=physics))
    for row, number in zip(rows.values(), (1, 2), strict=True):
        quats = [row.pop(key) for key in ("true_quat_wxyz", "quat_wxyz")[:number]]
        assert np.ravel(quats) == pytest.approx([np.cos(0.2), 0, 0, np.sin(0.2)] * number)
    known = {"position": [1, 2, 3], "position_error": 3e-3, "camera": "eye", "age": 1.6}
    truth = {"true_position": [2, 4, 5]}
    assert rows == {"cube": truth, "box": known | truth | {"off": 3.0}}


@pytest.mark.start("a cube")
def test_the_arm_looks_from_where_it_is_in_turn_from_all_sides_and_steeper_and_flatter(
    station, trial, monkeypatch
):
    tried = []

    def refuse(poses):
        tried.append([T_wt * T_tc for T_wt in poses])
        raise MotionError("out of reach", reason="")

    T_tc, arm = station.cell.pose("eye"), station.arm
    monkeypatch.setattr(arm, "move_to_pose", refuse)
    target = np.array([0.45, 0.2, 1.1])
    assert trial(LookAt(point=[*target], distance=0.4)).fails_with("out of reach")
    eyes = np.array([[T.translation for T in poses] for poses in tried]) - target
    np.testing.assert_allclose(np.linalg.norm(eyes, axis=2), 0.4)
    axes = np.array([[T.rotation[:, 2] for T in poses] for poses in tried])
    np.testing.assert_allclose(axes, eyes / 0.4, atol=1e-9)  # it looks along -z
    steep = np.degrees(np.arcsin(eyes[..., 2] / 0.4))
    np.testing.assert_allclose(steep, np.repeat([[70.0], [90], [55], [80], [45]], 32, axis=1))
    away = (arm.model.pose(station.robot.q) * T_tc).translation - target
    turned = np.arctan2(eyes[..., 1], eyes[..., 0]) - np.arctan2(away[1], away[0])
    expected = np.repeat([0, 45, -45, 90, -90, 135, -135, 180], 4)
    off = np.degrees(turned[[0, 2, 3, 4]]) - expected  # from above there is no side
    np.testing.assert_allclose((off + 180) % 360 - 180, 0.0, atol=1e-6)
    rolls = np.array([T.rotation[:, 0] for T in tried[0]]).reshape(8, 4, 3)
    np.testing.assert_allclose(rolls[:, :2], -rolls[:, 2:], atol=1e-9)
    np.testing.assert_allclose(np.sum(rolls[:, 0] * rolls[:, 1], axis=1), 0.0, atol=1e-9)
