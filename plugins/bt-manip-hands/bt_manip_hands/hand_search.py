"""Search for a hand in a model: palm, thumb, fingers, and an open and a closed posture."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.grippers import collision_geoms_of
from bt_manip.robots import FoundGripper, effort_limit

_WIDTHS = (0.09, 0.075, 0.06)  # [m] of the widest object; the first feasible one is used
_SAMPLES = 4000  # postures of the fingers, and of the thumb
_CLOSED = 100  # closed postures for which an open posture is searched
_MEETS = (0.4, 1.0)  # distance of the closed tips' centres relative to the sum of their radii
_NEAR = 8e-3  # [m] tolerance of the positions of the open tips
_ACROSS = 0.4  # maximum cosine of closing and approach
_FRONT = 0.1  # weight of an approach along the z axis of the palm, away from its mount
_BEHIND = 0.05  # [m] minimum distance of the palm behind the point where the tips meet
_HALF = 0.03  # [m] half the size of an object along the approach
_MARGIN = 0.1  # distance of postures from joint limits, relative to the range
_EFFORT = 0.5  # [N m] of joints whose actuators have no limit
_DEFLECTION = 0.175  # [rad] from the reference at which a joint exerts its effort limit
_FORCE_SHARE = 0.8  # used fraction of the thumb's force, limited by its weakest joint
_LEVER = 5e-3  # [m] minimum lever of a considered joint


class _Digit(NamedTuple):
    """First body, joints from the palm outwards, and collision geoms of a finger or the thumb."""

    body: int
    joints: list[int]
    geoms: list[int]
    """The last one is the tip."""


class _Postures(NamedTuple):
    """Sampled postures, in the palm frame."""

    q: np.ndarray  # (n, nq) [rad]
    tips: np.ndarray
    """Mean position of the tips [m].  # (n, 3)"""
    links: np.ndarray
    """Centres of the geoms, the tips last [m].  # (n, ngeom, 3)"""


def find_hand(model: mujoco.MjModel, arm_joints: Sequence[str]) -> FoundGripper | None:
    """Return a hand beyond the arm's last joint; None if there is none.

    A hand has a palm with at least three digits. The thumb is the digit whose last hinge is the
    least parallel to those of the others. In the closed posture the tip of the thumb meets those of
    the fingers, which move alike. In the open posture the tips are on opposite sides of this point,
    in front and without links between them. Both postures are searched by sampling.
    """
    palm, digits = _digits(model, arm_joints)
    if len(digits) < 3:
        return None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    axes = np.array([data.xaxis[digit.joints[-1]] for digit in digits])
    thumb = digits.pop(int(np.abs(axes @ axes.T).sum(axis=1).argmin()))
    rng = np.random.default_rng(0)
    fingers = _sample(model, palm, digits, rng, alike=True)
    opposed = _sample(model, palm, [thumb], rng, alike=False)
    own = collision_geoms_of(model, palm)
    centre = _in_palm(data, palm, data.geom_xpos[own]).mean(axis=0) if own else np.zeros(3)
    size = float(model.geom_rbound[thumb.geoms[-1]] + model.geom_rbound[digits[0].geoms[-1]])
    for width in _WIDTHS:
        found = _best(fingers, opposed, centre, size, width, rng)
        if found is not None:
            return _describe(model, palm, thumb, digits, fingers, opposed, found, width)
    return None


def _digits(model: mujoco.MjModel, arm_joints: Sequence[str]) -> tuple[int, list[_Digit]]:
    """Return the palm, and the digits at it."""
    last = int(model.jnt_bodyid[model.joint(arm_joints[-1]).id])
    jointed = [int(model.jnt_bodyid[j]) for j in range(model.njnt)]
    paths = {b: _path(model, b) for b in jointed if last in _path(model, b)[:-1]}
    if not paths:
        return last, []
    palm = last
    for level in zip(*paths.values(), strict=False):
        if len(set(level)) > 1:
            break
        palm = level[0]
    digits: dict[int, _Digit] = {}
    for body, path in paths.items():
        if palm not in path[:-1]:
            return palm, []  # a joint above the palm: a wrist
        first = path[path.index(palm) + 1]
        digit = digits.setdefault(first, _Digit(first, [], []))
        digit.joints.extend(np.flatnonzero(model.jnt_bodyid == body).tolist())
    for body in range(model.nbody):
        for first in set(_path(model, body)) & digits.keys():
            digits[first].geoms.extend(collision_geoms_of(model, body))
    return palm, [d for d in digits.values() if len(d.joints) > 1 and d.geoms]


def _path(model: mujoco.MjModel, body: int) -> list[int]:
    """Return the bodies from the base to a body."""
    found = [body]
    while found[0]:
        found.insert(0, int(model.body_parentid[found[0]]))
    return found


def _in_palm(data: mujoco.MjData, palm: int, point: np.ndarray) -> np.ndarray:
    """Transform one or several points from the world to the palm's frame [m]."""
    return np.asarray((point - data.xpos[palm]) @ data.xmat[palm].reshape(3, 3))


def _sample(
    model: mujoco.MjModel,
    palm: int,
    digits: Sequence[_Digit],
    rng: np.random.Generator,
    *,
    alike: bool,
) -> _Postures:
    """Sample postures; fingers move alike, and joints with a symmetric range stay at its centre."""
    data, joints = mujoco.MjData(model), [j for digit in digits for j in digit.joints]
    depth = [k for digit in digits for k in range(len(digit.joints))]
    lower, upper = model.jnt_range[joints].T
    level = np.abs(lower + upper) < 0.2 * (upper - lower)
    columns = max(depth) + 1 if alike else len(joints)
    shares = rng.uniform(_MARGIN, 1.0 - _MARGIN, (_SAMPLES, columns))
    shares = shares[:, depth] if alike else shares
    q = lower + shares * (upper - lower)
    if alike:
        q[:, level] = 0.5 * (lower + upper)[level]
    geoms = [g for digit in digits for g in digit.geoms[:-1]] + [d.geoms[-1] for d in digits]
    links = np.empty((_SAMPLES, len(geoms), 3))
    for i in range(_SAMPLES):
        data.qpos[model.jnt_qposadr[joints]] = q[i]
        mujoco.mj_kinematics(model, data)
        links[i] = _in_palm(data, palm, data.geom_xpos[geoms])
    return _Postures(q, links[:, -len(digits) :].mean(axis=1), links)


