"""What a learner or a recorder can observe of a gripper, by composer's means."""

import numpy as np
from dm_control import composer
from dm_control.composer.observation import observable


class GripperObservables(composer.Observables):
    """How far it is open, and how hard it presses."""

    @composer.observable
    def width(self) -> observable.Observable:
        """Distance between the fingers [m]."""
        return observable.Generic(lambda physics: np.array([self._entity.width]))

    @composer.observable
    def finger_forces(self) -> observable.Observable:
        """Normal force on each finger in the last step [N]."""
        return observable.Generic(lambda physics: np.array(self._entity.finger_forces))
