"""Objects of a scene that are alike."""

import mujoco
import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.scenes.scene_file import SceneError, read_scene

ROBOT = "[[robots]]\nposition = [-0.1, 0.0, 1.015]\n"
PARTS = """
[[objects]]
model = "table"
[[objects]]
model = "cube"
name = "part"
count = 3
on = "table"
region = { x = [0.2, 0.4], y = [-0.3, 0.3] }
"""


@pytest.fixture
def read(tmp_path, parts):
    def read(text: str):
        path = tmp_path / "scene.toml"
        path.write_text(ROBOT + text)
        return read_scene(path, parts)

    return read


def masses(model: mujoco.MjModel) -> dict[str, float]:
    """Return the mass of each body of MuJoCo's model [kg]."""
    names = (mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i) for i in range(model.nbody))
    return dict(zip(names, model.body_mass.tolist(), strict=True))


def test_as_many_objects_are_compiled_as_are_counted_and_one_can_differ(read, parts):
    scene = read(PARTS + "part_2.mass = 0.3\npart_2.position = [0.1, 0.35]\n")
    cell = build_station(parts, scene=scene).cell
    found = masses(cell.model)
    assert [f"part_{i}/cube" in found for i in (1, 2, 3, 4)] == [True, True, True, False]
    assert found["part_2/cube"] == pytest.approx(0.3)
    assert found["part_1/cube"] == found["part_3/cube"] != found["part_2/cube"]
    np.testing.assert_allclose(cell.pose("part_2").translation[:2], (0.1, 0.35), atol=1e-9)
    assert 0.2 <= cell.pose("part_1").translation[0] <= 0.4


def test_without_a_name_the_model_is_numbered(read):
    scene = read(PARTS.replace('name = "part"\n', ""))
    assert [one.name for one in scene.objects] == ["table", "cube_1", "cube_2", "cube_3"]


def test_one_of_them_can_be_varied(read, parts, tmp_path):
    read(PARTS)
    tree = tmp_path / "tree.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree></root>'
    )
    request = RunRequest(
        find_tree(str(tree), {}),
        scene=str(tmp_path / "scene.toml"),
        varied={"scene.objects.part_2.mass": 0.4},
    )
    run = prepare(request, parts)
    run.station.randomizer.begin(0)
    found = masses(run.station.cell.model)
    assert found["part_2/cube"] == pytest.approx(0.4) != found["part_1/cube"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            PARTS + '[[objects]]\nmodel = "cube"\nname = "part_2"\non = "table"\n'
            "position = [0.1, 0.1]\n",
            "scene.toml:14: key 'objects[3].name' is taken: there is already a 'part_2'",
        ),
        (PARTS.replace("3\n", "0\n", 1), "scene.toml:9: key 'objects[2].count' is a number from 1"),
        (PARTS.replace("3\n", "300\n", 1), "is a number from 1 to 250, got 300"),
        (PARTS.replace("3\n", "250\n", 1), "makes 251 objects; a file has at most 250"),
        (PARTS + "part_2.mas = 0.3\n", "scene.toml:12: key 'objects[2].part_2.mas' means nothing; "
         "did you mean 'mass'?"),
        (PARTS + "mas = 0.3\n", "scene.toml:12: key 'objects[2].mas' means nothing"),
        (PARTS + "part_4.mass = 0.3\n", "scene.toml:12: key 'objects[2].part_4' means nothing"),
        (PARTS + "part_2 = 1\n", "scene.toml:12: key 'objects[2].part_2' is a table, got 1"),
    ],
)  # fmt: skip
def test_what_cannot_be_counted_is_named_with_its_line(read, text, message):
    with pytest.raises(SceneError) as raised:
        read(text)
    assert message in str(raised.value) and len(raised.value.problems) == 1
