"""A scene from a file is what the file says, or all that is wrong is said at once."""

import re
from dataclasses import replace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.cell import CellError
from bt_manip.cell.objects import Bottle
from bt_manip.models import bundled_root
from bt_manip.record import Recorder
from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.scenes import Fixture, Scene, SceneObject, table_and_basket, two_arms
from bt_manip.scenes.scene_file import SceneError, read_scene, seed_of
from bt_manip.spatial import pose
from bt_manip.toml import line_numbers, line_of

ROBOT = "[[robots]]\nposition = [-0.1, 0.0, 1.015]\n"
TABLE = ROBOT + '[[objects]]\nmodel = "table"\n'


def test_a_file_says_what_stands_where(write, parts):
    scene = read_scene(
        write(
            """
            about = "two things"
            seed = 5
            [[robots]]
            name = "left"
            robot = "panda"
            controller = "gravity_compensated_pd"
            position = [-0.1, 0.0, 1.015]
            rpy = [0.0, 0.0, 1.5707963267948966]
            [[objects]]
            model = "table"
            [[objects]]
            model = "bottle"
            name = "drink"
            on = "table"
            position = [0.3, 0.1]
            quat_wxyz = [0.0, 0.0, 0.0, 1.0]
            mass = 0.3
            [[objects]]
            model = "cube"
            on = "table"
            free = false
            position = [0.3, -0.2, 0.01]
            [[cameras]]
            name = "eye"
            position = [1.0, 0.0, 2.0]
            looking_at = [0.0, 0.0, 1.0]
            width = 64
            """
        ),
        parts,
    )
    assert (scene.about, scene.seed) == ("two things", 5)
    station = build_station(parts, scene=scene)
    cell = station.cell
    assert list(station.robots) == ["left"]
    assert station.controller.kind == "gravity_compensated_pd"
    np.testing.assert_allclose(cell.pose("left").rotation[:2, :2], [[0, -1], [1, 0]], atol=1e-12)
    drink = cell.find("drink")
    assert isinstance(drink, Bottle)
    assert drink.mass == 0.3
    surface = cell.find("table").surface_height
    np.testing.assert_allclose(
        cell.pose("drink").translation, (0.3, 0.1, surface + drink.rest_height), atol=1e-12
    )
    np.testing.assert_allclose(cell.pose("drink").rotation, np.diag((-1, -1, 1)), atol=1e-12)
    # The third number is a height above the surface; what is not free stays there.
    cell.step(50)
    assert cell.pose("cube").translation[2] == pytest.approx(surface + 0.025 + 0.01)
    np.testing.assert_allclose(
        cell.pose("eye").rotation @ (0, 0, -1), (-(0.5**0.5), 0, -(0.5**0.5)), atol=1e-12
    )
    assert cell.find("eye").width == 64


def test_models_and_robots_are_found_beside_the_file(write, parts, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "peg.xml").write_text(
        '<mujoco><worldbody><body><geom size="0.02" mass="0.1"/></body></worldbody></mujoco>'
    )
    text = TABLE + '[[objects]]\nmodel = "parts/peg.xml"\nname = "peg"\nposition = [0, 0, 2]\n'
    cell = build_station(parts, scene=read_scene(write(text), parts)).cell
    assert cell.find("peg").mass == pytest.approx(0.1)
    wrong = TABLE.replace("[[robots]]", '[[robots]]\nrobot = "none.toml"')
    with pytest.raises(SceneError, match=re.escape(f"no robot description {tmp_path}/none.toml")):
        read_scene(write(wrong), parts)


@pytest.mark.parametrize(
    "path", sorted(bundled_root("scenes").glob("*.toml")), ids=lambda p: p.stem
)
def test_bundled_scenes_can_be_built_and_begun(path, parts):
    station = build_station(parts, scene=read_scene(path, parts))
    station.randomizer.begin(0)
    assert station.randomizer.sampled
    assert path.stem in parts.scenes


def test_the_basket_of_the_table_stands_across_and_two_arms_face_each_other():
    (robot,), (table, basket) = (getattr(table_and_basket(), of) for of in ("robots", "objects"))
    assert robot.T_wb.isApprox(pose((-0.1, 0.0, 1.015))) and table.T_wo.isApprox(pose((0, 0, 0)))
    assert basket.T_wo.translation == pytest.approx([0.68, 0.0, 1.015])
    assert basket.T_wo.rotation == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    scene, half_turn = two_arms(), pose((0, 0, 0), (0, 0, 0, 1))
    (left, right), (_, near, far) = scene.robots, scene.objects
    assert left.T_wb.isApprox(pose((-0.55, 0.0, 1.015))) and near.T_wo.translation[2] == 1.015
    for one, opposite in ((left.T_wb, right.T_wb), (near.T_wo, far.T_wo)):
        assert opposite.isApprox(half_turn * one) and one.rotation == pytest.approx(np.eye(3))
    assert near.T_wo.translation[:2] == pytest.approx([-0.3, 0.3])


