"""The basket."""

from collections.abc import Sequence

from bt_manip.cell.objects.prop import Prop
from bt_manip.models import bundled_path


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
