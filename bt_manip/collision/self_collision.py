"""Collisions of a robot with itself and its pedestal."""

from typing import NamedTuple

import numpy as np

from bt_manip.cell import literal_name
from bt_manip.robots import RobotError

from .collision_world import CollisionWorld

CONFIGURATION_SAMPLES = 500  # configurations in all of which permanent contacts have to occur
_LISTED = 4  # maximum number of pairs in a message


class SelfCollision(NamedTuple):
    """Two bodies of a robot in contact, with their names in `RobotDescription.exclude`."""

    first: str
    second: str
    depth: float  # [m] of penetration


def self_collisions(world: CollisionWorld, q: np.ndarray) -> list[SelfCollision]:
    """Return the pairs of a robot's own bodies in collision at a configuration, deepest first.

    Args:
        world: The collision world of the robot, which may be compiled alone.
        q: Configuration of the arm [rad].  # (nq,)
    """
    found: dict[tuple[str, str], float] = {}
    names, of_geom = _body_names(world), world.robot.mj_model.geom_bodyid
    world.collide(q)
    for a, b, distance in zip(*(values.tolist() for values in world.contacts), strict=True):
        first, second = sorted((int(of_geom[a]), int(of_geom[b])))  # from the base outwards
        if distance < 0.0 and world.checked_pairs[a, b] and names[first] and names[second]:
            pair = names[first], names[second]
            found[pair] = max(-distance, found.get(pair, 0.0))
    collisions = (SelfCollision(*pair, depth) for pair, depth in found.items())
    return sorted(collisions, key=lambda collision: -collision.depth)


def permanent_self_collisions(world: CollisionWorld) -> list[tuple[str, str]]:
    """Return the pairs of a robot's own bodies that touch in every configuration.

    They overlap by design. `RobotDescription.exclude` disables their contacts.

    Args:
        world: The collision world of the robot, which may be compiled alone.
    """
    limits, rng = world.robot.limits, np.random.default_rng(0)
    lower, upper = limits.sampling_bounds()
    pairs: set[tuple[str, str]] | None = None
    for _ in range(CONFIGURATION_SAMPLES):
        found = self_collisions(world, rng.uniform(lower, upper))
        touching = {collision[:2] for collision in found}
        pairs = touching if pairs is None else pairs & touching
        if not pairs:
            break
    return sorted(pairs or ())


def check_home(world: CollisionWorld) -> None:
    """Check that a robot has no self-collision at home.

    Raises:
        RobotError: If it has; the message has the bodies, and the `exclude` entry for bodies that
            touch in every configuration.
    """
    description = world.robot.description
    collisions = self_collisions(world, np.array(description.home))
    if not collisions:
        return
    touching = [
        f"'{pair.first}' is {1e3 * pair.depth:.1f} mm inside '{pair.second}'" for pair in collisions
    ]
    if len(touching) > _LISTED:
        touching[_LISTED:] = [f"{len(touching) - _LISTED} more pairs"]
    permanent = permanent_self_collisions(world)
    remedies = []
    if permanent:
        listed = ", ".join(f'["{first}", "{second}"]' for first, second in permanent)
        remedies.append(
            "the description ignores contacts of bodies that overlap in every configuration by "
            f"exclude = [{listed}]"
        )
    if any(collision[:2] not in permanent for collision in collisions):
        remedies.append("other pairs need another 'home'" if permanent else "give another 'home'")
    raise RobotError(
        f"{description.where}: self-collision at home: {', '.join(touching)}; {'; '.join(remedies)}"
    )


def _body_names(world: CollisionWorld) -> list[str]:
    """Return the name of each body in the robot's description; empty for others."""
    model, prefix = world.robot.mj_model, world.robot.mjcf_model.full_identifier
    names = [model.body(body).name for body in range(model.nbody)]
    own = (name.startswith(prefix) and name != "world" for name in names)
    return [
        literal_name(name.removeprefix(prefix)) if mine else ""
        for name, mine in zip(names, own, strict=True)
    ]