def test_objects_of_a_scene_are_still_accepted_and_read_as_fixtures():
    scene = table_and_basket()
    table = scene.objects[:1]
    assert Fixture is SceneObject
    with pytest.warns(DeprecationWarning, match="'fixtures' of Scene is now 'objects'"):
        assert Scene(scene.robots, fixtures=table).objects == table
    with pytest.warns(DeprecationWarning, match="'fixtures' of Scene is now 'objects'"):
        assert replace(scene, fixtures=table).objects == table
    with pytest.warns(DeprecationWarning, match=r"Scene.fixtures is now Scene.objects"):
        assert scene.fixtures == scene.objects


def test_a_file_may_say_which_seed(write, parts):
    assert seed_of(str(write("seed = 9\n")), parts) == 9
    assert seed_of(str(write("seed = 'x'\n")), parts) == 0
    assert seed_of("table_and_basket", parts) == 0
    assert seed_of("varied_pick", parts) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"scene.toml: key 'robots' is missing: at least one \[\[robots\]\] table"),
        ("robots = 3\n", r":1: key 'robots' is an array of tables"),
        ("seed = -1\n" + ROBOT, ":1: key 'seed' is a number of at least 0, got -1"),
        ("sed = 1\n" + ROBOT, ":1: key 'sed' means nothing; did you mean 'seed'"),
        (ROBOT + "robt = 1\n", r":3: key 'robots\[1\].robt' means nothing; did you mean 'robot'"),
        (ROBOT + 'robot = "pand"\n', r":3: key 'robots\[1\].robot' .* did you mean 'panda'"),
        (ROBOT + 'controller = "x"\n', ":3: key .*controller' is wrong: unknown controller 'x'"),
        (ROBOT + 'planner = "rrt"\n', ":3: .*planner' is wrong: unknown planner 'rrt'; known: rrt"),
        (ROBOT + ROBOT, "where a scene has several robots, each needs a name"),
        (ROBOT + "quat_wxyz = [0, 0, 0, 0]\n", ":3: key .*quat_wxyz' is no rotation"),
        (ROBOT + "rpy = [0, 0]\n", ":3: key .*rpy' is a list of 3 numbers, got 2"),
        (ROBOT + "rpy = [0, 0, 0]\nquat_wxyz = [1, 0, 0, 0]\n", "rpy' and 'quat_wxyz' exclude"),
        (TABLE + "[[objects]]\n", r":5: key 'objects\[2\].model' is missing: a registered name or"),
        (TABLE.replace('"table"', '"tabel"'), ":4: key .*model' .* did you mean 'table'"),
        (TABLE.replace('"table"', '"a/b.xml"'), r":3: key 'objects\[1\].name' is missing"),
        (TABLE.replace('"table"', '"a/b.xml"\nname = "x"'), ":4: key .*model' is wrong: .*a/b.xml"),
        (TABLE + 'name = "a b"\n', ":5: key .*name' is made of letters, digits"),
        (TABLE + '[[objects]]\nmodel = "table"\n', ":5: .*name' is taken: there is already"),
        (TABLE + "free = 1\n", ":5: key .*free' is true or false, got 1"),
        (TABLE + 'on = "tabel"\nposition = [0, 0]\n', ":5: key .*on' is the name of an object"),
        (TABLE + '[[objects]]\nmodel = "cube"\non = "table"\n', "position' is x and y in the"),
        (TABLE + "mas = 3\n", ":5: key .*mas' means nothing"),
        (
            '[[objects]]\nmodel = "bundled:basket"\nname = "x"\ncategory = "contaner"\n',
            ":4: .*category' is wrong: category 'contaner' is none; did you mean 'container'",
        ),
        (TABLE + '[[objects]]\nmodel = "cube"\nmass = -1\n', ":7: .*above 0 .* .kg., got -1"),
        (TABLE + "within_reach = 3\n", ":5: key .*within_reach' is true or false"),
        (TABLE + 'within_reach = "lfet"\n', "within_reach' is true or the name of a robot, got"),
        (TABLE + "region = { x = [0, 1] }\n", "region.y' is missing"),
        (TABLE + "region = { x = [1, 0], y = [0, 1], z = [0, 0] }\n", "goes from low to high"),
        (TABLE + "position = [0, 0, 0]\nregion = { }\n", "'region' exclude each other"),
        (
            ROBOT + "[[cameras]]\nfovy = 200\n",
            ":4: key .*fovy' is wrong: fovy must be a number above 0 and below 180 .degrees., got",
        ),
        (ROBOT + "[[cameras]]\nlooking_at = [0, 0, 0]\n", "cannot look at its own position"),
        (ROBOT + "[randomization.object.cube]\n", "'randomization.object' means nothing; .*s'"),
        (ROBOT + "[randomization.lights]\nkey = 3\n", "'randomization.lights.key' is a table"),
        (
            ROBOT + "[randomization.lights.key]\nbright = 3\n",
            ":4: key 'randomization.lights.key.bright' is wrong: .* did you mean 'brightness'",
        ),
        (
            ROBOT + "[randomization.objects.cube]\nmass = { unifrom = [0, 1] }\n",
            ":4: key 'randomization.objects.cube.mass' is wrong: .* did you mean 'uniform'",
        ),
        ("robots = ]", "not a TOML file: .*line 1"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_file_line_and_key(write, parts, text, message):
    path = write(text)
    with pytest.raises(SceneError, match=message) as raised:
        read_scene(path, parts)
    assert str(raised.value).startswith(str(path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            TABLE + '[[objects]]\nmodel = "cube"\nposition = [0.5, 0, 2]\n'
            '[[objects]]\nmodel = "can"\non = "cube"\nposition = [0.5, 0]\n',
            "'can' cannot be put there: 'cube' has no surface",
        ),
        (
            TABLE + '[[objects]]\nmodel = "cube"\non = "table"\n'
            "region = { x = [0, 0.1], y = [-4, -3] }\n",
            "'cube' is not on 'table' but 2.* m beside it, at .* -3.000; it extends from",
        ),
        (TABLE + "[randomization.robots.pand]\ngain = 1\n", "'pand' is not there; did .*'panda'"),
    ],
)
def test_what_cannot_stand_together_is_said_with_the_file(write, parts, text, message):
    path = write(text)
    scene = read_scene(path, parts)
    with pytest.raises(CellError, match=message) as raised:
        build_station(parts, scene=scene)
    assert str(raised.value).startswith(str(path))


