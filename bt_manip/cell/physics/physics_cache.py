"""Physics that have been compiled before, for when the same things stand in the arena again."""

from collections.abc import Hashable

import mujoco
import numpy as np

from bt_manip.cell.physics.compiled_physics import CompiledPhysics


class PhysicsCache:
    """Keeps those physics that were in use last, and gives them out as if they were new.

    One whose model has been changed since it was compiled is not kept.

    Attributes:
        limit: How many are kept; none at first.
    """

    def __init__(self) -> None:
        """Begin with nothing kept."""
        self.limit = 0
        self._origins: dict[CompiledPhysics, tuple[Hashable, np.ndarray]] = {}
        self._retired: list[CompiledPhysics] = []

    def take(self, key: Hashable) -> CompiledPhysics | None:
        """Give out what was compiled from something, if that is kept."""
        for compiled in self._retired:
            if self._origins[compiled][0] == key:
                self._retired.remove(compiled)
                compiled.renew()
                return compiled
        return None

    def note(self, compiled: CompiledPhysics, key: Hashable) -> None:
        """Remember what a new physics was compiled from, before anybody changes it.

        Args:
            compiled: The physics.
            key: Equal only for what compiles to the same.
        """
        if self.limit:
            self._origins[compiled] = key, _content(compiled.model)

    def retire(self, compiled: CompiledPhysics) -> None:
        """Keep a physics that is no longer in use, or free it."""
        origin = self._origins.get(compiled)
        if origin is not None and np.array_equal(origin[1], _content(compiled.model)):
            self._retired.append(compiled)
        else:
            self._free(compiled)
        while len(self._retired) > self.limit:
            self._free(self._retired.pop(0))

    def forget(self, compiled: CompiledPhysics) -> None:
        """Let go of a physics that was never in use."""
        self._origins.pop(compiled, None)

    def _free(self, compiled: CompiledPhysics) -> None:
        self.forget(compiled)
        compiled.physics.free()


def _content(model: mujoco.MjModel) -> np.ndarray:
    """Give all that a model says."""  # (nbyte,)
    content = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content
