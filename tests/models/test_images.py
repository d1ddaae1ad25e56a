"""Images on meshes, and meshes whose corners differ in their place on an image."""

import mujoco
import pytest

from bt_manip.models import load_model
from bt_manip.models.images import read_png
from tests.support.images import png, unfolded_cube


def test_seams_of_an_image_are_no_holes(tmp_path):
    (tmp_path / "cube.obj").write_text(unfolded_cube())
    (tmp_path / "cube.mtl").write_text("map_Kd skin.png")
    (tmp_path / "skin.png").write_bytes(png())
    made = load_model(str(tmp_path / "cube.obj"))
    model = mujoco.MjModel.from_xml_string(made.xml, dict(made.assets))
    assert model.body_mass[1] == pytest.approx(1000 * 0.1**3, rel=1e-6)
    assert [i for i in model.mat_texid[model.geom_matid[0]] if i >= 0] == [0]


def test_no_png_is_none(tmp_path):
    assert read_png(tmp_path / "nowhere.png") is None
