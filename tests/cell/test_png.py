"""A picture written as PNG is read back bit for bit, by MuJoCo's own reader."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import png, write_png


def read(data: bytes) -> np.ndarray:
    """Read a PNG as MuJoCo reads textures."""  # (height, width, 3)
    xml = '<mujoco><asset><texture name="t" type="2d" file="t.png"/></asset></mujoco>'
    model = mujoco.MjModel.from_xml_string(xml, {"t.png": data})
    return model.tex_data.reshape(model.tex_height[0], model.tex_width[0], 3)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 9, 3), (9, 1, 3), (37, 23, 3)])
def test_noise_comes_back(shape):
    pixels = np.random.default_rng(0).integers(0, 256, shape, dtype=np.uint8)
    np.testing.assert_array_equal(read(png(pixels)), pixels)


def test_each_way_to_filter_a_row_comes_back(tmp_path):
    y, x = np.mgrid[:40, :64]
    gradient = np.stack([x * 3, y * 5, x + y], axis=2).astype(np.uint8)
    pixels = np.concatenate([gradient, np.full((8, 64, 3), 200, np.uint8)])
    data = png(pixels)
    np.testing.assert_array_equal(read(data), pixels)
    assert len(data) < pixels.size / 20  # smooth pictures compress
    write_png(tmp_path / "picture.png", pixels)
    assert (tmp_path / "picture.png").read_bytes() == data


@pytest.mark.parametrize(
    "pixels",
    [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3)),
     np.zeros((0, 4, 3), np.uint8)],
)  # fmt: skip
def test_what_is_no_picture_is_refused(pixels):
    with pytest.raises(ValueError, match=r"expected \(height, width, 3\) of uint8"):
        png(pixels)
