"""Depth cameras, fixed in the cell or on a robot's hand."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import CellError, ParametricEntity, camera_number
from bt_manip.parameters import Parameter

from .detections import Detections
from .frame import Frame, difference, focal_length
from .noise import PARAMETERS, DepthErrors
from .renderer import KeptRenderer, check_opengl

MAX_PIXELS = 8192
"""Maximum width and height of images, a common limit of graphics cards."""

MOVED = 2e-3
"""Distance [m] and angle [rad] from which a camera has moved while a frame of `source` arrived."""

Images = tuple[np.ndarray, np.ndarray]
"""Depth [m] and colour, as of a `Frame`."""


def depth_cameras(entities: Mapping[str, Any]) -> dict[str, "DepthCamera"]:
    """Return the cameras among entities, by name."""
    return {name: one for name, one in entities.items() if isinstance(one, DepthCamera)}


class DepthCamera(ParametricEntity):
    """A camera with depth and colour images that have the errors of a real one.

    It looks along its -z axis, with x to the right and y up. On a robot (``mount``), its pose in
    the scene is that in the frame of the robot's tool. Images are rendered by `expose` only; they
    show the state after the last step. Its frames begin at multiples of ``1 / rate``, and arrive
    ``delay`` later: see `next_exposure`.

    Attributes:
        errors: The errors of its images.
        delay: Time from the exposure until a frame arrives [s].
        miscalibration: Its believed pose in its true frame.
        disturb: Changes depth and colour of each frame, with a random generator; None: nothing.
        detections: Detections in the last frame that was used; None: no frame was used.
        source: Returns a frame that begins when it is called, of a real camera; another thread
            calls it, and it must end within a time limit. It raises a `CellError` if there is no
            frame. None: frames are rendered.
    """

    detections: Detections | None = None
    source: Callable[[], Images] | None = None
    disturb: Callable[[np.ndarray, np.ndarray, np.random.Generator], Any] | None = None

    kind = "depth_camera"
    category = "sensor"

    defaults = {
        "fovy": Parameter("Vertical angle of view", "degrees", 50.0, above=0.0, below=180.0),
        "width": Parameter("Width of images", "pixels", 640, at_least=1, at_most=MAX_PIXELS),
        "height": Parameter("Height of images", "pixels", 480, at_least=1, at_most=MAX_PIXELS),
        "mount": Parameter("Name of the robot on whose tool it is; by default none", "", ""),
        "rate": Parameter("Frames per second", "Hz", 30.0, above=0.0, at_most=1e4),
        "delay": Parameter("Time from the exposure until a frame arrives", "s", 0.03, at_least=0.0),
        **PARAMETERS,
        "seed": Parameter("Seed of the directions of the calibration's error", "", 0, at_least=0),
    }  # fmt: skip

    def _make_model(self, name: str) -> None:
        given = self._parameters
        self.width, self.height, self.mount = given["width"], given["height"], given["mount"]
        self.rate, self.delay = given["rate"], given["delay"]
        self.errors = DepthErrors(**{one.name: given[one.name] for one in fields(DepthErrors)})
        self.miscalibration = self.errors.calibration_error(np.random.default_rng(given["seed"]))
        self._mjcf_root = mjcf.RootElement(model=name)
        body = self._mjcf_root.worldbody.add("body", name="camera")
        self.eye = body.add("camera", name="eye", fovy=given["fovy"])
        self._model: mujoco.MjModel | None = None
        self._renderer: KeptRenderer | None = None
        self._worker: ThreadPoolExecutor | None = None
        self._asked: tuple[Future[Images], pin.SE3, float] | None = None

    @property
    def focal_length(self) -> float:
        """Focal length of both axes [pixels]."""
        return focal_length(self.height, self._parameters["fovy"])

    def next_exposure(self, now: float) -> float:
        """Return the time at which the next frame begins, not before a time [s]."""
        return float(np.ceil(now * self.rate - 1e-6) / self.rate)

    def request(self, robots: Mapping[str, Any] | None = None) -> None:
        """Ask `source`, if there is one, for the frame that `expose` returns next."""
        if self.source is None:
            return
        if self._worker is None:
            self._worker = ThreadPoolExecutor(1)
        T_wc, _ = self._pose(robots)
        self._asked = self._worker.submit(self.source), T_wc, float(self._data.time)

    @property
    def waiting(self) -> bool:
        """Whether the requested frame has not arrived."""
        return self._asked is not None and not self._asked[0].done()

    def expose(self, rng: np.random.Generator, robots: Mapping[str, Any] | None = None) -> Frame:
        """Render a frame of the present state, with the errors of the camera.

        With a `source`, wait for its frame instead.

        Args:
            rng: From which the errors of this frame are drawn.
            robots: The robots of the station by name, as `Station.robots`: needed with ``mount``.

        Raises:
            CellError: If it is not in a cell, or its robot is not; if its source has no frame, or
                it has moved meanwhile.
            NoOpenGLError: If no OpenGL backend works.
        """
        if self.source is not None:
            return self._received(robots)
        colour, depth, T_wc = self.render(robots)
        depth = self.errors.corrupt(depth, rng)
        if self.disturb is not None:
            depth, colour = self.disturb(depth, colour, rng)
        return Frame(
            depth, colour, self.focal_length,
            T_wc * self.miscalibration, float(self._data.time),
        )  # fmt: skip

    def moved(self, robots: Mapping[str, Any] | None = None) -> bool:
        """Return whether it has moved since it asked `source` for a frame."""
        if self._asked is None:
            return False
        return max(difference(self._asked[1], self._pose(robots)[0])) > MOVED

    def _received(self, robots: Mapping[str, Any] | None) -> Frame:
        if self._asked is None:
            self.request(robots)
        assert self._asked is not None
        arriving, T_wc, time = self._asked
        moved, self._asked = self.moved(robots), None
        depth, colour = arriving.result()
        if moved:
            raise CellError(f"camera '{self._mjcf_root.model}' has moved while its frame was taken")
        return Frame(depth, colour, self.focal_length, T_wc * self.miscalibration, time)

    def render(
        self, robots: Mapping[str, Any] | None = None
    ) -> tuple[np.ndarray, np.ndarray, pin.SE3]:
        """Render colour and depth without errors; return them and the pose of the camera.

        The pose follows from the measured joint positions where it is mounted on a robot, the
        images from the true ones. Arguments and errors are those of `expose`.

        Returns:
            Red, green and blue from 0 to 255, the distance along the camera's axis [m], and the
            pose in the world.  # (height, width, 3) uint8, (height, width)
        """
        T_wc, site = self._pose(robots)
        assert self._model is not None
        if self._renderer is None:
            check_opengl()
            self._renderer = KeptRenderer(self.width, self.height)
        number = camera_number(self._model, self.eye.full_identifier)
        colour, depth = self._renderer.render(self._model, self._data, number, site)
        return colour, depth, T_wc

    def _pose(self, robots: Mapping[str, Any] | None) -> tuple[pin.SE3, int | None]:
        """Return its pose in the world, and the number of the site on which it is mounted."""
        model = self._model
        if model is None:
            raise CellError(f"camera '{self._mjcf_root.model}' is not in a cell yet")
        number = camera_number(model, self.eye.full_identifier)
        body = model.cam_bodyid[number]  # fixed in the world, which no state moves
        T_c = pin.SE3(self._data.xmat[body].reshape(3, 3).copy(), self._data.xpos[body].copy())
        if not self.mount:
            return T_c, None
        if self.mount not in (robots or {}):
            raise CellError(
                f"camera '{self._mjcf_root.model}' is mounted on '{self.mount}', which is no "
                "robot of this cell"
            )
        one = robots[self.mount]  # type: ignore[index]
        site = int(model.site(one.robot.tool_site.full_identifier).id)
        return one.arm.model.pose(one.robot.q) * T_c, site

    @property
    def contexts(self) -> dict[int, mujoco.MjrContext]:
        """The graphics contexts that it keeps; none before its first image."""
        return {} if self._renderer is None else self._renderer.contexts

    def close(self) -> None:
        """Release the renderer; the next image creates a new one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model (composer's hook)."""
        self._model, self._data = physics.model.ptr, physics.data.ptr
