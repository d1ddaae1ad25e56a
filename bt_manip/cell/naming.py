"""Names of entities, and of the bodies and geoms of a compiled model."""

from collections.abc import Container

import mujoco
import numpy as np
from dm_control import mjcf

WORLD = "world"


def escaped_name(name: str) -> str:
    """Return the name that PyMJCF gives to an element of a model file.

    PyMJCF reserves ``/`` for the names of attached models. Models are read with
    ``escape_separators=True``, which replaces it by a backslash. Everywhere else bt-manip shows and
    accepts the name in the file.
    """
    return name.replace("\\", "\\\\").replace("/", "\\")


def literal_name(name: str) -> str:
    """Return the name in the model file for a name in PyMJCF or a compiled model."""
    return name.replace("\\\\", "\0").replace("\\", "/").replace("\0", "\\")


def short_name(full_name: str) -> str:
    """Return the name in its own model file for the full name in a compiled model."""
    return literal_name(full_name.rpartition("/")[2])


def unique_name(wanted: str, taken: Container[str | None]) -> str:
    """Return ``wanted``, or the first free name of ``wanted_1``, ``wanted_2``, ..."""
    if wanted not in taken:
        return wanted
    number = 1
    while f"{wanted}_{number}" in taken:
        number += 1
    return f"{wanted}_{number}"


def name_elements(model: mjcf.RootElement) -> None:
    """Name all unnamed bodies, geoms, joints, sites and contact pairs.

    PyMJCF would number them at each compile, with a search through the whole model for each. This
    takes a third of the compile for a robot with a hundred unnamed geoms.
    """
    for namespace in ("body", "geom", "joint", "site", "contact"):
        elements = model.find_all(namespace, exclude_attachments=True)
        taken = {getattr(e, "name", None) for e in elements}
        for number, element in enumerate(elements):
            if getattr(element, "name", "") is None:
                element.name = unique_name(f"{namespace}{number}", taken)


def body_name(full_name: str) -> str:
    """Shorten the name of a compiled body.

    PyMJCF's name of the root body of entity ``cube``, ``cube/``, becomes ``cube``, and so does the
    repeated name ``cube/cube``. Other bodies keep their names, as in the model file:
    ``panda/link7``.
    """
    entity, slash, body = full_name.partition("/")
    if not slash or not body or body == entity:
        return entity or WORLD
    return f"{entity}/{literal_name(body.rstrip('/'))}"


def entity_of(body: str) -> str:
    """Return the entity of a body name: ``panda`` of ``panda/link7``."""
    return body.partition("/")[0]


class BodyNames:
    """Names ``entity/body`` of the bodies and geoms of a compiled model, by id."""

    def __init__(self, model: mujoco.MjModel):
        name = mujoco.mj_id2name
        kind = mujoco.mjtObj.mjOBJ_BODY
        bodies = [body_name(name(model, kind, i) or "") for i in range(model.nbody)]
        inner: dict[str, int] = {}
        for body in bodies:
            if "/" in body:
                inner[entity_of(body)] = inner.get(entity_of(body), 0) + 1
        # The body of a single-body entity has the entity's name.
        self.of_body = [entity_of(b) if inner.get(entity_of(b)) == 1 else b for b in bodies]
        self.of_geom = [self.of_body[b] for b in model.geom_bodyid.tolist()]
        self._model = model
        self._masks: dict[str, np.ndarray] = {}
        self._ids: dict[str, list[int]] = {}
        for i, body in enumerate(self.of_body):
            for label in {body, entity_of(body)}:
                self._ids.setdefault(label, []).append(i)

    def names(self) -> list[str]:
        """Return the names of all bodies and entities."""
        return sorted(self._ids)

    def body_ids(self, name: str) -> list[int]:
        """Return the ids of the bodies of a body's or entity's name, root first.

        Raises:
            KeyError: If there is none of that name.
        """
        return self._ids[name]

    def geoms(self, name: str) -> np.ndarray:
        """Mask the geoms of a body's or entity's name.

        Raises:
            KeyError: If there is none of that name.
        """  # (ngeom,) bool
        mask = self._masks.get(name)
        if mask is None:
            mask = np.isin(self._model.geom_bodyid, self.body_ids(name))
            self._masks[name] = mask
        return mask
