"""A picture shows what stands in the cell, where the camera's geometry says."""

from unittest.mock import Mock

import mujoco
import numpy as np
import pytest
from dm_control import composer

from bt_manip import spatial
from bt_manip.cell import Cell, Cube, FrameRenderer, Table
from bt_manip.exceptions import BtManipError
from bt_manip.viewer import NoOpenGLError, render

WIDTH, HEIGHT = 160, 100
BLUE = (0.05, 0.15, 0.9)


def cell_with_cube(x: float, y: float) -> Cell:
    cell = Cell()
    cell.add(Table())
    cell.add(Cube(size=0.1, colour=BLUE), spatial.pose((x, y, 1.3)), name="cube")
    return cell


def project(cell: Cell, camera: str, point: np.ndarray) -> tuple[int, int]:
    """Give row and column of a point, for an ideal pinhole camera."""
    camera_id = cell.model.camera(camera).id
    axes = cell.data.cam_xmat[camera_id].reshape(3, 3)  # it looks along -z, y is up
    x, y, z = axes.T @ (point - cell.data.cam_xpos[camera_id])
    focal = 0.5 * HEIGHT / np.tan(0.5 * np.deg2rad(cell.model.cam_fovy[camera_id]))
    return round(0.5 * HEIGHT + focal * y / z - 0.5), round(0.5 * WIDTH - focal * x / z - 0.5)


def test_the_cube_is_seen_where_the_camera_projects_it_after_the_last_step(opengl):
    cell = cell_with_cube(0.3, 0.2)
    free = cell.model.joint("cube/").qposadr[0]
    for x, y in ((0.3, 0.2), (0.5, -0.2)):
        cell.data.qpos[free : free + 2] = x, y
        picture = render(cell, width=WIDTH, height=HEIGHT)
        assert picture.shape == (HEIGHT, WIDTH, 3)
        rows, columns = np.nonzero(picture[..., 2].astype(int) - picture[..., 0] > 60)  # blue
        row, column = project(cell, "overview", np.array([x, y, 1.3]))
        assert (rows.mean(), columns.mean()) == pytest.approx((row, column), abs=1.0)
        # 0.1 m wide, some 2.3 m away, seen over an edge
        assert 20 < rows.size < 120


def test_drawing_changes_nothing(opengl):
    cell, undrawn = cell_with_cube(0.3, 0.2), cell_with_cube(0.3, 0.2)
    cell.step(5)
    render(cell, width=16, height=10)
    cell.step(5)
    undrawn.step(10)
    assert cell.state_bytes() == undrawn.state_bytes()


def test_an_unknown_camera_and_an_impossible_size_are_refused():
    with pytest.raises(BtManipError, match="no camera 'overveiw'.*'overview'"):
        render(Cell(), "overveiw")
    for width, height in ((0, 10), (10, 5000)):
        with pytest.raises(BtManipError, match="up to 1920 x 1200 pixels"):
            render(Cell(), width=width, height=height)


@pytest.fixture
def no_context(monkeypatch) -> Mock:
    """Let no renderer be made; return what is called instead."""
    made = Mock(side_effect=mujoco.FatalError("no context"))
    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setattr(FrameRenderer, "failure", "")
    monkeypatch.setattr(mujoco.Renderer, "__init__", made)
    return made


def test_without_opengl_it_says_what_would_help_and_is_not_tried_again(no_context):
    for _ in range(2):
        with pytest.raises(NoOpenGLError, match=r"\(no context\).*MUJOCO_GL=egl"):
            render(Cell())
    assert no_context.call_count == 1  # a second try of GLFW aborts the process


def test_with_opengl_disabled_it_says_so(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(NoOpenGLError, match="with MUJOCO_GL disable; without a display"):
        render(Cell())


def test_a_notebook_shows_the_picture_of_a_cell(opengl):
    shown = Cell()._repr_png_()
    assert shown is not None and shown.startswith(b"\x89PNG")


def test_a_notebook_shows_a_cell_as_text_without_opengl_or_an_overview(no_context):
    assert Cell(composer.Arena())._repr_png_() is None
    assert Cell()._repr_png_() is None
