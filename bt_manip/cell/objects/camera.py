"""Cameras: colour, depth and segmentation images."""

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf
from dm_control.composer.observation import observable

from bt_manip.parameters import Parameter

from ..exceptions import CellError
from ..naming import BodyNames, entity_of
from ..rendering import FrameRenderer
from .prop import ParametricEntity

BACKGROUND = -1


class Segmentation(NamedTuple):
    """The entity shown by each pixel."""

    indices: np.ndarray  # (height, width) int, index into names; -1: background
    names: tuple[str, ...]

    def mask(self, name: str) -> np.ndarray:
        """Return the mask of the pixels of an entity."""  # (height, width) bool
        wanted = self.names.index(name) if name in self.names else BACKGROUND - 1
        return self.indices == wanted


MAX_PIXELS = 8192
"""Maximum width and height of images, a common limit of graphics cards."""


class Camera(ParametricEntity):
    """A camera in a cell, or attached to a site of a robot.

    Like MuJoCo's cameras it looks along its -z axis, with x to the right and y up; see
    ``looking_at``. Images show the state after the last step. They have no shadows, reflections and
    antialiasing, which would take most of the time.
    """

    kind = "camera"
    category = "sensor"

    defaults = {
        "fovy": Parameter("Vertical angle of view", "degrees", 45.0, above=0.0, below=180.0),
        "width": Parameter("Width of images", "pixels", 320, at_least=1, at_most=MAX_PIXELS),
        "height": Parameter("Height of images", "pixels", 240, at_least=1, at_most=MAX_PIXELS),
    }

    def _make_model(self, name: str) -> None:
        fovy, width, height = self._parameters.values()
        self.width, self.height = width, height
        self._mjcf_root = mjcf.RootElement(model=name)
        body = self._mjcf_root.worldbody.add("body", name="camera")
        self.eye = body.add("camera", name="eye", fovy=fovy)
        # The visible case is behind the camera, outside its view.
        body.add(
            "geom", name="case", type="box", size=(0.02, 0.015, 0.02), pos=(0, 0, 0.022),
            rgba=(0.15, 0.15, 0.17, 1), mass=0.1, group=2, contype=0, conaffinity=0,
        )  # fmt: skip
        self._renderer: FrameRenderer | None = None
        self._model: mujoco.MjModel | None = None

    def _build_observables(self) -> "CameraObservables":
        return CameraObservables(self)

    @property
    def mass(self) -> float:
        """Mass of the case [kg]."""
        return 0.1

    # Images

    def rgb(self) -> np.ndarray:
        """Render an image: red, green and blue from 0 to 255, the top row first."""
        return self._draw().render()  # (height, width, 3) uint8

    def depth(self) -> np.ndarray:
        """Render the depth along the camera's axis [m]."""  # (height, width) float32
        return self._draw().depth()

    def segmentation(self) -> Segmentation:
        """Render a segmentation image."""
        seen = self._draw().elements()
        assert self._model is not None
        owners = [entity_of(label) for label in BodyNames(self._model).of_geom]
        names = tuple(dict.fromkeys(owners))
        table = np.array([names.index(owner) for owner in owners] + [BACKGROUND])
        geoms = np.where(seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM), seen[..., 0], BACKGROUND)
        return Segmentation(table[geoms], names)

    def close(self) -> None:
        """Release the renderer; the next image creates a new one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model (composer's hook)."""
        self.close()
        self._model, self._data = physics.model.ptr, physics.data.ptr
        self._id = int(self._model.camera(self.eye.full_identifier).id)

    # Internal

    def _draw(self) -> FrameRenderer:
        if self._model is None:
            raise CellError(f"camera '{self._mjcf_root.model}' is not in a cell yet")
        if self._renderer is None:
            self._renderer = FrameRenderer(
                self._model, self.width, self.height, shadow_size=0, samples=0
            )
        self._renderer.show(self._data, self._id)
        return self._renderer


class CameraObservables(composer.Observables):
    """The images of a camera, rendered by dm_control."""

    @composer.observable
    def rgb(self) -> observable.Observable:
        """Red, green and blue from 0 to 255."""
        return self._camera()

    @composer.observable
    def depth(self) -> observable.Observable:
        """Distance along the camera's axis [m]."""
        return self._camera(depth=True)

    @composer.observable
    def segmentation(self) -> observable.Observable:
        """Id and type of the object shown by each pixel, -1 without one."""
        return self._camera(segmentation=True)

    def _camera(self, **options: bool) -> observable.Observable:
        camera = self._entity
        return observable.MJCFCamera(
            camera.eye, height=camera.height, width=camera.width, **options
        )


def looking_at(
    position: np.ndarray | tuple[float, ...], target: np.ndarray | tuple[float, ...]
) -> pin.SE3:
    """Return the pose of a camera that looks at a point, upright if possible.

    Args:
        position: Position of the camera [m].  # (3,)
        target: Point to look at [m].  # (3,)

    Raises:
        CellError: If both are the same point.
    """
    eye = np.asarray(position, dtype=float)
    back = eye - np.asarray(target, dtype=float)
    distance = float(np.linalg.norm(back))
    if not distance > 0.0:
        raise CellError("a camera cannot look at its own position")
    back /= distance
    up = np.array([0.0, 0.0, 1.0]) if abs(back[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return pin.SE3(np.column_stack([right, np.cross(back, right), back]), eye)
