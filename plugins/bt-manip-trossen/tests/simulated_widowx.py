"""A simulated WidowX AI for tests: the server of trossen-arm-sim on loopback, driven by JSON.

It runs in an environment with trossen-arm-sim: ``python simulated_widowx.py HOST [MODEL]``.

Its clock is that of the physics. It waits for the client: while references change, each reference
is followed by one step of the physics, so that a busy machine loses none, and what arrives can be
judged by its differences.
"""

import argparse
import threading
import time

import mujoco
import numpy as np
from serving import Commands, serve
from trossen_arm_sim.protocol import ErrorState, Mode, pack_robot_output
from trossen_arm_sim.server import TrossenArmSimServer
from trossen_arm_sim.sim import DEFAULT_SCENE, WidowXSim

STEP = 2e-3  # [s]
PATIENCE = 0.9  # [s] of wall time in which the next reference of a moving arm is awaited
AT_REST = 0.1  # [s] the same of one whose references are almost at rest
SLOW = 1e-6  # [rad] of a step, with which they are
SETTLE = 0.05  # [s] for references that answer steps which were made without waiting
RATE = 1.0  # of the clock, relative to that on the wall, at most


class Arm(WidowXSim):
    """The physics: a step for each reference of a moving arm, and for each 2 ms of one at rest."""

    def __init__(self, model):
        super().__init__(model)
        self.model.opt.timestep = STEP
        free = self.model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
        self.model.body_gravcomp[self.model.jnt_bodyid[free]] = 1.0  # they float at first
        self.lock = threading.Lock()
        self.arrived = []  # clock [s] and reference [rad] of each step
        self._reference = None  # [rad] of the last command, if there was one
        self._moving = self._pending = False
        self._patience = 0.0  # [s] that are left of it, while the client sends anything at all
        self._last = self._held = self._due = 0.0  # [s] on the wall

    def start(self):
        """Do nothing: the client's messages make the steps."""

    def in_physics(self, function):
        """Call a function between two steps, and return its result."""
        with self.lock:
            return function()

    def apply_joint_commands(self, modes, positions):
        """Take a command, and make a step if it is time for one."""
        with self.lock:
            super().apply_joint_commands(modes, positions)
            commanded = all(mode == Mode.POSITION for mode in modes[:6])
            reference, now = np.array(positions[:6]) if commanded else None, time.monotonic()
            self._patience -= min(now - self._last, STEP)
            self._last = now
            if reference is None or self._reference is None:  # a new client, or none
                self._moving, self._pending, self._patience = False, False, 0.0
            elif (change := np.abs(reference - self._reference).max()) > 0.0:
                moving = change > SLOW
                if moving and not self._moving:
                    self._held = now + SETTLE
                self._patience = PATIENCE if moving else AT_REST
                self._moving, self._pending = moving, True
            self._reference = reference
            if now < max(self._due, self._held) or not (self._pending or self._patience <= 0.0):
                return
            self._pending = False
            self._due = max(self._due + STEP / RATE, now - STEP)
            mujoco.mj_step(self.model, self.data)
            if commanded:
                self.arrived.append((self.data.time, *reference))


class Server(TrossenArmSimServer):
    """The controller, whose clock is that of the physics."""

    def _pack_output(self):
        self._output_id += 1
        state = self.error_state, self._output_id, int(1e6 * self.sim.data.time)
        return pack_robot_output(*state, self.sim.read_joint_outputs())


class WidowXCommands(Commands):
    """What a line of JSON can ask for."""

    def __init__(self, arm, server):
        super().__init__(arm.model, arm.data, arm.in_physics)
        self.arm_, self.server = arm, server

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

    def fault(self, reason):
        """Let a joint fail, which idles the arm."""
        self.server.fault(ErrorState.JOINT_LIMIT_EXCEEDED, reason)

    def cut(self):
        """Break the connection of the client."""
        self.server.stop()

    def restore(self):
        """Listen again."""
        self.server.start()


def main():
    """Serve until the input ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("host")
    parser.add_argument("model", nargs="?", default=DEFAULT_SCENE)
    options = parser.parse_args()
    arm = Arm(options.model)
    server = Server(arm, options.host)
    server.start()
    serve(WidowXCommands(arm, server))


if __name__ == "__main__":
    main()
