"""What a gripper holds, by what its fingers touch."""

from collections.abc import Sequence

import mujoco


def held_root(model: mujoco.MjModel, data: mujoco.MjData, fingers: Sequence[int]) -> int:
    """Give the root body of the free object that all fingers touch; 0 where there is none.

    Args:
        model: What is simulated.
        data: Its contacts are looked at.
        fingers: Ids of the finger bodies.
    """
    if not fingers or not data.ncon:
        return 0
    bodies = model.geom_bodyid[data.contact.geom]  # (ncon, 2)
    roots: set[int] | None = None
    for finger in fingers:
        touched = bodies[:, ::-1][bodies == finger]
        here = {int(root) for root in model.body_rootid[touched]}
        roots = here if roots is None else roots & here
    free = [root for root in sorted(roots or ()) if _is_free(model, root)]
    return free[0] if free else 0


def _is_free(model: mujoco.MjModel, body: int) -> bool:
    joint = int(model.body_jntadr[body])
    return joint >= 0 and int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_FREE)
