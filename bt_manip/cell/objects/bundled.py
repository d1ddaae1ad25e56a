"""Objects whose models come with bt-manip: cube, table, basket."""

from collections.abc import Sequence

from bt_manip.models import bundled_path

from .prop import Prop, positive


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
        """Height of the centre above the surface that it rests on [m]."""
        return self.size / 2


class Table(Prop):
    """A table to work on; its origin is the floor under the middle of its top."""

    kind = "table"
    category = "surface"

    def _build(
        self,
        name: str = "table",
        friction: float | None = None,
        colour: Sequence[float] | None = None,
    ) -> None:
        """Load the table; ``None`` keeps what the model file says.

        Args:
            name: Model name.
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._load(bundled_path("table/table.xml"), name, friction=friction, colour=colour)

    @property
    def surface_height(self) -> float:
        """Height of the surface above the origin [m]."""
        top = self._mjcf_root.find("geom", "top")
        return float(top.pos[2] + top.size[2])


class Basket(Prop):
    """An open basket to drop things into; its origin is the middle of its bottom."""

    kind = "basket"
    category = "container"

    def _build(
        self,
        name: str = "basket",
        mass: float | None = None,
        friction: float | None = None,
        colour: Sequence[float] | None = None,
    ) -> None:
        """Load the basket; ``None`` keeps what the model file says.

        Args:
            name: Model name.
            mass: Mass, which counts where the basket is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._load(
            bundled_path("basket/basket.xml"), name, mass=mass, friction=friction, colour=colour
        )
