"""AprilTags: objects that show one, and their poses in frames (extra ``tags``)."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import ParametricEntity, png
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import Parameter

from .frame import Frame

FAMILY = "tag36h11"
"""The family of the tags; its black square is 8 cells wide, the white border one more."""

CODES = (
    0xD5D628584, 0xD97F18B49, 0xDD280910E, 0xE479E9C98, 0xEBCBCA822, 0xF31DAB3AC, 0x056A5D085,
    0x10652E1D4, 0x22B1DFEAD, 0x265AD0472, 0x34FE91B86, 0x3FF962CD5, 0x43A25329A, 0x474B4385F,
    0x4E9D243E9, 0x5246149AE,
)  # fmt: skip
"""The inner 6 x 6 cells of the first tags row by row, 1 for white (AprilTag 3, BSD license)."""

CELL_PIXELS = 16
"""Pixels of a cell in the texture."""

THICKNESS = 2e-3
"""Thickness of the plate of a tag [m]."""


class SeenTag(NamedTuple):
    """A tag in a frame.

    Attributes:
        number: Its number in the family.
        T_wt: Pose of its centre in the world: x to the right of its picture, z out of it.
        centre: Its centre in the image, column and row; the corners of pixels are whole numbers
            [pixels].  # (2,)
        corners: The corners of its black square, likewise: lower left, lower right, upper right
            and upper left of its picture.  # (4, 2)
    """

    number: int
    T_wt: pin.SE3
    centre: np.ndarray
    corners: np.ndarray


def detect_tags(frame: Frame, size: float, height: float | None = None) -> list[SeenTag]:
    """Return the tags in the colour image of a frame, in the order of their numbers.

    Args:
        frame: The frame.
        size: Length of the sides of their black squares [m].
        height: Height of the tags in the world where it is known, which makes the position
            several times as accurate; they then lie flat [m].

    Raises:
        BtManipError: If ``pupil-apriltags`` is not installed.
    """
    rows, columns = frame.depth.shape
    focal = frame.focal_length
    grey = (frame.colour @ np.array([0.299, 0.587, 0.114])).astype(np.uint8)
    principal = columns / 2.0, rows / 2.0  # the corners of pixels are whole numbers
    found = tag_detector().detect(grey, True, (focal, focal, *principal), size)
    flip = np.diag([1.0, -1.0, -1.0])  # their axes: y down, z away from the viewer
    seen = []
    for one in sorted(found, key=lambda one: one.tag_id):
        T_ct = pin.SE3(flip @ one.pose_R @ flip, flip @ one.pose_t[:, 0])
        T_wt, centre = frame.T_wc * T_ct, np.array(one.center)
        if height is not None:
            x, y = (centre - principal) / focal
            ray = frame.T_wc.rotation @ np.array([x, -y, -1.0])
            along = (height - frame.T_wc.translation[2]) / ray[2]
            yaw = float(np.arctan2(T_wt.rotation[1, 0], T_wt.rotation[0, 0]))
            T_wt = pin.SE3(pin.utils.rotate("z", yaw), frame.T_wc.translation + along * ray)
        seen.append(SeenTag(int(one.tag_id), T_wt, centre, np.array(one.corners)))
    return seen


@cache
def tag_detector() -> Any:
    """Return the detector of this process.

    Raises:
        BtManipError: If ``pupil-apriltags`` is not installed.
    """
    try:
        from pupil_apriltags import Detector
    except ImportError as error:
        raise BtManipError(
            "tags are detected by pupil-apriltags: pip install 'bt-manip-camera[tags]'"
        ) from error
    kept = type("KeptDetector", (Detector,), {"__del__": lambda self: None})  # its own one crashes
    return kept(FAMILY, nthreads=1, quad_decimate=1.0)


def tag_image(number: int) -> np.ndarray:
    """Return the picture of a tag with its white border.

    Args:
        number: Its number in the family, below ``len(CODES)``.

    Returns:
        Red, green and blue, the top row first.  # (160, 160, 3) uint8
    """
    cells = np.full((10, 10), 255, np.uint8)
    cells[1:9, 1:9] = 0
    bits = [(CODES[number] >> (35 - i)) & 1 for i in range(36)]
    cells[2:8, 2:8] = 255 * np.array(bits, np.uint8).reshape(6, 6)
    pixels = np.kron(cells, np.ones((CELL_PIXELS, CELL_PIXELS), np.uint8))
    return np.repeat(pixels[..., None], 3, axis=2)


class Tag(ParametricEntity):
    """A flat plate with an AprilTag of the family 36h11; its origin is the centre of its top."""

    kind = "april_tag"
    category = "thing"
    free = False
    defaults = {
        "number": Parameter("Number of the tag", "", 0, at_least=0, at_most=len(CODES) - 1),
        "size": Parameter("Length of the sides of its black square", "m", 0.032, above=0.0),
    }

    def _make_model(self, name: str) -> None:
        number, size = self._parameters["number"], self._parameters["size"]
        half = size * 10.0 / 8.0 / 2.0
        self._mjcf_root = root = mjcf.RootElement(model=name)
        picture = mjcf.Asset(png(tag_image(int(number))), ".png")
        texture = root.asset.add("texture", name="tag", type="2d", file=picture)
        material = root.asset.add(
            "material", name="tag", texture=texture, texuniform=False, texrepeat=[1, 1],
            specular=0.0,
        )  # fmt: skip
        body = root.worldbody.add("body", name="tag")
        body.add(
            "geom", name="plate", type="box", size=[half, half, THICKNESS / 2.0],
            pos=[0.0, 0.0, -THICKNESS / 2.0 - 1e-4], rgba=[0.9, 0.9, 0.9, 1.0], mass=0.01,
        )  # fmt: skip
        body.add(
            "geom", name="picture", type="box", size=[half, half, 5e-5], material=material,
            pos=[0.0, 0.0, -5e-5],
            contype=0, conaffinity=0, mass=0.0,
        )  # fmt: skip

    @property
    def rest_height(self) -> float:
        """Height of the top above its support [m]."""
        return THICKNESS + 1e-4
