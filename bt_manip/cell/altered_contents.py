"""How what stands in a cell differs from its models."""

from typing import Any

import mujoco

from bt_manip.cell.assembly import InitialOverrides
from bt_manip.cell.contents import Contents
from bt_manip.cell.physics.model_properties import ENTITY
from bt_manip.cell.physics.overrides import kind_of, nominal_value


class AlteredContents(Contents):
    """Things that come, go, and have values of their own instead of those of their models."""

    @property
    def initial_overrides(self) -> InitialOverrides | None:
        """Asked of each entity that comes in how it differs from its model; nobody at first."""
        return self._assembly.initial_overrides

    @initial_overrides.setter
    def initial_overrides(self, initial_overrides: InitialOverrides | None) -> None:
        self._assembly.initial_overrides = initial_overrides

    def override(self, thing: str, **values: Any) -> None:
        """Let the physics of something differ from its model, until it is removed.

        Nothing is compiled; what is altered stays so when the cell is compiled anew, and is part
        of a snapshot. ``nominal_model`` is without it.

        Args:
            thing: An entity's name, ``light:NAME``, or ``camera:NAME``.
            values: Values by quantity; None makes one what the model says again. An entity has
                ``mass`` [kg], ``friction``, ``colour`` and the ``gain`` of its actuators, a factor
                each; a light has ``position`` [m], ``direction``, ``colour`` and ``brightness``,
                a factor; a camera has ``position`` [m], ``rotation`` [rad] about its own axes, and
                ``fovy`` [degrees].

        Raises:
            CellError: When there is no such thing or quantity, or a value is impossible; nothing
                is altered then.
        """
        self._known(thing)
        self._assembly.overrides.put(thing, values, self._compiled.nominal)
        self._compiled.apply_overrides(self._assembly.overrides)

    def nominal(self, thing: str, quantity: str) -> Any:
        """Give what a thing's model says of a quantity that can be altered.

        Raises:
            CellError: When there is no such thing or quantity.
        """
        self._known(thing)
        return nominal_value(self._compiled.nominal, thing, quantity)

    @property
    def nominal_model(self) -> mujoco.MjModel:
        """MuJoCo's model without what has been altered: what can be known of the things.

        The same object as ``model`` where nothing is altered; otherwise alike but for the values.
        """
        return self._compiled.nominal

    @property
    def overrides(self) -> dict[str, dict[str, Any]]:
        """All that differs from the models, by thing and quantity, as plain data."""
        return self._assembly.overrides.get_state()

    def _known(self, thing: str) -> None:
        """Offer the nearest names where an entity is meant that is not there."""
        kind, name = kind_of(thing)
        if kind == ENTITY:
            self.find(name)
