"""A layout of Foxglove that opens the panels for a recording."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

MAX_STATES = 40
"""Largest number of leaves in the panel of state transitions."""


def foxglove_layout(
    robots: Mapping[str, Sequence[str]], leaves: Mapping[int, str], topics: Mapping[str, str]
) -> dict[str, Any]:
    """Return the layout as Foxglove imports it: scene, tree, plots, blackboard and log.

    It is made of the joints of robots, the names of leaves by uid, and the schemas of topics.
    """

    def of(*kinds: str) -> list[str]:
        return [topic for topic, name in topics.items() if name.removeprefix("foxglove.") in kinds]

    states = [
        _series(f"/tree/status{{uid=={uid}}}.status", name)
        for uid, name in list(leaves.items())[:MAX_STATES]
    ]
    panels: dict[str, Any] = {
        "3D!scene": {
            "followMode": "follow-none",
            "followTf": "world",
            "topics": {topic: {"visible": True} for topic in of("SceneUpdate", "PointCloud")},
            "cameraState": {
                "distance": 3.0, "phi": 60.0, "thetaOffset": 45.0, "perspective": True,
                "target": [0.0, 0.0, 0.0], "targetOffset": [0.3, 0.0, 0.8],
                "targetOrientation": [0.0, 0.0, 0.0, 1.0], "fovy": 45.0, "near": 0.01, "far": 100.0,
            },
        },
        "StateTransitions!tree": {"isSynced": True, "paths": states},
        "Plot!positions": _plot("Joint positions [rad]", robots, ("q", "q_ref")),
        "Plot!torques": _plot("Joint torques [N m]", robots, ("tau",)),
        "Plot!wrist": {
            "title": "Force on the gripper [N]",
            "isSynced": True,
            "paths": [
                _series(f"/robots/{robot}/state.force[{i}]", f"{robot} {axis}")
                for robot in robots
                for i, axis in enumerate("xyz")
            ],
        },
        "RawMessages!blackboard": {"topicPath": "/blackboard"},
        "RosOut!log": {"topicToRender": "/log", "minLogLevel": 1, "searchTerms": []},
    }  # fmt: skip
    tree = _split("column", "StateTransitions!tree", "RosOut!log", 70)
    plots = _split("row", "Plot!positions", _split("row", "Plot!torques", "Plot!wrist", 50), 34)
    view: Any = "3D!scene"
    for topic in of("CompressedImage"):
        beside = [one for one in of("ImageAnnotations") if Path(one).parent == Path(topic).parent]
        panel, shown = f"Image!{topic}", {one: {"visible": True} for one in beside}
        panels[panel] = {"imageMode": {"imageTopic": topic, "annotations": shown}}
        view = _split("column", view, panel, 60)
    above = _split("row", view, _split("column", tree, "RawMessages!blackboard", 75), 55)
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("column", above, plots, 65),
    }


def _plot(title: str, robots: Mapping[str, Sequence[str]], fields: Sequence[str]) -> dict[str, Any]:
    paths = [
        _series(f"/robots/{robot}/joints.{field}[{i}]", f"{joint} {field}")
        for robot, joints in robots.items()
        for i, joint in enumerate(joints)
        for field in fields
    ]
    return {"title": title, "isSynced": True, "paths": paths}


def _series(path: str, label: str) -> dict[str, Any]:
    return {"value": path, "label": label, "enabled": True, "timestampMethod": "receiveTime"}


def _split(direction: str, first: Any, second: Any, percent: int) -> dict[str, Any]:
    return {
        "direction": direction, "first": first, "second": second, "splitPercentage": percent
    }  # fmt: skip
