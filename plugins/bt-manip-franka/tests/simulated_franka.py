"""A simulated robot for tests: a server of franka-sim on loopback, driven by lines of JSON.

It runs in an environment that has franka-sim, whose models ``FR3_MJCF`` and ``FRANKA_HAND_MJCF``
name: ``python simulated_franka.py HOST [--OPTION]``.
"""

import argparse
import contextlib
import logging
import os
import queue
import sys
import threading
import time

from frames import start_camera
from franka_sim.franka_protocol import ConnectStatus, MoveStatus, RobotMode
from franka_sim.franka_sim_server import FrankaSimServer
from franka_sim.mujoco_franka_sim import ARM_POSITION_KD, MujocoFrankaSim
from serving import Commands, serve

# Explicit damping of more than 2 I / dt is unstable: joint 7 (0.08 kg m2) swings with franka-sim's.
ARM_POSITION_KD[:] = 225.0, 225.0, 175.0, 175.0, 50.0, 50.0, 50.0  # [N m s/rad]
WAIT = 0.5  # [s] for the client's answer and for the physics, by a patient robot
NO_CLIENT = 0.1  # [s] without a state from which its clock goes with the time here
JOINT_REFLEX = 6  # position in research_interface::robot::Error


class Cell(MujocoFrankaSim):
    """The physics; functions of other threads run between two steps of it."""

    def __init__(self, collisions):
        super().__init__(enable_hand=True)
        self._collisions = collisions
        self.in_step = False  # with the cycles of the controller, instead of the clock
        self.go, self.done = threading.Semaphore(0), threading.Semaphore(0)
        self.calls = queue.SimpleQueue()

    def initialize_simulation(self):
        """Let things pass each other, where that is asked for."""
        super().initialize_simulation()
        if not self._collisions:
            self.model.geom_contype[:] = self.model.geom_conaffinity[:] = 0

    def step_now(self):
        """Let the physics make one step, and wait for it."""
        self.in_step = True
        while self.done.acquire(blocking=False):
            pass
        self.go.release()
        self.done.acquire(timeout=WAIT)

    def _apply_control(self):
        if self.in_step:
            self.done.release()
            self.in_step = self.go.acquire(timeout=WAIT)
        super()._apply_control()
        while not self.calls.empty():
            self.calls.get()()

    def in_physics(self, function):
        """Run a function between two steps, and return its result."""
        results = queue.SimpleQueue()
        self.calls.put(lambda: results.put(function()))
        return results.get(timeout=10.0)


class Robot(FrankaSimServer):
    """The controller, with faults."""

    patient = False
    version, stopped, longest_gap, lost, cycles, violations = 10, False, 0, 0, 0, 0
    clock = published = 0.0  # [s] of its own, and here when the last state was published

    def send_response(self, client_socket, command, command_id, status, version):
        """Refuse clients when the version is another one."""
        if self.version != version:
            status = ConnectStatus.kIncompatibleLibraryVersion
        super().send_response(client_socket, command, command_id, status, self.version)

    def _account_for_communication_cycle(self):
        if self.patient and self.comm.active:
            end = time.monotonic() + WAIT
            while self.comm.awaiting_answer and time.monotonic() < end:
                time.sleep(5e-5)
            self.physics_sim.step_now()
        now = time.monotonic()
        self.clock += now - self.published if now - self.published > NO_CLIENT else 1e-3
        self.published = now
        before = self.comm.consecutive_lost
        super()._account_for_communication_cycle()
        if (gap := self.comm.consecutive_lost) > before:
            self.lost, self.longest_gap = self.lost + 1, max(self.longest_gap, gap)
        if self.stopped:
            self.robot_state.state["robot_mode"] = RobotMode.kUserStopped
        self.cycles += self.comm.active

    def _abort_on_communication_violation(self, motion_id):
        self.violations += 1
        self.longest_gap = max(self.longest_gap, self.comm.consecutive_lost)
        super()._abort_on_communication_violation(motion_id)

    def _refuse_move_while_latched(self, client_socket, header):
        if self.stopped:
            self.robot_state.state["robot_mode"] = RobotMode.kReflex  # refused as in a reflex
        return super()._refuse_move_while_latched(client_socket, header)

    def handle_automatic_error_recovery_command(self, client_socket, header, payload):
        """Forget which joint collided."""
        super().handle_automatic_error_recovery_command(client_socket, header, payload)
        self.robot_state.state["joint_collision"] = [0.0] * 7


