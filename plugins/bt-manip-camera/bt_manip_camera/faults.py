"""Faults of cameras, for ``bt-manip stress`` and ``bt-manip run --fault``."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bt_manip.cell import CellError, as_object
from bt_manip_stress import Fault, FaultError, parameter

from .camera import DepthCamera, depth_cameras
from .noise import DepthErrors

NEAR = 0.12
"""Depth of what covers a camera [m]."""


@dataclass
class _CameraFault(Fault):
    """A fault of a camera."""

    camera: str = parameter("", "Name of the camera; by default all.")

    def cameras(self) -> list[DepthCamera]:
        """Return the cameras.

        Raises:
            FaultError: If there is none.
        """
        cameras = depth_cameras(self.context.cell.entities).items()
        found = [one for name, one in cameras if self.camera in ("", name)]
        if not found:
            raise FaultError(f"there is no camera '{self.camera}'" if self.camera else "no camera")
        return found

    def set(self, name: str, value: Callable[[DepthCamera], Any]) -> None:
        """Set an attribute of the cameras until the end."""
        for one in self.cameras():
            self.at_end(setattr, one, name, getattr(one, name))
            setattr(one, name, value(one))


@dataclass
class CameraMoved(_CameraFault):
    """The camera was knocked: its calibration is wrong."""

    distance: float = parameter(5e-3, "Distance from where it is believed to be [m].")
    angle: float = parameter(1.0, "Angle from how it is believed to look [degrees].")

    def begin(self) -> None:
        """Change what is believed of it, in a random direction."""
        errors = DepthErrors(calibration_distance=self.distance, calibration_angle=self.angle)
        moved = errors.calibration_error(self.context.rng)
        self.set("miscalibration", lambda one: one.miscalibration * moved)


@dataclass
class CameraDelay(_CameraFault):
    """Frames arrive late."""

    delay: float = parameter(0.3, "Time from the exposure until a frame arrives [s].")

    def begin(self) -> None:
        """Delay them."""
        self.set("delay", lambda one: self.delay)


@dataclass
class CameraDropout(_CameraFault):
    """Many pixels have no depth, as of dark or shiny things."""

    share: float = parameter(0.5, "Share of the pixels.", at_most=1.0)

    def begin(self) -> None:
        """Lose them."""

        def lose(depth: np.ndarray, colour: np.ndarray, rng: np.random.Generator) -> Any:
            return np.where(rng.random(depth.shape) < self.share, 0.0, depth), colour

        self.set("disturb", lambda one: lose)


@dataclass
class CameraCovered(_CameraFault):
    """Something close to the camera, such as a cable of the arm, covers a part of its images."""

    share: float = parameter(0.5, "Share of the images, from one side.", at_most=1.0)

    def begin(self) -> None:
        """Cover it from a random side."""
        side = int(self.context.rng.integers(4))

        def cover(depth: np.ndarray, colour: np.ndarray, rng: np.random.Generator) -> Any:
            hidden = np.zeros(depth.shape, bool)
            turned = np.rot90(hidden, side)
            turned[: round(self.share * len(turned))] = True
            return np.where(hidden, NEAR, depth), np.where(hidden[..., None], 90, colour)

        self.set("disturb", lambda one: cover)


@dataclass
class LightsOut(_CameraFault):
    """It is dark: images are black, and have no depth, as of a stereo camera."""

    def begin(self) -> None:
        """Switch the lights off."""
        self.set("disturb", lambda one: lambda depth, colour, rng: (0.0 * depth, 0 * colour))


@dataclass
class LookAlike(_CameraFault):
    """There is a second object that looks like the one that the tree handles."""

    object: str = parameter("", "Name of the object; by default the one that the tree handles.")

    def begin(self) -> None:
        """Put it on the table, at a random free place."""
        self.cameras()
        cell, station = self.context.cell, self.context.station
        name = self.context.find_object(self.object)
        known = as_object(cell.find(name))
        if not known.kind:
            raise FaultError(f"'{name}' cannot be made a second time")
        entity = station.models.restored(known.kind, known.parameters)
        x, y, above = known.centre_offset
        height = known.rest_height + float(above)
        for support, one in cell.objects.items():
            if as_object(one).category != "surface":
                continue
            try:
                z = cell.surface_height(support) + known.rest_height
                area = station.first.reach.area(cell, support, height)
                region = replace(area, z=(z, z), middle=(float(x), float(y)))
                twin = cell.place(entity, region, self.context.rng, name=f"{name}_alike")
            except CellError:
                continue
            self.at_end(self._remove, twin)
            return
        raise FaultError(f"there is no free place for an object like '{name}'")

    def _remove(self, name: str) -> None:
        cell = self.context.cell
        if name in cell.entities:
            cell.remove(name)
