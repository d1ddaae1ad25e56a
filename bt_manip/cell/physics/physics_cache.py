"""Cache of compiled physics."""

from collections.abc import Hashable, Iterator
from typing import NamedTuple

import mujoco
import numpy as np
from dm_control import composer

from .compiled_physics import CompiledPhysics
from .overrides import Overrides

MAX_KEPT = 8
"""Default number of cached physics, for tasks that add objects one by one."""


class CacheKey(NamedTuple):
    """Key of a compiled arena: equal keys give equal models."""

    arena_edits: int
    attachments: tuple[tuple[str, composer.Entity, bool], ...]
    """Names in order, with entities and whether they move freely; poses of these are state."""
    entities: tuple[composer.Entity, ...]
    """All entities, including entities attached to others."""
    models: Hashable
    """The attached models with their edits."""


class PhysicsCache:
    """Caches the physics used last; a cached physics is like a newly compiled one.

    Edits of the MJCF are part of the key. Values written into a compiled ``MjModel`` are not
    tracked, so a physics is cached only if its model is still equal to the compiled model.

    Attributes:
        limit: Maximum number of cached physics.
    """

    def __init__(self) -> None:
        self.limit = MAX_KEPT
        self._origins: dict[CompiledPhysics, tuple[CacheKey, np.ndarray]] = {}
        self._retired: list[CompiledPhysics] = []

    def take(self, key: CacheKey) -> CompiledPhysics | None:
        """Remove and return the physics of a key, reset, or None."""
        for physics in self._retired:
            if self._origins[physics][0] == key:
                self._retired.remove(physics)
                physics.reset()
                return physics
        return None

    def entities(self) -> Iterator[tuple[str, composer.Entity]]:
        """Yield the entities of cached physics, with their names."""
        for physics in self._retired:
            for name, entity, _ in self._origins[physics][0].attachments:
                yield name, entity

    def register(self, physics: CompiledPhysics, key: CacheKey) -> None:
        """Store the key of a new physics, before its model is changed."""
        if self.limit:
            self._origins[physics] = key, _content(physics.model)

    def retire(self, physics: CompiledPhysics) -> None:
        """Cache an unused physics, without its overrides, or free it."""
        physics.apply_overrides(Overrides())
        origin = self._origins.get(physics)
        if origin is not None and np.array_equal(origin[1], _content(physics.model)):
            self._retired.append(physics)
        else:
            self._free(physics)
        while len(self._retired) > self.limit:
            self._free(self._retired.pop(0))

    def _free(self, physics: CompiledPhysics) -> None:
        self._origins.pop(physics, None)
        physics.physics.free()


def _content(model: mujoco.MjModel) -> np.ndarray:
    """Return a model as bytes."""  # (nbyte,)
    content = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content
