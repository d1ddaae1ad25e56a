"""A plugin with a mug that is gripped by its handle."""

import numpy as np
import pinocchio as pin

from bt_manip import hookimpl
from bt_manip.cell.objects import DeclaredGrasp, Mug


class HandledMug(Mug):
    """A mug that is picked from above by the upper bar of its handle."""

    kind = "handled_mug"

    @property
    def grasps(self):
        """The grasp across the handle's upper bar."""
        R = np.diag([-1.0, 1.0, -1.0])  # straight down, closing along y
        radius, height = (float(self.parameters[key]) for key in ("radius", "height"))
        return [DeclaredGrasp(pin.SE3(R, np.array([radius + 0.014, 0.0, 0.75 * height])), 0.009)]


@hookimpl
def register_objects(register):
    register("handled_mug", HandledMug)