class _Found(NamedTuple):
    """Indices of the closed and open postures of fingers and thumb; and the tool in the palm."""

    closed: tuple[int, int]
    open: tuple[int, int]
    T_pt: pin.SE3


def _best(
    fingers: _Postures,
    thumb: _Postures,
    palm: np.ndarray,
    size: float,
    width: float,
    rng: np.random.Generator,
) -> _Found | None:
    """Return the best pair of a closed posture and an open one, of a width between the tips [m].

    ``size`` is the sum of the radii of two tips, and ``palm`` the centre of the palm [m].
    """
    from scipy.spatial import KDTree  # takes a while, and each command loads this module

    opposite = KDTree(thumb.tips)
    distance, nearest = opposite.query(fingers.tips)
    near, far = (share * size for share in _MEETS)
    closed = np.flatnonzero((distance > near) & (distance < far))
    best: tuple[float, _Found] | None = None
    for i in rng.permutation(closed)[:_CLOSED].tolist():
        j = int(nearest[i])
        middle = 0.5 * (fingers.tips[i] + thumb.tips[j])
        away = middle - palm
        offset = fingers.tips - middle
        length = np.linalg.norm(offset, axis=1)
        along = offset / length[:, None]
        across = along @ away
        forward = away - across[:, None] * along
        behind = np.linalg.norm(forward, axis=1)
        fits = np.abs(length - 0.5 * (width + size)) < _NEAR
        fits &= (behind >= _BEHIND) & (np.abs(across) <= _ACROSS * np.linalg.norm(away))
        wide = np.flatnonzero(fits)
        gaps, partners = opposite.query(middle - offset[wide])
        for k, m in zip(
            wide[gaps <= _NEAR].tolist(), partners[gaps <= _NEAR].tolist(), strict=True
        ):
            y, z = along[k], forward[k] / behind[k]
            score = min(float(behind[k]), 0.1) + _FRONT * z[2]
            for one, number, sign in ((fingers, k, 1.0), (thumb, m, -1.0)):
                links = one.links[number] - middle
                tip = one.tips[number] - middle
                score -= 3.0 * max(0.0, float((links @ z).max() - tip @ z))  # tips in front
                between = links[links @ z > -_HALF] @ y * sign
                score -= 3.0 * max(0.0, 0.5 * width - float(between.min()))  # no link between
            if best is None or score > best[0]:
                R = np.column_stack([np.cross(y, z), y, z])
                best = score, _Found((i, j), (k, m), pin.SE3(R, middle))
    return None if best is None or best[0] < 0.0 else best[1]


def _describe(
    model: mujoco.MjModel,
    palm: int,
    thumb: _Digit,
    digits: Sequence[_Digit],
    fingers: _Postures,
    opposed: _Postures,
    found: _Found,
    width: float,
) -> FoundGripper:
    """Return the parameters of the kind ``hand``."""
    joints = [j for digit in (*digits, thumb) for j in digit.joints]
    postures = [
        np.round(np.concatenate([fingers.q[i], opposed.q[j]]), 3).tolist()
        for i, j in (found.open, found.closed)
    ]
    limits = np.array([effort_limit(model, j) for j in joints])
    effort = np.where(np.isfinite(limits), limits, _EFFORT)
    force = _thumb_force(model, palm, thumb, opposed.q[found.closed[1]], found, effort)
    return FoundGripper(
        parameters={
            "palm": model.body(palm).name,
            "thumb": model.body(thumb.body).name,
            "fingers": [model.body(digit.body).name for digit in digits],
            "joints": [model.joint(j).name for j in joints],
            "open": postures[0],
            "closed": postures[1],
            "effort": effort.tolist(),
            "stiffness": np.round(effort / _DEFLECTION, 3).tolist(),
            "max_width": width,
        },
        max_force=force,
        body=model.body(palm).name,
        T_bt=found.T_pt,
        notes={
            "gripper": "Found by sampling postures in which the thumb meets the fingers.",
            "gripper.effort": "Of the model; CHOSEN where its actuators have no limits [N m].",
            "gripper.stiffness": "CHOSEN: the effort limit at 10 degrees [N m/rad].",
        },
    )


def _thumb_force(
    model: mujoco.MjModel,
    palm: int,
    thumb: _Digit,
    q: np.ndarray,
    found: _Found,
    effort: np.ndarray,
) -> float:
    """Return the force with which the closed thumb can press [N]."""
    data = mujoco.MjData(model)
    data.qpos[model.jnt_qposadr[thumb.joints]] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    jacobian, tip = np.zeros((3, model.nv)), thumb.geoms[-1]
    body = int(model.geom_bodyid[tip])
    mujoco.mj_jac(model, data, jacobian, None, data.geom_xpos[tip], body)
    y = data.xmat[palm].reshape(3, 3) @ found.T_pt.rotation[:, 1]
    levers = np.abs(y @ jacobian[:, model.jnt_dofadr[thumb.joints]])
    forces = effort[-len(thumb.joints) :][levers > _LEVER] / levers[levers > _LEVER]
    return float(f"{_FORCE_SHARE * float(forces.min()):.2g}")
