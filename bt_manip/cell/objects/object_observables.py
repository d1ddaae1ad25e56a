"""Composer observables of an object."""

from typing import Any

import numpy as np
from dm_control import composer, mjcf
from dm_control.composer.observation import observable

from ..contacts.contacts import Contacts
from ..naming import BodyNames, body_name


class ObjectObservables(composer.Observables):
    """Pose, velocity and contact force of an object."""

    _physics: mjcf.Physics | None = None
    _contacts: Contacts

    @composer.observable
    def position(self) -> observable.Observable:
        """Position of the origin in the world [m]."""
        return observable.Generic(lambda physics: np.array(self._root(physics).xpos))

    @composer.observable
    def quat_wxyz(self) -> observable.Observable:
        """Orientation in the world."""
        return observable.Generic(lambda physics: np.array(self._root(physics).xquat))

    @composer.observable
    def velocity(self) -> observable.Observable:
        """Velocity of the origin: linear, then angular, in the world [m/s, rad/s]."""
        return observable.Generic(self._velocity)

    @composer.observable
    def contact_force(self) -> observable.Observable:
        """Sum of all external contact forces, in the world [N]."""
        return observable.Generic(self._force)

    def _root(self, physics: mjcf.Physics) -> Any:
        return physics.bind(self._entity.root_body)

    def _velocity(self, physics: mjcf.Physics) -> np.ndarray:
        data, body = physics.data.ptr, int(self._root(physics).element_id)
        centre = data.subtree_com[physics.model.ptr.body_rootid[body]]
        angular, linear = data.cvel[body, :3], data.cvel[body, 3:]
        arm = data.xpos[body] - centre
        return np.concatenate([linear + np.cross(angular, arm), angular])

    def _force(self, physics: mjcf.Physics) -> np.ndarray:
        if self._physics is not physics:
            model, data = physics.model.ptr, physics.data.ptr
            self._physics, self._contacts = physics, Contacts(model, data, BodyNames(model))
        name = body_name(self._entity.root_body.full_identifier)
        return self._contacts.wrench(name).force
