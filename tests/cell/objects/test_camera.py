"""Cameras see what geometry says that they see."""

import numpy as np
import pytest
from dm_control import composer

from bt_manip.cell import Camera, Cell, CellError, Cube, looking_at
from bt_manip.cell.objects import RedBlock
from bt_manip.spatial import pose

pytestmark = pytest.mark.usefixtures("opengl")


@pytest.fixture(scope="module")
def cell():
    """A camera 0.5 m over the floor that looks straight down at a red block."""
    cell = Cell()
    cell.add(Camera(fovy=60.0, width=64, height=48), pose((0, 0, 0.5)))
    cell.add(RedBlock(size=0.1), pose((0, 0, 0.05)))
    yield cell
    cell.find("camera").close()


def test_depth_names_and_colours_are_those_of_what_is_seen_and_looking_changes_no_bit(cell):
    before, step = cell.state_bytes(), cell.data.contact.geom.tobytes()
    camera = cell.find("camera")
    depth = camera.depth()
    assert depth.shape == (48, 64)
    assert depth[24, 32] == pytest.approx(0.4, abs=2e-3)  # the block's top
    assert depth[1, 1] == pytest.approx(0.5, abs=2e-3)  # the floor, however far to the side
    seen = camera.segmentation()
    block, floor = seen.mask("red_block"), seen.mask("world")
    assert block[24, 32] and floor[1, 1] and not (block & floor).any()
    # 48 rows show 2 tan(30 deg) 0.4 m at the height of the top.
    rows = 0.1 / (2 * np.tan(np.radians(30)) * 0.4) * 48
    assert np.sqrt(block.sum()) == pytest.approx(rows, abs=1.5)
    assert not seen.mask("camera").any() and not seen.mask("nobody").any()
    case = cell.model.geom("camera/case")
    assert case.pos[2] > case.size[2] > 0.01 and case.size.max() < 0.05  # behind the camera
    picture = camera.rgb()
    assert picture.shape == (48, 64, 3) and picture.dtype == np.uint8
    red, green, blue = (float(c) for c in picture[24, 32])
    assert red > 1.5 * green and red > 1.5 * blue
    assert cell.state_bytes() == before and cell.data.contact.geom.tobytes() == step


def test_the_same_images_are_composers_observables(cell):
    camera = cell.find("camera")
    for observable in (camera.observables.rgb, camera.observables.depth):
        observable.enabled = True
    cell.arena.mjcf_model.visual.quality.set_attributes(shadowsize=64, offsamples=0)
    task = composer.NullTask(cell.arena)
    environment = composer.Environment(task, strip_singleton_obs_buffer_dim=True)
    observation = environment.reset().observation
    assert observation["camera/rgb"].shape == (48, 64, 3)
    assert observation["camera/depth"][24, 32, 0] == pytest.approx(0.4, abs=2e-3)
    environment.close()


def test_a_camera_without_a_cell_and_one_that_is_too_large_say_so():
    camera = Camera(width=4000)
    with pytest.raises(CellError, match="'camera' is not in a cell yet"):
        camera.rgb()
    Cell().add(camera, pose((1, 0, 1)))
    with pytest.raises(CellError, match="up to 1920 x 1200 pixels, got 4000 x 240"):
        camera.rgb()
    for key, most in (("fovy", 180), ("width", 8193), ("height", 8193)):
        with pytest.raises(CellError, match=f"{key} must be .*, got {most}"):
            Camera(**{key: most})


def test_an_image_is_of_now_and_of_what_is_there_now(cell):
    camera = cell.find("camera")
    assert camera.segmentation().mask("red_block").any()
    cell.remove("red_block")
    assert "red_block" not in camera.segmentation().names
    cell.add(Cube(), pose((0, 0, 0.3)))
    assert camera.depth()[24, 32] == pytest.approx(0.5 - 0.325, abs=2e-3)
    cell.step(100)
    fallen = 9.81 * 0.1**2 / 2
    assert camera.depth()[24, 32] == pytest.approx(0.5 - 0.325 + fallen, abs=2e-3)


def test_a_camera_looks_at_what_it_is_told_to():
    eye = np.array([1.0, 2.0, 3.0])
    for forward, up in (
        ((-0.7, -2.2, -2.9), (0, 0, 1)), ((0.1, 0.2, 3.0), (0, 0, 1)),
        ((0.0, 0.05, -1.0), (0, 0, 1)),  # 2.9 degrees beside the vertical
        ((0.0, 0.04, -1.0), (1, 0, 0)), ((0.0, 0.0, -6.0), (1, 0, 0)), ((0, 0, 2), (1, 0, 0)),
    ):  # fmt: skip
        T = looking_at(eye, eye + forward)
        assert (T.translation == eye).all() and np.linalg.det(T.rotation) == pytest.approx(1.0)
        assert -T.rotation[:, 2] == pytest.approx(forward / np.linalg.norm(forward))
        assert T.rotation[:, 0] @ up == pytest.approx(0.0) and T.rotation[:, 1] @ up > 0.0
        assert T.rotation.T @ T.rotation == pytest.approx(np.eye(3))
    with pytest.raises(CellError, match="its own position"):
        looking_at((1, 2, 3), (1, 2, 3))
