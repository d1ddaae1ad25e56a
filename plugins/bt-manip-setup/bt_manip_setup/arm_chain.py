"""Kinematic chain of an arm in a model, from the base to the flange."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.cell import literal_name
from bt_manip.collision import moved_bodies
from bt_manip.exceptions import did_you_mean
from bt_manip.robots import RobotError

_MOVING = (int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE))
_FINGER_WORDS = ("finger", "jaw", "grip", "claw", "knuckle")
_MOUNT_WORDS = ("attach", "flange", "mount", "tool", "tcp", "ee")
_FINGER_DEPTH = 4  # largest number of joints in series that count as a finger after a branch
_LEAST_CHOSEN = 2  # fewest joints of an arm
_LEAST_ARM = 3  # fewest joints before a single joint that may be a jaw
_JAW_OPENING = 0.02  # [m] smallest opening of a jaw
_JAW_CLOSED = 2e-3  # [m] largest gap of a closed jaw
_JAW_STEPS = 9  # joint positions at which a possible jaw is measured


class ArmChain(NamedTuple):
    """Ids of the joints of an arm, from the base to the tool, and of what is beyond."""

    joints: tuple[int, ...]
    flange: tuple[int, ...]
    """The last link and the bodies fixed to it, the link first."""
    fingers: tuple[int, ...]
    """The joints beyond the last link."""


def find_arm(model: mujoco.MjModel, joints: Sequence[str] | None = None) -> ArmChain:
    """Return the longest chain of hinges and slides from the base, without fingers.

    The chain ends before short branches, or before a jaw that closes against the last link. If the
    names of its joints are given, they are looked up.

    Raises:
        RobotError: If there is no such chain, or the longest one is ambiguous.
    """
    names = [literal_name(model.joint(j).name) for j in range(model.njnt)]
    if joints is not None:
        unknown = [name for name in joints if name not in names]
        if unknown:
            near = did_you_mean(unknown[0], names)
            raise RobotError(f"the model has no joint '{unknown[0]}'{near} (--joints)")
        chain = [names.index(name) for name in joints]
    else:
        chain = _longest(model)
    if len(chain) < _LEAST_CHOSEN:
        raise RobotError(f"an arm has at least {_LEAST_CHOSEN} joints, got {len(chain)} (--joints)")
    nameless = [j for j in chain if not names[j]]
    if nameless:
        raise RobotError(f"joint #{nameless[0]} of the arm has no name: name it in the model")
    last = int(model.jnt_bodyid[chain[-1]])
    flange = tuple(np.flatnonzero(model.body_weldid == model.body_weldid[last]).tolist())
    below = moved_bodies(model, model.jnt_dofadr[chain[-1:]])[model.jnt_bodyid]
    beyond = [j for j in np.flatnonzero(below).tolist() if j not in chain]
    return ArmChain(tuple(chain), flange, tuple(beyond))


def find_mount(model: mujoco.MjModel, arm: ArmChain, mount: str | None = None) -> str:
    """Return the name of the site or body at the flange on which a gripper is mounted.

    Sites named like a mount are preferred, then other sites, then the last body.

    Raises:
        RobotError: If the given name is not at the flange, or nothing there has a name.
    """
    sites = [s for s in range(model.nsite) if int(model.site_bodyid[s]) in arm.flange]
    named = [model.site(s).name for s in sites]
    named += [model.body(b).name for b in reversed(arm.flange)]
    known = [literal_name(name) for name in named if name]
    if mount is not None:
        if mount not in known:
            raise RobotError(
                f"beyond the last joint there is no site or body '{mount}'"
                f"{did_you_mean(mount, known)} (--mount)"
            )
        return mount
    if not known:
        raise RobotError("nothing beyond the last joint has a name: name a site in the model")
    told = [name for name in known if any(word in name.lower() for word in _MOUNT_WORDS)]
    return (told or known)[0]


def _longest(model: mujoco.MjModel) -> list[int]:
    children = _children(model)
    free = [j for j in range(model.njnt) if int(model.jnt_type[j]) not in _MOVING]
    depth: dict[int, int] = {}

    def count(body: int) -> int:
        below = max((count(child) for child in children.get(body, ())), default=0)
        depth[body] = below + int(model.body_jntnum[body])
        return depth[body]

    count(0)
    chain: list[int] = []
    body = 0
    while following := children.get(body, []):
        ranked = sorted(following, key=lambda b: depth[b], reverse=True)
        if len(ranked) > 1 and chain and depth[ranked[0]] <= _FINGER_DEPTH:
            break
        if len(ranked) > 1 and depth[ranked[0]] == depth[ranked[1]]:
            first, second = (
                literal_name(model.joint(int(model.body_jntadr[b])).name) for b in ranked[:2]
            )
            raise RobotError(
                f"the model has several arms, one from joint '{first}', one from '{second}': "
                "choose the joints of one (--joints)"
            )
        body = ranked[0]
        start = int(model.body_jntadr[body])
        own = list(range(start, start + int(model.body_jntnum[body])))
        if len(chain) >= _LEAST_ARM and depth[body] == len(own) == 1 and _is_jaw(model, own[0]):
            break
        chain += own
    if not chain:
        raise RobotError("the model has no joints: an arm has hinges and slides")
    if any(j in chain for j in free):
        name = literal_name(model.joint(free[0]).name)
        raise RobotError(
            f"joint '{name}' is free or a ball: an arm has hinges and slides; choose its joints "
            "(--joints)"
        )
    return chain


def _children(model: mujoco.MjModel) -> dict[int, list[int]]:
    """Return the next bodies with joints below each body with joints (0: the world)."""
    found: dict[int, list[int]] = {}
    for body in range(1, model.nbody):
        if model.body_jntnum[body]:
            parent = int(model.body_weldid[model.body_parentid[body]])
            found.setdefault(parent, []).append(body)
    return found


def _is_jaw(model: mujoco.MjModel, joint: int) -> bool:
    """Return whether a joint closes its link against the previous link."""
    name = model.joint(joint).name.lower() + model.body(int(model.jnt_bodyid[joint])).name.lower()
    if any(word in name for word in _FINGER_WORDS):
        return True
    if not model.jnt_limited[joint]:
        return False
    own = model.body_weldid[model.geom_bodyid] == model.jnt_bodyid[joint]
    parent = model.body_weldid[model.body_parentid[model.jnt_bodyid[joint]]]
    other = model.body_weldid[model.geom_bodyid] == parent
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    pairs = list(product(np.flatnonzero(own & collides), np.flatnonzero(other & collides)))
    data, rows = mujoco.MjData(model), []
    lower, upper = model.jnt_range[joint].tolist()
    for q in np.linspace(lower, upper, _JAW_STEPS):
        data.qpos[model.jnt_qposadr[joint]] = q
        mujoco.mj_kinematics(model, data)
        rows.append([mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in pairs])
    distances = np.array(rows)
    opens = (distances.min(0) < _JAW_CLOSED) & (distances.max(0) > _JAW_OPENING)
    return bool(opens.any())
