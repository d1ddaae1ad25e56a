"""Names of entities in a cell, and of what the compiled model makes of them."""

from collections.abc import Container

WORLD = "world"


def unique_name(wanted: str, taken: Container[str]) -> str:
    """Give ``wanted``, or the first of ``wanted_1``, ``wanted_2``, ... that is not taken."""
    if wanted not in taken:
        return wanted
    number = 1
    while f"{wanted}_{number}" in taken:
        number += 1
    return f"{wanted}_{number}"


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
