"""Names of entities in a cell, and of what the compiled model makes of them."""

from collections.abc import Container

from dm_control import mjcf

WORLD = "world"


def unique_name(wanted: str, taken: Container[str | None]) -> str:
    """Give ``wanted``, or the first of ``wanted_1``, ``wanted_2``, ... that is not taken."""
    if wanted not in taken:
        return wanted
    number = 1
    while f"{wanted}_{number}" in taken:
        number += 1
    return f"{wanted}_{number}"


def name_elements(model: mjcf.RootElement) -> None:
    """Name the geoms, joints and sites that have no name.

    PyMJCF would number them at each compile, each by a search through the whole model: for a robot
    with a hundred nameless geoms that is a third of the compile.
    """
    for namespace in ("body", "geom", "joint", "site"):
        elements = model.find_all(namespace, exclude_attachments=True)
        taken = {getattr(e, "name", None) for e in elements}
        for number, element in enumerate(elements):
            if getattr(element, "name", "") is None:
                element.name = unique_name(f"{namespace}{number}", taken)


def body_label(full_name: str) -> str:
    """Shorten a compiled body's name to the way people write it.

    PyMJCF calls the root body of the entity ``cube`` ``cube/``; here it is ``cube``. A body inside
    keeps its name: ``panda/left_finger``. A body that only repeats its entity's name
    (``cube/cube``) is the entity.
    """
    entity, slash, body = full_name.partition("/")
    if not slash or not body or body == entity:
        return entity or WORLD
    return f"{entity}/{body.rstrip('/')}"


def entity_of(label: str) -> str:
    """Give the entity's part of a body label: ``panda`` of ``panda/left_finger``."""
    return label.partition("/")[0]
