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
    model, gripper = description.model, description.gripper
    again = read_description(path)
    absolute = again if model.startswith("menagerie:") else replace(again, model=model)
    assert Path(again.model).resolve() == Path(model).resolve() or absolute is again
    if gripper is not None and again.gripper.model is not None:
        assert Path(again.gripper.model).resolve() == Path(gripper.model).resolve() or (
            gripper.model.startswith("menagerie:")
        )
        absolute = replace(absolute, gripper=replace(again.gripper, model=gripper.model))
    assert_equal(description, absolute)
