"""Arms put together from parts, as users bring them."""

from pathlib import Path

from tests.support.models import ROBOTS
from tests.support.small_arm import write_small_arm

SIX_JOINTS = ROBOTS / "six_joints.urdf"

_PART = """<link name="{name}"><inertial><mass value="0.05"/>
<inertia ixx="2e-5" iyy="2e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial>{shapes}</link>
<joint name="{name}_joint" type="{kind}"><parent link="{parent}"/><child link="{name}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/>{rest}</joint>"""

PLATFORM = """
<body name="platform">
  <joint name="drive_x" type="slide" axis="1 0 0" damping="10"/>
  <joint name="drive_y" type="slide" axis="0 1 0" damping="10"/>
  <joint name="drive_yaw" axis="0 0 1" damping="10"/>
  <geom name="wheels" type="box" size="0.06 0.06 0.02" pos="-0.2 0 0.02" density="2000"/>
  <body name="torso" pos="-0.2 0 0.04">
    <joint name="torso_lift" type="slide" axis="0 0 1" range="0 0.3"/>
    <geom type="box" size="0.03 0.03 0.2" pos="0 0 0.2" density="2000"/>
    <body name="head" pos="0 0 0.45">
      <joint name="head_pan" axis="0 0 1" range="-1 1"/>
      <geom type="sphere" size="0.05" density="500"/>
    </body>
  </body>
  {arm}
</body>
"""


def box(size: str, at: str = "0 0 0.06") -> str:
    """Return a collision box of URDF."""
    return f'<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>'


def limit(low: float, high: float, effort: float = 20.0) -> str:
    """Return the limits of a joint of URDF."""
    return f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="1"/>'


def part(
    name: str,
    shapes: str,
    kind: str,
    at: str,
    axis: str = "0 1 0",
    rest: str = "",
    parent: str = "mount",
) -> str:
    """Return a link of URDF and its joint, which is called ``NAME_joint``."""
    return _PART.format(**locals())


def write_arm(path: Path, parts: list[str]) -> Path:
    """Write the arm of six joints with further parts at its mount."""
    path.write_text(SIX_JOINTS.read_text().replace("</robot>", "".join(parts) + "</robot>"))
    return path


def write_mimic_arm(folder: Path) -> Path:
    """Write an arm of URDF with two sliding fingers, the second of which mimics the first."""
    pad, slides = box("0.02 0.01 0.04", "0 0 0.07"), limit(0.0, 0.04, 60)
    follows = slides + '<mimic joint="left_joint"/>'
    return write_arm(folder / "mimic.urdf", [
        part("left", pad, "prismatic", "0 0.005 0", "0 1 0", slides),
        part("right", pad, "prismatic", "0 -0.005 0", "0 -1 0", follows),
    ])  # fmt: skip


def write_jaw_arm(folder: Path) -> Path:
    """Write an arm of URDF with a jaw that turns towards a fixed one."""
    plate = box("0.02 0.01 0.1")
    return write_arm(folder / "jaw.urdf", [
        part("jaw", plate, "revolute", "0 0.006 0.01", "-1 0 0", limit(0.0, 0.7, 5)),
        part("palm", plate, "fixed", "0 -0.006 0.01", "1 0 0"),
    ])  # fmt: skip


def write_linkage_arm(folder: Path) -> Path:
    """Write an arm of URDF with light linkages that mimic one joint; some overlap."""
    parts, mimic = [], '<mimic joint="left_knuckle_joint"{}/>'
    for side, sign in (("left", 1), ("right", -1)):
        beam = box("0.01 0.006 0.04", "0 0 0.02")
        foot = box("0.02 0.03 0.01", f"0 {0.01 * sign} 0")  # inside the inner link
        pad = box("0.02 0.01 0.06", f"0 {-0.01 * sign} 0.03")
        turned, back = mimic.format(""), mimic.format(' multiplier="-1"')
        first = turned if side == "right" else ""
        for name, parent, shapes, at, coupling, low, high in (
            ("knuckle", "mount", beam, f"0 {0.015 * sign} 0.02", first, 0.0, 0.8),
            ("inner", "mount", beam, f"0 {0.035 * sign} 0.03", turned, 0.0, 0.8),
            ("finger", f"{side}_knuckle", pad + foot, "0 0 0.04", back, -0.8, 0.0),
        ):
            rest = limit(low, high) + coupling
            axis = f"{-sign} 0 0"
            parts.append(part(f"{side}_{name}", shapes, "revolute", at, axis, rest, parent))
    return write_arm(folder / "linkage.urdf", parts)


def write_mobile_arm(folder: Path) -> Path:
    """Write a small arm on a mobile platform with a torso and a head."""
    write_small_arm(folder)
    text = (folder / "small.xml").read_text()
    start, end = text.index('<body name="base">'), text.rindex("</worldbody>")
    path = folder / "mobile.xml"
    path.write_text(text[:start] + PLATFORM.format(arm=text[start:end]) + text[end:])
    return path
