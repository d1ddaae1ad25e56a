"""The table."""

from collections.abc import Sequence

from bt_manip.cell.objects.prop import Prop
from bt_manip.models import bundled_path


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
