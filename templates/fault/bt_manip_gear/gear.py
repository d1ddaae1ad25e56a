"""The fault."""

from dataclasses import dataclass

from bt_manip_stress import Fault, parameter


@dataclass
class Gear(Fault):
    """A wind blows on the object."""

    force: float = parameter(0.2, "Force along the world's x axis [N].")

    def begin(self):
        """Select the object; the wind ends with the fault."""
        self.name = self.context.find_object()
        self.at_end(self.blow, 0.0)

    def bind(self):
        """Apply the force, also after each compilation of the cell."""
        self.blow(self.force)

    def blow(self, force):
        """Set the external force on the object."""
        cell = self.context.cell
        if self.name in cell.entities:
            cell.data.xfrc_applied[cell.body_id(self.name), 0] = force
