"""A description that is written is read back equal, field by field."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.robots import RobotDescription, panda, read_description
from bt_manip_setup import description_text

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(
    path
    for folder in ("plugins", "tests", "templates")
    for path in (ROOT / folder).rglob("*.toml")
    if "arm_joints" in path.read_text()
)
FULL = replace(
    read_description(ROOT / "tests" / "robots" / "models" / "post.toml"),
    name="another",
    armature=(0.0, 1.25e-7),
    exclude=(("foot", "left/link"),),
    configurations={
        "ready": (0.1, 0.2),
        "from a waypoint": {"lift": 0.1 + 0.2, "turn": -1e-9},
    },
)


def with_whole_paths(description: RobotDescription) -> RobotDescription:
    def whole(model: str | None) -> str | None:
        return model if model is None or ":" in model else str(Path(model).resolve())

    gripper = description.gripper
    if gripper is not None:
        gripper = replace(gripper, model=whole(gripper.model))
    return replace(description, model=whole(description.model), gripper=gripper)


def assert_equal(one, other) -> None:
    """Compare two dataclasses field by field; poses pass through a quaternion."""
    for field in fields(one):
        if not field.compare:
            continue
        first, second = getattr(one, field.name), getattr(other, field.name)
        if isinstance(first, pin.SE3):
            np.testing.assert_allclose(second.homogeneous, first.homogeneous, atol=1e-11)
        elif hasattr(first, "__dataclass_fields__"):
            assert_equal(first, second)
        else:
            assert first == second, field.name


@pytest.mark.parametrize(
    "description",
    [panda(), FULL, *map(read_description, FILES)],
    ids=["panda", "full", *(path.stem for path in FILES)],
)
def test_a_written_description_is_read_back_equal(description: RobotDescription, tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(description_text(description, {}, path, "an arm"))
    again = read_description(path)
    assert_equal(with_whole_paths(description), with_whole_paths(again))
