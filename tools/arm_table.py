"""Write the page docs/arm_table.md: arms of others, described untouched, and how often they pick.

``python tools/arm_table.py FOLDER`` describes every arm whose model is below a folder with copies
of public models, and runs 10 cycles of pick_place with it; the folder has ``menagerie`` and
``menagerie_more`` (models of MuJoCo Menagerie), and repositories by their names. Rows of arms that
are not there are kept as they are. It takes about a minute for each arm.
"""

import argparse
import os
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("MUJOCO_GL", "disable")

from bt_manip import load_plugins
from bt_manip.exceptions import BtManipError
from bt_manip_setup import describe_robot, try_robot

PAGE = Path(__file__).resolve().parent.parent / "docs" / "arm_table.md"
CYCLES = 10
HEAD = f"""# Arms of others

Models as their makers wrote them, described by `bt-manip robot new` without any edit: cycles of
`pick_place` that succeeded of {CYCLES} (a trial ends after three failures), or why not. Made by
`python tools/arm_table.py FOLDER`. Models of xacro were expanded first.

| arm | gripper | source | described | picks |
| --- | --- | --- | --- | --- |
"""
WHY = """
## Why not all

- Lite 6: its gripper opens to 18 mm, and the cube is 50 mm wide.
- UR5e with the 2F-85 of URDF: the file gives the inner fingers, which mimic the driven joint with
  the opposite sign, a range of positive angles only, so that they stop the mechanism; the 2F-85 of
  Menagerie picks.
- YAM: each fingertip is one mesh, whose hull fills the room between the tips; its maker excludes
  their contact. Decomposing a tip takes minutes, and with coarse settings of coacd, which take
  30 s, the opening is no smooth function of the joint.
- SO-100 of URDF: its gripper and jaw have no collision geometry.

The SO-101 needs `pip install 'bt-manip[convex]'`: its jaws are concave.
"""
_LENGTH = 160  # largest number of characters of a reason


class Row(NamedTuple):
    """An arm, and its model and gripper's below the folder; no gripper: the arm's own."""

    arm: str
    source: str
    model: str
    gripper: str = ""


_MENAGERIE = "MuJoCo Menagerie"
_2F85 = "menagerie/robotiq_2f85/2f85.xml"
_UR5E = "menagerie/universal_robots_ur5e/ur5e.xml"
_SO = "SO-ARM100/Simulation"
ROWS = (
    Row("Franka Panda", _MENAGERIE, "menagerie/franka_emika_panda/panda.xml"),
    Row("Franka FR3", _MENAGERIE, "menagerie/franka_fr3/fr3.xml", _2F85),
    Row("KUKA iiwa 14", _MENAGERIE, "menagerie/kuka_iiwa_14/iiwa14.xml", _2F85),
    Row("UR5e", _MENAGERIE, _UR5E, _2F85),
    Row("xArm 7", _MENAGERIE, "menagerie/ufactory_xarm7/xarm7.xml"),
    Row("Kinova Gen3", _MENAGERIE, "menagerie_more/kinova_gen3/gen3.xml", _2F85),
    Row("ViperX 300 S", _MENAGERIE, "menagerie_more/trossen_vx300s/vx300s.xml"),
    Row("WidowX 250 S", _MENAGERIE, "menagerie_more/trossen_wx250s/wx250s.xml"),
    Row("SO-ARM100", _MENAGERIE, "menagerie_more/trs_so_arm100/so_arm100.xml"),
    Row("Unitree Z1", _MENAGERIE, "unitree_z1/z1_gripper.xml"),
    Row("xArm 5 (URDF)", "xArm-Developer/xarm_ros", "expanded/xarm5_gripper.urdf"),
    Row("xArm 6 (URDF)", "xArm-Developer/xarm_ros", "expanded/xarm6_gripper.urdf"),
    Row("xArm 7 (URDF)", "xArm-Developer/xarm_ros", "expanded/xarm7_gripper.urdf"),
    Row("Lite 6 (URDF)", "xArm-Developer/xarm_ros", "expanded/lite6_gripper.urdf"),
    Row("UR5e", "ros-industrial-attic/robotiq", _UR5E, "expanded/robotiq_2f_85.urdf"),
    Row("UR5e", "ros-industrial-attic/robotiq", _UR5E, "expanded/robotiq_2f_140.urdf"),
    Row("ViperX 250", "Interbotix/interbotix_ros_manipulators", "expanded/vx250.urdf"),
    Row("ViperX 300 S (URDF)", "Interbotix/interbotix_ros_manipulators", "expanded/vx300s.urdf"),
    Row("WidowX 200", "Interbotix/interbotix_ros_manipulators", "expanded/wx200.urdf"),
    Row("WidowX 250 S (URDF)", "Interbotix/interbotix_ros_manipulators", "expanded/wx250s.urdf"),
    Row("I2RT YAM", "i2rt-robotics/i2rt", "i2rt/i2rt/robot_models/arm/yam/yam.xml",
        "i2rt/i2rt/robot_models/gripper/linear_4310/linear_4310.xml"),
    Row("SO-100 (URDF)", "TheRobotStudio/SO-ARM100", f"{_SO}/SO100/so100.urdf"),
    Row("SO-101 (URDF)", "TheRobotStudio/SO-ARM100", f"{_SO}/SO101/so101_new_calib.urdf"),
    Row("SO-101 (MJCF)", "TheRobotStudio/SO-ARM100", f"{_SO}/SO101/so101_new_calib.xml"),
)  # fmt: skip


def described(row: Row, folder: Path) -> tuple[str, str]:
    """Return whether an arm is described, and its picks, as cells of the table."""
    parts = load_plugins().parts
    gripper = str(folder / row.gripper) if row.gripper else None
    try:
        draft = describe_robot(str(folder / row.model), parts, name="arm", gripper=gripper)
    except BtManipError as error:
        return "refused", shortened_reason(str(error), folder)
    if draft.description.gripper is None:
        return "yes", "no gripper found"
    trial = try_robot(draft.description, parts, CYCLES)
    picks = [fact for fact in trial.facts if fact.startswith("pick_place")]
    cell = picks[0].removeprefix("pick_place: ").replace(" cycles", "") if picks else ""
    return "yes", "; ".join(
        [cell, *(shortened_reason(line, folder) for line in trial.findings[:1])]
    )


def shortened_reason(reason: str, folder: Path) -> str:
    """Return a reason without paths and with few characters."""
    text = " ".join(reason.replace(f"{folder}/", "").replace("|", "/").split())
    return text if len(text) <= _LENGTH else f"{text[:_LENGTH]} ..."


def _line(row: Row, cells: tuple[str, str]) -> str:
    gripper = Path(row.gripper).stem or "its own"
    return f"| {row.arm} | {gripper} | {row.source} | {cells[0]} | {cells[1]} |"


def main() -> None:
    """Write the table after each arm."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", metavar="TEXT", help="rows that contain this text")
    given = parser.parse_args()
    folder = given.folder.resolve()
    kept = {}
    for line in PAGE.read_text().splitlines() if PAGE.exists() else ():
        kept[tuple(line.split(" | ")[:3])] = line
    lines = {row: kept.get(tuple(_line(row, ("", "")).split(" | ")[:3])) for row in ROWS}
    for row in ROWS:
        if (folder / row.model).is_file() and given.only in " ".join(row):
            lines[row] = _line(row, described(row, folder))
            PAGE.write_text(HEAD + "\n".join(filter(None, lines.values())) + f"\n{WHY}")
            print(lines[row], flush=True)


if __name__ == "__main__":
    main()