class FrankaCommands(Commands):
    """What a line of JSON can ask for."""

    def __init__(self, robot, cell):
        super().__init__(cell.model, cell.data, cell.in_physics)
        self.robot, self.cell = robot, cell

    def arm(self):
        """Return the arm's positions and velocities, the width of the hand, and its clock [s]."""

        def read():
            data, cell = self.cell.data, self.cell
            return {
                "q": data.qpos[cell.arm_qpos_adr].tolist(),
                "v": data.qvel[cell.arm_dofs_idx].tolist(),
                "width": float(data.qpos[cell.finger_qpos_adr].sum()),
                "time": self.robot.clock,
            }

        return self.cell.in_physics(read)

    def move_by_hand(self, q):
        """Put the arm somewhere else, where its controller holds it."""

        def put():
            cell = self.cell
            cell.data.qpos[cell.arm_qpos_adr] = q
            cell.data.qvel[cell.arm_dofs_idx] = 0.0
            cell.update_joint_positions(q)
            cell.set_control_mode(cell.control_mode)

        self.cell.in_physics(put)
        self.robot.robot_state.state["q_d"] = list(q)

    def reflex(self, joint):
        """Stop the motion by a reflex of a joint."""
        hit = [0.0] * 7
        hit[joint - 1] = 1.0
        self.robot.robot_state.state["joint_collision"] = hit
        self.robot._abort_with_error(JOINT_REFLEX, f"injected reflex of joint {joint}")

    def user_stop(self, pressed):
        """Press or release the user stop."""
        self.robot.stopped = pressed
        state = self.robot.robot_state.state
        if pressed:
            with self.robot._motion_lock:
                self.robot._abort_with_error((), "user stop")
                pending = self.robot._pending_move_response
                if pending:
                    motion, _, after = pending
                    aborted = MoveStatus.kEmergencyAborted
                    self.robot._pending_move_response = motion, aborted, after
        state["robot_mode"] = RobotMode.kUserStopped if pressed else RobotMode.kIdle

    def cut(self):
        """Break the connection of the client."""
        self.robot.connection_running = False
        self.robot.transmitting_state = False

    def set_version(self, version):
        """Let the robot have another version."""
        self.robot.version = version

    def errors(self):
        """Return the numbers of the present errors."""
        return [n for n, error in enumerate(self.robot.robot_state.state["errors"]) if error]

    def camera(self, name, size):
        """Let a camera serve its frames; return the port."""
        cell = self.cell
        where = self.robot.host, name, size
        return start_camera(cell.model, cell.data, cell.in_physics, *where)

    def communication(self):
        """Return the cycles of motions, those lost, the longest run of these, and violations."""
        names = "cycles", "lost", "longest_gap", "violations"
        return {name: getattr(self.robot, name) for name in names}


def main():
    """Serve until the input ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("host")
    parser.add_argument("--constraints", action="store_true", help="of communication, too")
    parser.add_argument(
        "--patient",
        action="store_true",
        help="wait for physics and client in each cycle, so that a busy machine loses none",
    )
    parser.add_argument("--no-collisions", action="store_true", help="let things pass each other")
    options = parser.parse_args()
    with contextlib.suppress(OSError):
        os.nice(-10)  # as a robot, it does not wait for its clients
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    cell = Cell(collisions=not options.no_collisions)
    robot = Robot(
        host=options.host,
        physics_sim=cell,
        gripper_physics=True,
        enforce_motion_limits=True,
        enforce_comm_constraints=options.constraints,
    )
    robot.patient = options.patient

    def announce():
        while robot.server_socket is None or not cell.running:
            threading.Event().wait(0.02)
        serve(FrankaCommands(robot, cell))

    threading.Thread(target=announce, daemon=True).start()
    robot.start()


if __name__ == "__main__":
    main()
