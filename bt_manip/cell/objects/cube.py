"""The cube."""

from collections.abc import Sequence

from bt_manip.cell.objects.prop import Prop, positive
from bt_manip.models import bundled_path


class Cube(Prop):
    """A wooden cube to pick up; its origin is its centre."""

    kind = "cube"
    category = "graspable"
    free = True

    def _build(
        self,
        name: str = "cube",
        size: float | None = None,
        mass: float | None = None,
        friction: float | None = None,
        colour: Sequence[float] | None = None,
    ) -> None:
        """Load the cube; ``None`` keeps what the model file says.

        Args:
            name: Model name.
            size: Length of an edge [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._load(
            bundled_path("cube/cube.xml"),
            name, size=size, mass=mass, friction=friction, colour=colour,
        )  # fmt: skip
        if size is not None:
            for geom in (*self.collision_geoms, *self.visual_geoms):
                geom.size = [positive("size", size, "m") / 2] * 3

    @property
    def size(self) -> float:
        """Length of an edge [m]."""
        return 2 * float(self.collision_geoms[0].size[0])

    @property
    def rest_height(self) -> float:
        """Height of the centre above what it stands on [m]."""
        return self.size / 2
