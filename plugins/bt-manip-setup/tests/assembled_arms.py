"""Arms put together from parts, as users bring them."""

from pathlib import Path

from tests.support.models import ROBOTS
from tests.support.small_arm import write_small_arm

SIX_JOINTS = ROBOTS / "six_joints.urdf"

_LINK = """<link name="{name}"><inertial><mass value="0.05"/>
<inertia ixx="2e-5" iyy="2e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial>{boxes}</link>"""
_BOX = """<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>"""
_JOINT = """<joint name="{name}" type="{type}"><parent link="mount"/><child link="{child}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/>{rest}</joint>"""
_LIMIT = '<limit lower="{low}" upper="{high}" effort="{effort}" velocity="1"/>'

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


def write_mimic_arm(folder: Path) -> Path:
    """Write an arm of URDF with two sliding fingers, the second of which mimics the first."""
    pad = _BOX.format(at="0 0 0.07", size="0.02 0.01 0.04")
    links = [_LINK.format(name=name, boxes=pad) for name in ("left", "right")]
    limit = _LIMIT.format(low=0.0, high=0.04, effort=60)
    links.append(_JOINT.format(name="grip", type="prismatic", child="left", at="0 0.005 0",
                               axis="0 1 0", rest=limit))  # fmt: skip
    links.append(_JOINT.format(name="other", type="prismatic", child="right", at="0 -0.005 0",
                               axis="0 -1 0", rest=limit + '<mimic joint="grip"/>'))  # fmt: skip
    return _write(folder / "mimic.urdf", links)


def write_jaw_arm(folder: Path) -> Path:
    """Write an arm of URDF with a jaw that turns towards a fixed one."""
    plate = _BOX.format(at="0 0 0.06", size="0.02 0.01 0.1")
    links = [_LINK.format(name=name, boxes=plate) for name in ("jaw", "palm")]
    links.append(_JOINT.format(name="jaw_joint", type="revolute", child="jaw", at="0 0.006 0.01",
                               axis="-1 0 0",
                               rest=_LIMIT.format(low=0.0, high=0.7, effort=5)))  # fmt: skip
    links.append(_JOINT.format(name="fixed", type="fixed", child="palm", at="0 -0.006 0.01",
                               axis="1 0 0", rest=""))  # fmt: skip
    return _write(folder / "jaw.urdf", links)


def write_linkage_arm(folder: Path) -> Path:
    """Write an arm of URDF with light linkages that mimic one joint; some overlap."""
    links, mimic = [], '<mimic joint="left_knuckle_joint"{}/>'
    for side, sign in (("left", 1), ("right", -1)):
        beam = _BOX.format(at="0 0 0.02", size="0.01 0.006 0.04")
        foot = _BOX.format(at=f"0 {0.01 * sign} 0", size="0.02 0.03 0.01")  # inside the inner link
        pad = _BOX.format(at=f"0 {-0.01 * sign} 0.03", size="0.02 0.01 0.06")
        turned, back = mimic.format(""), mimic.format(' multiplier="-1"')
        first = turned if side == "right" else ""
        for name, parent, boxes, at, coupling, low, high in (
            ("knuckle", "mount", beam, f"0 {0.015 * sign} 0.02", first, 0.0, 0.8),
            ("inner", "mount", beam, f"0 {0.035 * sign} 0.03", turned, 0.0, 0.8),
            ("finger", f"{side}_knuckle", pad + foot, "0 0 0.04", back, -0.8, 0.0),
        ):
            limit = _LIMIT.format(low=low, high=high, effort=20)
            joint = _JOINT.format(name=f"{side}_{name}_joint", type="revolute", at=at,
                                  child=f"{side}_{name}", axis=f"{-sign} 0 0",
                                  rest=limit + coupling)  # fmt: skip
            links.append(_LINK.format(name=f"{side}_{name}", boxes=boxes))
            links.append(joint.replace('"mount"', f'"{parent}"'))
    return _write(folder / "linkage.urdf", links)


def write_mobile_arm(folder: Path) -> Path:
    """Write a small arm on a mobile platform with a torso and a head."""
    write_small_arm(folder)
    text = (folder / "small.xml").read_text()
    start, end = text.index('<body name="base">'), text.rindex("</worldbody>")
    path = folder / "mobile.xml"
    path.write_text(text[:start] + PLATFORM.format(arm=text[start:end]) + text[end:])
    return path


def _write(path: Path, parts: list[str]) -> Path:
    path.write_text(SIX_JOINTS.read_text().replace("</robot>", "".join(parts) + "</robot>"))
    return path
