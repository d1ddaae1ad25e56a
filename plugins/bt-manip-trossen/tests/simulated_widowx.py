"""A simulated WidowX AI for tests: the server of trossen-arm-sim on loopback, driven by JSON.

It runs in an environment with trossen-arm-sim: ``python simulated_widowx.py HOST [MODEL]``. It
prints ``ready``, then a line for each line ``{"do": NAME, ...}`` that it reads, whose names are
methods of `Commands`; it ends with its input. Free bodies of the model stay where they are until
they are placed.

Its clock is that of the physics. It waits for the client: while references change, each reference
is followed by one step of the physics, so that a busy machine loses none, and what arrives can be
judged by its differences.
"""

import argparse
import json
import os
import sys
import threading
import time

import mujoco
import numpy as np
from trossen_arm_sim.protocol import ErrorState, Mode, pack_robot_output
from trossen_arm_sim.server import TrossenArmSimServer
from trossen_arm_sim.sim import DEFAULT_SCENE, WidowXSim

STEP = 2e-3  # [s]
PATIENCE = 5.0  # [s] of wall time in which the next reference of a moving arm is awaited
AT_REST = 0.1  # [s] the same of one whose references are almost at rest
SLOW = 1e-6  # [rad] of a step, with which they are
SETTLE = 0.05  # [s] for references that answer steps which were made without waiting
RATE = 1.0  # of the clock, relative to that on the wall, at most


class Arm(WidowXSim):
    """The physics: a step for each reference of a moving arm, and for each 2 ms of one at rest."""

    def __init__(self, model):
        super().__init__(model)
        self.model.opt.timestep = STEP
        joints = np.flatnonzero(self.model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        self.free = {self.model.body(self.model.jnt_bodyid[j]).name: j for j in joints}
        for body in self.free:
            self.model.body_gravcomp[self.model.body(body).id] = 1.0
        self.lock = threading.Lock()
        self.arrived = []  # clock [s] and reference [rad] of each step
        self.pushed = np.zeros(6)  # [N m]
        self._reference, self._moving, self._pending = np.zeros(6), False, False
        self._until = self._held = self._due = 0.0  # [s] on the wall

    def start(self):
        """Do nothing: the client's messages make the steps."""

    def apply_joint_commands(self, modes, positions):
        """Take a command, and make a step if it is time for one."""
        with self.lock:
            super().apply_joint_commands(modes, positions)
            reference, now = np.array(positions[:6]), time.monotonic()
            commanded = all(mode == Mode.POSITION for mode in modes[:6])
            changed = commanded and bool((reference != self._reference).any())
            if changed:
                moving = np.abs(reference - self._reference).max() > SLOW
                if moving and not self._moving:
                    self._held = now + SETTLE
                self._until = now + (PATIENCE if moving else AT_REST)
                self._moving, self._reference, self._pending = moving, reference, True
            if now < max(self._due, self._held) or not (self._pending or now > self._until):
                return
            self._pending = False
            self._due = max(self._due + STEP / RATE, now - STEP)
            self.data.qfrc_applied[self._qvel_addr[:6]] = self.pushed
            mujoco.mj_step(self.model, self.data)
            if commanded:
                self.arrived.append((self.data.time, *reference))


class Server(TrossenArmSimServer):
    """The controller, whose clock is that of the physics."""

    def _pack_output(self):
        self._output_id += 1
        state = self.error_state, self._output_id, int(1e6 * self.sim.data.time)
        return pack_robot_output(*state, self.sim.read_joint_outputs())


class Commands:
    """What a line of JSON can ask for."""

    def __init__(self, arm, server):
        self.arm_, self.server = arm, server

    def place(self, body, position, quat=(1.0, 0.0, 0.0, 0.0)):
        """Put a free body somewhere, at rest, and give it its weight."""
        self._set(body, [*position, *quat], 0.0)

    def take(self, body):
        """Take a free body away: let it float where it was at first."""
        self._set(body, None, 1.0)

    def _set(self, body, pose, weightless):
        model, data, joint = self.arm_.model, self.arm_.data, self.arm_.free[body]
        at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        with self.arm_.lock:
            data.qpos[at : at + 7] = model.qpos0[at : at + 7] if pose is None else pose
            data.qvel[dof : dof + 6] = 0.0
            model.body_gravcomp[model.jnt_bodyid[joint]] = weightless

    def poses(self):
        """Return positions and speeds of the free bodies."""
        model, data = self.arm_.model, self.arm_.data
        with self.arm_.lock:
            return {
                name: {
                    "position": data.qpos[model.jnt_qposadr[j] :][:3].tolist(),
                    "speed": float(np.abs(data.qvel[model.jnt_dofadr[j] :][:6]).max()),
                }
                for name, j in self.arm_.free.items()
            }

    def arm(self):
        """Return positions and velocities, the width of the gripper, and the clock [s]."""
        q, v = self.arm_._qpos_addr, self.arm_._qvel_addr
        with self.arm_.lock:
            return {
                "q": self.arm_.data.qpos[q[:6]].tolist(),
                "v": self.arm_.data.qvel[v[:6]].tolist(),
                "width": 2.0 * float(self.arm_.data.qpos[q[6]]),
                "time": self.arm_.data.time,
            }

    def save_references(self, file):
        """Save the clock and the references of all steps, and forget them; return their number."""
        with self.arm_.lock:
            np.save(file, np.array(self.arm_.arrived))
            count = len(self.arm_.arrived)
            self.arm_.arrived.clear()
        return count

    def push(self, torques):
        """Push the joints [N m]."""
        self.arm_.pushed = np.array(torques)

    def fault(self, reason):
        """Let a joint fail, which idles the arm."""
        self.server.fault(ErrorState.JOINT_LIMIT_EXCEEDED, reason)

    def cut(self):
        """Break the connection of the client."""
        self.server.stop()

    def restore(self):
        """Listen again."""
        self.server.start()


def serve(commands):
    """Answer the lines of the input; end the process with it."""
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"ok": getattr(commands, request.pop("do"))(**request)}
        except Exception as error:
            answer = {"error": repr(error)}
        print(json.dumps(answer), flush=True)
    os._exit(0)


def main():
    """Serve until the input ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("host")
    parser.add_argument("model", nargs="?", default=DEFAULT_SCENE)
    options = parser.parse_args()
    arm = Arm(options.model)
    server = Server(arm, options.host)
    server.start()
    print("ready", flush=True)
    serve(Commands(arm, server))


if __name__ == "__main__":
    main()
