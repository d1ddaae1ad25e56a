"""Put a new object into the cell."""

import contextlib
from typing import Any

import numpy as np
from dm_control import composer

from bt_manip.bt import Input, Output, Status
from bt_manip.cell import CellError, Region, as_object, unique_name
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import PortError
from bt_manip.models import is_address

from .arm_behaviour import CellBehaviour
from .extent import nearest_free
from .poses import centre_pose

ATTEMPTS = 100  # to keep the gap


class SpawnObject(CellBehaviour):
    """Put a new object at a random free place on another one, turned by any angle."""

    model = Input(
        str,
        default="cube",
        doc="Object to make: a registered name (bt-manip list objects) or the address of a model.",
    )
    on = Input(str, default="table", doc="Name of the object whose surface it is put on.")
    region = Input(
        list[float],
        default=[0.2, 0.4, -0.3, 0.3],
        doc="Where its centre may come to lie, in the world: x_min;x_max;y_min;y_max [m].",
    )
    gap = Input(float, default=0.0, doc="Distance from what else lies freely in the cell [m].")
    name_hint = Input(str, default="", doc="Name to give it; by default that of the model.")
    object = Output(str, doc="Unique name that it got.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell, its randomness and the known objects.

        Raises:
            UnknownPartError: When it is known already what to make, and nobody knows how.
            ModelError: When its address leads to no model.
        """
        super().setup(**infrastructure)
        self.rng: np.random.Generator = infrastructure["rng"]
        self.models: Catalogue = infrastructure["models"]
        with contextlib.suppress(PortError):  # an entry that is only written later
            self.models.get(self.model)

    def start(self) -> None:
        """Make the object and insert it."""
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
        """Put it into the region, again and again until the gap is kept.

        Raises:
            CellError: When there is no such place.
        """
        gap = self.gap
        for _ in range(ATTEMPTS):
            name = hint and unique_name(hint, self.cell.entities)
            name = self.cell.place(entity, region, self.rng, name=name)
            if gap <= 0.0 or nearest_free(self.cell, name, gap) >= gap:
                return name
            self.cell.remove(name)
        raise CellError(f"no place {1e3 * gap:g} mm from everything in {ATTEMPTS} attempts")

    def _bounds(self) -> tuple[float, float, float, float]:
        region = self.region
        if len(region) != 4 or region[0] > region[1] or region[2] > region[3]:
            raise CellError(f"a region is x_min;x_max;y_min;y_max [m], got {region}")
        x_min, x_max, y_min, y_max = region
        return x_min, x_max, y_min, y_max

    def update(self) -> Status:
        """Succeed: the object is there."""
        return Status.SUCCESS
