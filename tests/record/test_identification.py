"""What was loaded identifies a run: each file, model, plugin and module is known by its content."""

import json
import struct
import sys
from dataclasses import replace

import pytest

from bt_manip.evaluation import EpisodeId, EpisodeWorker, Evaluation
from bt_manip.evaluation import evaluate as run_evaluation
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import PluginSelection
from bt_manip.record import identity_differences


def tetrahedron(size):
    """Return a mesh in the format STL."""
    a, b, c, d = (0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size)
    faces = [(a, c, b), (a, b, d), (a, d, c), (b, c, d)]
    rows = [struct.pack("<12fH", 0, 0, 0, *sum(face, ()), 0) for face in faces]
    return bytes(80) + struct.pack("<I", len(faces)) + b"".join(rows)


def meshed(body):
    return f"""
<mujoco><compiler angle="radian"/><asset><mesh name="m" file="NAME.stl"/></asset>
<worldbody>{body}</worldbody></mujoco>
"""


FILES = {
    "main.xml": """
<root BTCPP_format="4" main_tree_to_execute="Main"><include path="part.xml"/>
  <BehaviorTree ID="Main"><Sequence><Note/><SubTree ID="Part"/></Sequence></BehaviorTree></root>
""",
    "part.xml": """
<root BTCPP_format="4"><BehaviorTree ID="Part">
  <SpawnObject model="FOLDER/spawned.xml" on="table" region="0.3;0.4;0;0.1"/></BehaviorTree></root>
""",
    "scene.toml": """
[[robots]]
robot = "robot.toml"
position = [-0.1, 0, 1.015]
[[objects]]
model = "table"
[[objects]]
model = "thing.xml"
name = "thing"
on = "table"
position = [0.5, 0.3]
""",
    "thing.xml": '<mujoco><include file="inner.xml"/></mujoco>',
    "inner.xml": """
<mujocoinclude><worldbody><body name="w"><geom type="box" size=".02 .02 .02"/></body></worldbody>
</mujocoinclude>
""",
    "spawned.xml": meshed('<body name="s"><geom type="mesh" mesh="m"/></body>'),
    "spawned.stl": tetrahedron(0.04),
    "robot.toml": """
model = "arm.xml"
arm_joints = ["a", "b"]
home = [0.0, 1.0]
velocity = 2
acceleration = 3.0
jerk = [4, 5.5]
effort = 50
[tool]
frame = "tip"
""",
    "arm.xml": meshed("""
<body><geom type="mesh" mesh="m" mass="1"/>
  <body pos="0 0 .1"><joint name="a" axis="0 0 1" range="-3 3"/><geom size=".03"/>
    <body pos=".2 0 0"><joint name="b" axis="0 1 0" range="-2 2"/><geom size=".02"/>
      <site name="tip" pos=".2 0 0"/></body></body></body>
"""),
    "arm.stl": tetrahedron(0.05),
    "plugins/note.py": """
import bt_manip_helper_of_note
from bt_manip import hookimpl
from bt_manip.bt import Status, SyncAction


class Note(SyncAction):
    def update(self):
        return Status.SUCCESS


@hookimpl
def register_behaviours(register):
    register(Note)
""",
    "bt_manip_helper_of_note.py": "FORCE = 30\n",
}

CHANGES = {
    "main.xml": ("<Note/>", "<Note/><Note/>"),
    "part.xml": ("0.3;0.4", "0.3;0.5"),
    "scene.toml": ("0.5", "0.6"),
    "inner.xml": (".02", ".03"),
    "spawned.xml": ('"s"', '"t"'),
    "robot.toml": ("velocity = 2", "velocity = 1"),
    "arm.xml": ('mass="1"', 'mass="2"'),
    "plugins/note.py": ("return", "return  "),
    "bt_manip_helper_of_note.py": ("30", "5"),
}
PARTS = {"plugins/note.py": "note", "bt_manip_helper_of_note.py": "bt_manip_helper_of_note"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name, content in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        if isinstance(content, str):
            content = content.replace("FOLDER", str(tmp_path)).replace("NAME", path.stem).encode()
        path.write_bytes(content)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    return tmp_path


@pytest.fixture
def worker(folder):
    def worker(tree="main.xml", **more):
        for name in ("_bt_manip_plugin_note", "bt_manip_helper_of_note"):
            sys.modules.pop(name, None)  # as in another process
        options = {"scene": str(folder / "scene.toml")}
        choice = PluginSelection(folders=(folder / "plugins",))
        return EpisodeWorker(Evaluation(str(folder / tree), options, choice=choice, **more))

    yield worker
    for name in ("_bt_manip_plugin_note", "bt_manip_helper_of_note"):
        sys.modules.pop(name, None)


def test_each_file_that_was_loaded_is_known_by_its_content(folder, worker):
    before = worker().identity
    for name, (old, new) in CHANGES.items():
        path = folder / name
        path.write_text(path.read_text().replace(old, new))
    for name in ("spawned", "arm"):
        (folder / f"{name}.stl").write_bytes(tetrahedron(0.06))
    lines = identity_differences(before, worker().identity).values()
    assert sorted(line.partition(" differs")[0] for line in lines) == sorted(
        [*(PARTS.get(name, name) for name in CHANGES), "files of arm.xml", "files of spawned.xml"]
    )
    assert all("(SHA-256 " in line for line in lines)


def test_another_version_of_a_plugin_is_a_difference_and_what_only_one_has_loaded_is_none(worker):
    here = worker().identity
    there = json.loads(json.dumps(here))
    there["sha256"] = {**there["sha256"], "of an earlier run.xml": "0"}
    assert identity_differences(here, there) == {}
    there["plugins"]["note"], there["versions"]["mujoco"] = "2", "1.0"
    found = identity_differences(here, there)
    assert found.pop("plugins note") == "plugins note '' instead of '2'"
    assert [*found] == ["versions mujoco"] and "instead of '1.0'" in found["versions mujoco"]
    with pytest.raises(BtManipError, match="a worker is of another evaluation: .*plugins note"):
        worker(identity=there)
    del there["plugins"], there["sha256"]
    assert identity_differences(here, there).keys() >= {"sha256"}


LATE = """
<root BTCPP_format="4" main_tree_to_execute="Late"><BehaviorTree ID="Late"><Sequence>
  <Script code="m := 'FOLDER/spawned.xml'"/>
  <SpawnObject model="{m}" on="table" region="0.3;0.4;0;0.1"/></Sequence></BehaviorTree></root>
"""


def test_what_is_loaded_only_while_episodes_run_is_compared_between_them(folder, worker):
    (folder / "late.xml").write_text(LATE.replace("FOLDER", str(folder)))
    one = worker("late.xml")
    assert "spawned.xml" not in one.identity["sha256"]
    first = one.run(EpisodeId(0, 0))
    assert first.success and {"spawned.xml", "files of spawned.xml"} == {*json.loads(first.files)}
    (folder / "spawned.stl").write_bytes(tetrahedron(0.06))
    evaluation = replace(one.evaluation, identity=one.identity)
    with pytest.raises(BtManipError, match=r"files of spawned.xml differs between the episodes"):
        list(run_evaluation(evaluation, 2, before=[first]))
