"""Put a new object into the cell."""

import contextlib
from typing import Any

import numpy as np
from dm_control import composer

from bt_manip.bt import Input, Output, Status
from bt_manip.cell import CellError, Region, as_object, nearest_free, unique_name
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import PortError
from bt_manip.models import is_address

from .arm_behaviour import CellBehaviour
from .poses import centre_pose

ATTEMPTS = 100  # random positions to find one that keeps the gap


class SpawnObject(CellBehaviour):
    """Put a new object at a random free position on another one, with a random yaw."""

    model = Input(
        str,
        default="cube",
        doc="Registered name of the object (bt-manip list objects), or the address of a model.",
    )
    on = Input(str, default="table", doc="Name of the object to put it on.")
    region = Input(
        list[float],
        default=[0.2, 0.4, -0.3, 0.3],
        doc="Region for its centre in the world: x_min;x_max;y_min;y_max [m].",
    )
    gap = Input(float, default=0.0, doc="Least distance to other free objects [m].")
    name_hint = Input(
        str, default="", doc="Name for it, made unique; by default that of the model."
    )
    object = Output(str, doc="Its unique name.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell, its random generator and the registered objects.

        Raises:
            UnknownPartError: When the model is given already and is not registered.
            ModelError: When its address leads to no model.
        """
        super().setup(**infrastructure)
        self.rng: np.random.Generator = infrastructure["rng"]
        self.models: Catalogue = infrastructure["models"]
        with contextlib.suppress(PortError):  # the entry is written later
            self.models.get(self.model)

    def start(self) -> None:
        """Create the object and insert it."""
        x_min, x_max, y_min, y_max = self._bounds()
        surface = self.cell.surface_height(self.on)
        entity = self.models.get(self.model)()
        declared = as_object(entity)
        z = surface + declared.rest_height
        middle_x, middle_y, _ = declared.centre_offset
        region = Region((x_min, x_max), (y_min, y_max), (z, z), middle=(middle_x, middle_y))
        hint = self.name_hint or ("" if is_address(self.model) else self.model)
        self.object = name = self._place(entity, region, hint or None)
        x, y, _ = centre_pose(self.cell, name).translation
        self.feedback_message = f"'{name}' at ({x:.3f}, {y:.3f}) m"

    def _place(self, entity: composer.Entity, region: Region, hint: str | None) -> str:
        """Insert it at a random position of the region that keeps the gap.

        Raises:
            CellError: When `ATTEMPTS` positions do not keep it.
        """
        gap = self.gap
        for _ in range(ATTEMPTS):
            name = hint and unique_name(hint, self.cell.entities)
            name = self.cell.place(entity, region, self.rng, name=name)
            if gap <= 0.0 or nearest_free(self.cell, name, gap) >= gap:
                return name
            self.cell.remove(name)
        raise CellError(
            f"no position with a gap of {1e3 * gap:g} mm to other objects in {ATTEMPTS} attempts"
        )

    def _bounds(self) -> tuple[float, float, float, float]:
        region = self.region
        if len(region) != 4 or region[0] > region[1] or region[2] > region[3]:
            raise CellError(f"a region is x_min;x_max;y_min;y_max [m], got {region}")
        x_min, x_max, y_min, y_max = region
        return x_min, x_max, y_min, y_max

    def update(self) -> Status:
        """Succeed: the object is in the cell."""
        return Status.SUCCESS
