"""The names that geoms and bodies of a compiled model go by in a cell."""

import mujoco
import numpy as np

from bt_manip.cell.naming import body_label, entity_of


class Labels:
    """A table from geom and body ids to ``entity/body`` names, built once per compile."""

    def __init__(self, model: mujoco.MjModel):
        """Read the names of a compiled model."""
        name = mujoco.mj_id2name
        kind = mujoco.mjtObj.mjOBJ_BODY
        bodies = [body_label(name(model, kind, i) or "") for i in range(model.nbody)]
        inner: dict[str, int] = {}
        for label in bodies:
            if "/" in label:
                inner[entity_of(label)] = inner.get(entity_of(label), 0) + 1
        # An entity of a single body goes by its own name, whatever that body is called inside.
        self.of_body = [entity_of(b) if inner.get(entity_of(b)) == 1 else b for b in bodies]
        self.of_geom = [self.of_body[b] for b in model.geom_bodyid.tolist()]
        self._model = model
        self._masks: dict[str, np.ndarray] = {}

    def names(self) -> list[str]:
        """Name all bodies and entities."""
        return sorted({*self.of_body, *map(entity_of, self.of_body)})

    def body_ids(self, name: str) -> list[int]:
        """List the bodies that a body's or entity's name means, root first.

        Raises:
            KeyError: When nothing has that name.
        """
        ids = [i for i, b in enumerate(self.of_body) if name in (b, entity_of(b))]
        if not ids:
            raise KeyError(name)
        return ids

    def geoms(self, name: str) -> np.ndarray:
        """Mark the geoms that a body's or entity's name means.

        Raises:
            KeyError: When nothing has that name.
        """  # (ngeom,) bool
        mask = self._masks.get(name)
        if mask is None:
            mask = np.isin(self._model.geom_bodyid, self.body_ids(name))
            self._masks[name] = mask
        return mask
