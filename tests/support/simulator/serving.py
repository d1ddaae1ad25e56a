"""What simulators of robots for tests share: they are driven by lines of JSON.

It runs in the environment of a simulator, with NumPy and MuJoCo and nothing of this project.
"""

import json
import os
import sys

import mujoco
import numpy as np


class Commands:
    """What a line ``{"do": NAME, ...}`` can ask of each simulator: its public methods.

    Free bodies of the model float where they are until they are placed, and have weight from then
    on.

    Args:
        model: The cell.
        data: Its state.
        in_physics: Calls a function between two steps, and returns its result.
    """

    def __init__(self, model, data, in_physics):
        self._model, self._data, self._in_physics = model, data, in_physics
        joints = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        self._free = {model.body(model.jnt_bodyid[joint]).name: joint for joint in joints}

    def place(self, body, position, quat=(1.0, 0.0, 0.0, 0.0)):
        """Put a free body somewhere, at rest, and give it its weight."""
        self._set(body, [*position, *quat], weightless=0.0)

    def take(self, body):
        """Take a free body away: let it float where it was at first."""
        self._set(body, None, weightless=1.0)

    def _set(self, body, pose, weightless):
        def put():
            model, data, joint = self._model, self._data, self._free[body]
            at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
            data.qpos[at : at + 7] = model.qpos0[at : at + 7] if pose is None else pose
            data.qvel[dof : dof + 6] = 0.0
            model.body_gravcomp[model.jnt_bodyid[joint]] = weightless

        self._in_physics(put)

    def poses(self):
        """Return positions [m] and greatest speeds [m/s, rad/s] of the free bodies."""

        def read():
            model, data = self._model, self._data
            return {
                name: {
                    "position": data.qpos[model.jnt_qposadr[j] :][:3].tolist(),
                    "speed": float(np.abs(data.qvel[model.jnt_dofadr[j] :][:6]).max()),
                }
                for name, j in self._free.items()
            }

        return self._in_physics(read)


def serve(commands):
    """Print ``ready``, then an answer for each line of the input; end the process with it."""
    print("ready", flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"ok": getattr(commands, request.pop("do"))(**request)}
        except Exception as error:
            answer = {"error": repr(error)}
        print(json.dumps(answer), flush=True)
    os._exit(0)
