"""Random poses of a box or a cylinder among other objects, seen by a camera with errors."""

import time
from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np
import pytest

from bt_manip.cell import looking_at
from bt_manip_camera.estimation import KnownObject, NotSeenError, estimate_pose
from bt_manip_camera.frame import Frame, focal_length
from bt_manip_camera.noise import DepthErrors
from bt_manip_camera.renderer import KeptRenderer

SCENE = """<mujoco><visual><global offwidth="640" offheight="480"/><map znear="0.02"/></visual>
<worldbody><light pos="0 0 3"/>
<geom name="table" type="box" size=".6 .8 .02" pos=".3 0 .98" rgba=".6 .45 .3 1"/>
<body name="obj" mocap="true"><geom type="{kind}" size="{size}" rgba=".8 .2 .15 1"/></body>
<body pos=".42 .16 1.03"><geom type="cylinder" size=".03 .03" rgba=".2 .4 .8 1"/></body>
<body pos=".2 -.15 1.025"><geom type="box" size=".04 .02 .025" rgba=".2 .7 .25 1"/></body>
<body name="cam" mocap="true"><camera name="eye" fovy="{fovy}"/></body></worldbody></mujoco>"""

OTHERS = (
    KnownObject("can", "cylinder", (0.06, 0.06, 0.06)),
    KnownObject("block", "box", (0.08, 0.04, 0.05)),
)
COLOURS = ((0.8, 0.2, 0.15), (0.2, 0.4, 0.8), (0.2, 0.7, 0.25))


@dataclass(frozen=True)
class Trial:
    """What one estimate was like; errors in mm and degrees, of those that were not refused."""

    kind: str
    smallest: float
    distance: float
    refused: str
    position: float = np.nan
    yaw: float = np.nan
    expected: float = np.nan
    seconds: float = np.nan

    @property
    def wrong(self):
        """Whether another object was taken for it, which is at least 120 mm away."""
        return self.position > 20.0


def trials(number, seed=0, errors=None, colours=False, surface=1.0, width=640, height=480):
    """Give trials, with boxes and cylinders in turn."""
    renderer, fovy = KeptRenderer(width, height), 50.0
    errors = errors or DepthErrors()
    for i in range(number):
        rng = np.random.default_rng((seed, i))
        if i % 2:
            kind, size = "cylinder", rng.uniform(0.03, 0.08, 2)[[0, 0, 1]]
            geom = f"{size[0] / 2} {size[2] / 2}"
        else:
            kind, size = "box", rng.uniform(0.03, 0.08, 3)
            geom = " ".join(str(side / 2) for side in size)
        model = mujoco.MjModel.from_xml_string(SCENE.format(kind=kind, size=geom, fovy=fovy))
        data = mujoco.MjData(model)
        yaw = rng.uniform(-np.pi, np.pi)
        at = np.array([rng.uniform(0.24, 0.36), rng.uniform(-0.06, 0.06), 1.0 + size[2] / 2])
        distance, azimuth = rng.uniform(0.4, 0.9), rng.uniform(-np.pi, np.pi)
        elevation = np.radians(rng.uniform(35.0, 90.0))
        target = at + np.append(rng.uniform(-0.04, 0.04, 2), 0.0)
        flat = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
        T_wc = looking_at(target + distance * np.append(flat, np.sin(elevation)), target)
        obj, cam = (int(model.body(name).mocapid[0]) for name in ("obj", "cam"))
        data.mocap_pos[obj] = at
        data.mocap_quat[obj] = [np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
        data.mocap_pos[cam] = T_wc.translation
        mujoco.mju_mat2Quat(data.mocap_quat[cam], T_wc.rotation.ravel())
        colour, depth = renderer.render(model, data, int(model.camera("eye").id))
        frame = Frame(
            errors.corrupt(depth, rng), colour, focal_length(height, fovy),
            T_wc * errors.calibration_error(rng),
        )  # fmt: skip
        known = [KnownObject("obj", kind, tuple(size)), *OTHERS]
        if colours:
            known = [
                KnownObject(one.name, one.shape, one.size, colour)
                for one, colour in zip(known, COLOURS, strict=True)
            ]
        start = time.process_time()
        smallest = float(size[:2].min())
        try:
            found = estimate_pose(frame, known[0], others=known[1:], surface=surface)
        except NotSeenError as error:
            yield Trial(kind, smallest, distance, str(error))
            continue
        seconds = time.process_time() - start
        turn = np.pi / 2 if abs(size[0] - size[1]) < 4e-3 else np.pi
        rotation = found.T_wo.rotation
        off = (np.arctan2(rotation[1, 0], rotation[0, 0]) - yaw + turn / 2) % turn - turn / 2
        gap = found.T_wo.translation - at
        yield Trial(
            kind, smallest, distance, "", 1e3 * np.linalg.norm(gap),
            np.degrees(abs(off)) if kind == "box" else 0.0, 1e3 * found.position_error, seconds,
        )  # fmt: skip


def table(results):
    """Give the lines of a table: by shape, size and distance."""
    groups = {"all": results}
    for kind in ("box", "cylinder"):
        groups[kind] = [one for one in results if one.kind == kind]
    for key, bounds in (
        ("smallest", (0.03, 0.04, 0.06, 0.08)),
        ("distance", (0.4, 0.55, 0.75, 0.9)),
    ):
        for low, high in pairwise(bounds):
            name = f"{key.replace('smallest', 'smallest side')} {low} to {high} m"
            groups[name] = [one for one in results if low <= getattr(one, key) < high]
    yield "| group | poses | refused | wrong | position median / 95 % [mm] | yaw [deg] | ms |"
    yield "|---|---|---|---|---|---|---|"
    for name, group in groups.items():
        seen = [one for one in group if not one.refused]
        boxes = [one.yaw for one in seen if one.kind == "box"] or [0.0]
        position = [one.position for one in seen]
        shown = (
            " / ".join(f"{x:.2f}" for x in np.percentile(v, (50, 95))) for v in (position, boxes)
        )
        counts = len(seen), len(group) - len(seen), sum(one.wrong for one in seen)
        seconds = 1e3 * np.percentile([one.seconds for one in seen], 95)
        yield f"| {name} | {' | '.join(map(str, (*counts, *shown)))} | {seconds:.0f} |"


def test_poses_are_accurate_and_no_other_object_is_taken(opengl):
    found = [one for one in trials(10, colours=True) if not one.refused]
    assert len(found) >= 9
    assert not any(one.wrong for one in found)
    assert np.median([one.position for one in found]) < 1.2
    assert np.median([one.yaw for one in found if one.kind == "box"]) < 0.5


@pytest.mark.soak
@pytest.mark.parametrize("colours", [False, True], ids=["by size", "by size and colour"])
def test_500_poses(opengl, colours):
    results = list(trials(500, colours=colours))
    print("", *table(results), sep="\n")
    found = [one for one in results if not one.refused]
    assert not any(one.wrong for one in found)
    assert np.median([one.position for one in found]) <= 1.2
    assert np.median([one.yaw for one in found if one.kind == "box"]) <= 0.5
    assert np.median([one.seconds for one in found]) <= 0.1
    assert np.mean([one.position < 2.0 * one.expected for one in found]) > 0.85
