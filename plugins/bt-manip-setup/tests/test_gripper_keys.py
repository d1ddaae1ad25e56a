"""The keys of a gripper that is measured on its model."""

from dataclasses import replace

import mujoco
import pytest

from bt_manip_setup import gripper_keys

from .finger_travel.mechanisms import described_arm, fingers_in, model_of


@pytest.mark.parametrize(
    ("kind", "changes", "keys"),
    [
        ("slides", {"friction": 4.9, "mass": 2.9}, {}),
        ("slides", {"friction": 5.1}, {"frictionloss": 0.0}),
        ("slides", {"mass": 3.1}, {"armature": 0.005}),
        ("slides", {"mass": 0.2}, {}),
        ("slide_and_hinge", {"mass": 0.2}, {}),
        ("hinges", {"mass": 0.0}, {}),
        ("hinges", {"mass": 0.29}, {"armature": 1e-3}),
        ("hinges", {"mass": 0.31}, {}),
    ],
)
def test_friction_and_inertia_with_which_fingers_do_not_grip_are_replaced(
    parts, tmp_path, monkeypatch, kind, changes, keys
):
    """Friction is of up to 5 N, and the effective mass of up to 3 kg, on hinges of 0.3 kg."""
    found = fingers_in(model_of(kind))
    changed = replace(found, travel=replace(found.travel, **changes))
    monkeypatch.setattr(gripper_keys, "find_fingers", lambda *_, **__: changed)
    file = tmp_path / "rig.xml"
    file.write_text(model_of(kind))
    arm, model = described_arm(file, tool_frame="palm"), mujoco.MjModel.from_xml_path(str(file))
    described, notes = gripper_keys.with_gripper(
        arm, parts, model, None, mount="palm", tool_frame=None, has_fingers=True
    )
    given, noted = described.gripper.parameters, ("frictionloss", "armature")
    assert {key: given[key] for key in noted if given.get(key) is not None} == keys
    assert {key for key in noted if f"gripper.{key}" in notes} == keys.keys()
    assert 0.0 <= found.travel.open_width - given["open_width"] < 1e-4
    limited = {"slides": 20.0, "hinges": 150.0}  # of two digits; 50 N where there is no motor
    assert described.gripper.max_force == limited.get(kind, 50.0)
    assert described.T_ft.isApprox(found.T_bt)
