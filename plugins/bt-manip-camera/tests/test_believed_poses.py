"""Each built-in behaviour ends on a believed pose that is 5 mm off as on a true one."""

from dataclasses import replace

import pytest

from bt_manip import build_station
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell.randomization import Randomization
from bt_manip.plugins import load_plugins
from bt_manip.scenes import SceneObject
from bt_manip.spatial import pose
from bt_manip.testing import AT_REST, Situations, Trial, play
from bt_manip_camera.estimation import Estimate
from bt_manip_contracts import Example

OFF = (4e-3, -3e-3, 0.0)
"""Where objects are believed from where they are [m]."""

REACHED, HELD, MOVED = "around the cube", "holding a cube", "after a motion"

EXAMPLES = {
    "BackOff": Example({"distance": 0.05}, MOVED),
    "Drop": Example({"container": "basket"}, HELD),
    "FollowTarget": Example({"object": "cube", "duration": 0.3}),
    "Grasp": Example({"object": "cube"}, REACHED),
    "Hover": Example({"object": "cube", "height": 0.15}),
    "IsAt": Example({"pose": "0.4;0;1.3"}, status="FAILURE"),
    "IsHolding": Example({"object": "cube"}, HELD),
    "IsIn": Example({"object": "cube", "container": "basket"}, status="FAILURE"),
    "IsOn": Example({"object": "cube", "support": "table"}),
    "Lift": Example({"height": 0.1}, HELD),
    "MoveArc": Example({"via": "0.38;-0.05;1.42", "pose": "0.4;-0.1;1.4;0;1;0;0"}),
    "MoveHome": Example(start=HELD),
    "MoveLinear": Example({"pose": "0.4;-0.05;1.4;0;1;0;0"}),
    "MoveThrough": Example({"poses": "0.4;-0.05;1.4;0;1;0;0|0.4;-0.05;1.3;0;1;0;0"}),
    "MoveToConfiguration": Example({"configuration": "0.1;-0.6;0.1;-2.2;0.1;1.6;0.9"}),
    "MoveToPose": Example({"pose": "0.35;-0.2;1.3;0;1;0;0"}),
    "ObjectExists": Example({"object": "cube"}),
    "OpenGripper": Example(start=HELD),
    "PlaceAt": Example({"object": "cube", "pose": "0.3;-0.2;1.015"}, HELD),
    "PlaceOn": Example({"object": "cube", "support": "other"}, HELD),
    "Reach": Example({"object": "cube"}),
    "RemoveObject": Example({"object": "cube"}),
    "SpawnObject": Example({"object": "{object}"}),
    "WaitUntilAtRest": Example({"object": "cube"}),
}


@pytest.fixture(scope="module")
def situations(parts, opengl):
    scene = parts.scenes.create("table_seen")
    known = tuple(one for one in scene.objects if one.model != "cube")
    cubes = [
        SceneObject("cube", name, pose((*at, 1.04)), {"size": 0.05}, free=True, expected=True)
        for name, at in (("cube", (0.3, 0.1)), ("other", (0.35, -0.15)))
    ]
    scene = replace(scene, objects=(*known, *cubes), randomization=Randomization())
    made = Situations(lambda: build_station(parts, scene=scene, poses="seen"))
    made.add(AT_REST, believe, after=None)
    made.add(MOVED, lambda s: move(s, "MoveLinear", pose="0.4;-0.05;1.4;0;1;0;0"))
    made.add(REACHED, lambda s: (move(s, "Hover", object="cube"), move(s, "Reach", object="cube")))
    made.add(HELD, lambda s: (move(s, "Grasp", object="cube"), move(s, "Lift")), after=REACHED)
    return made


def move(station, name, **ports):
    play(station, station.parts.behaviours.get(name)(**ports))


def believe(station):
    """Let both cubes be believed, and what is added later: 5 mm off, without a camera."""
    station.hardware.step(100)  # until the cubes rest
    poses = station.believed.poses

    def look(name, T_wo):
        seen = station.cell.pose(name)
        seen.translation += OFF
        poses.source.report(Estimate(name, seen, 1e-3, 0.0, station.cell.time, "eye"))

    poses.source.look = look
    assert all(poses.add(poses.next().name) for _ in range(2))
    station.hardware.step(1)


@pytest.mark.parametrize("name", load_plugins().working("builtin").provides["behaviours"])
def test_it_ends_as_with_the_true_pose(parts, situations, name):
    cls, example = parts.behaviours.get(name), EXAMPLES.get(name, Example())
    required = {port.name for port in cls.ports.values() if port.mandatory}
    assert required <= {*example.ports}, f"give an example of {name} in EXAMPLES of this file"
    station = situations.reset(example.start)
    trial = Trial(station, Tree(cls(**example.ports), clock=station.clock))
    assert trial.until_done(20.0) is NodeStatus[example.status], trial.explain()