@pytest.mark.parametrize(
    ("kind", "count", "line", "most"),
    [("objects", 251, 3, 250), ("robots", 17, 1, 16)],
)
def test_more_tables_than_a_scene_can_have_are_one_error(write, parts, kind, count, line, most):
    tables = "".join(
        f'[[{kind}]]\nname = "n{i}"\nmodel = "cube"\nposition = [0, 0, {i}]\n' for i in range(count)
    )
    path = write((ROBOT if kind == "objects" else "") + tables)
    with pytest.raises(SceneError) as raised:
        read_scene(path, parts)
    assert str(raised.value) == (
        f"{path}:{line}: key '{kind}' has {count} tables; a file has at most {most}"
    )


def test_without_registered_parts_their_names_are_not_checked(write):
    text = (
        ROBOT + 'robot = "a"\ncontroller = "b"\nplanner = "c"\n[[objects]]\nmodel = "d"\nsize = 9\n'
    )
    scene = read_scene(write(text))
    (robot,), (thing,) = scene.robots, scene.objects
    assert (robot.description, robot.controller, robot.planner, thing.model) == ("a", "b", "c", "d")
    assert thing.parameters == {"size": 9}


def test_lines_are_found_of_tables_arrays_dotted_and_quoted_keys():
    text = """a = 1
[b]
c.d = 2
[[e]]
x = 1
[[e]]
[e.f]
"g h" = 3
[i."j/k"]
l = [
  1,
]
m = 2
"""
    lines = line_numbers(text)
    assert [
        line_of(place, lines)
        for place in (
            ("a",), ("b", "c", "d"), ("e", 1, "x"), ("e", 2, "f", "g h"), ("i", "j/k", "l"),
            ("i", "j/k", "m"), ("e", 2, "none"), ("none",),
        )
    ] == [1, 3, 5, 8, 10, 13, 6, None]  # fmt: skip
    inline = 'objects = [\n    { model = "table" },\n    { model = "cube" },\n]\nseed = 3\n'
    lines = line_numbers(inline)
    assert (lines["objects", 1], lines["objects", 2], lines["seed",]) == (2, 3, 5)


def test_all_that_is_wrong_is_said_at_once(write, parts):
    text = (
        "seed = 'x'\n[[robots]]\nrobot = 'pand'\nposition = [0]\n"
        "[[objects]]\nmodel = 'tabel'\n[[objects]]\nmodel = 'cube'\nmass = -1\nfree = 2\n"
    )
    with pytest.raises(SceneError) as raised:
        read_scene(write(text), parts)
    lines = [int(re.search(r"toml:(\d+):", problem)[1]) for problem in raised.value.problems]
    assert sorted(lines) == [1, 3, 4, 6, 9, 10]


def test_a_run_of_a_varied_scene_is_told_in_its_report_and_can_be_repeated(parts, tmp_path):
    tree = tmp_path / "tree.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><Sequence><SpawnObject model="cube" '
        'on="table" object="{object}"/><WaitUntilAtRest object="{object}"/></Sequence>'
        "</BehaviorTree></root>"
    )
    digests, told = [], []
    for _ in range(2):
        recorder = Recorder("", 1)
        request = RunRequest(find_tree(str(tree), {}), scene="varied_pick", seed=1, cycles=2)
        prepare(request, parts).execute([recorder])
        report = recorder.report()
        assert report.status == "SUCCESS", [cycle.reason for cycle in report.cycles]
        digests.append(report.state_digest)
        told.append([cycle.randomized for cycle in report.cycles])
    assert digests[0] == digests[1]
    assert told[0] == told[1]
    first, second = told[0]
    assert first["objects"].keys() == {"cube", "basket"}
    assert first["objects"]["cube"].keys() == {"mass", "friction", "size", "colour"}
    assert first["objects"]["cube"]["mass"] != second["objects"]["cube"]["mass"]
