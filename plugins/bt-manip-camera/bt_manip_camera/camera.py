"""Depth cameras, fixed in the cell or on a robot's hand."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell import CellError, ParametricEntity
from bt_manip.parameters import Parameter

from .detections import Detections
from .frame import Frame, focal_length
from .noise import PARAMETERS, DepthErrors
from .renderer import KeptRenderer, camera_id

MAX_PIXELS = 8192
"""Maximum width and height of images, a common limit of graphics cards."""


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
        detections: What was detected in the last frame that somebody used; None: there is none.
    """

    detections: Detections | None = None
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

    def _build_observables(self) -> composer.Observables:
        return composer.Observables(self)

    @property
    def mass(self) -> float:
        """Mass: none [kg]."""
        return 0.0

    @property
    def focal_length(self) -> float:
        """Focal length of both axes [pixels]."""
        return focal_length(self.height, self._parameters["fovy"])

    def next_exposure(self, now: float) -> float:
        """Return the time at which the next frame begins, not before a time [s]."""
        return float(np.ceil(now * self.rate - 1e-6) / self.rate)

    def expose(self, rng: np.random.Generator, robots: Mapping[str, Any] | None = None) -> Frame:
        """Render a frame of the present state, with the errors of the camera.

        Args:
            rng: From which the errors of this frame are drawn.
            robots: The robots of the station by name, as `Station.robots`: needed with ``mount``.

        Raises:
            CellError: If it is not in a cell, or its robot is not.
            NoOpenGLError: If no OpenGL backend works.
        """
        colour, depth, T_wc = self.render(robots)
        depth = self.errors.corrupt(depth, rng)
        if self.disturb is not None:
            depth, colour = self.disturb(depth, colour, rng)
        return Frame(
            depth, colour, self.focal_length,
            T_wc * self.miscalibration, float(self._data.time),
        )  # fmt: skip

    def render(
        self, robots: Mapping[str, Any] | None = None
    ) -> tuple[np.ndarray, np.ndarray, pin.SE3]:
        """Render colour and depth without errors; return them and the pose of the camera.

        The pose follows from the measured joint positions where it is mounted on a robot, the
        images from the true ones.

        Args:
            robots: As for `expose`.

        Returns:
            Red, green and blue from 0 to 255, the distance along the camera's axis [m], and the
            pose in the world.  # (height, width, 3) uint8, (height, width)

        Raises:
            CellError: If it is not in a cell, or its robot is not.
            NoOpenGLError: If no OpenGL backend works.
        """
        model = self._model
        if model is None:
            raise CellError(f"camera '{self._mjcf_root.model}' is not in a cell yet")
        number = camera_id(model, self.eye.full_identifier)
        body = model.cam_bodyid[number]  # fixed in the world, which no state moves
        T_c = pin.SE3(self._data.xmat[body].reshape(3, 3).copy(), self._data.xpos[body].copy())
        site, T_wc = None, T_c
        if self.mount:
            if self.mount not in (robots or {}):
                raise CellError(
                    f"camera '{self._mjcf_root.model}' is mounted on '{self.mount}', which is no "
                    "robot of this cell"
                )
            one = robots[self.mount]  # type: ignore[index]
            site = int(model.site(one.robot.tool_site.full_identifier).id)
            T_wc = one.arm.model.pose(one.robot.q) * T_c
        if self._renderer is None:
            self._renderer = KeptRenderer(self.width, self.height)
        colour, depth = self._renderer.render(model, self._data, number, site)
        return colour, depth, T_wc

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
