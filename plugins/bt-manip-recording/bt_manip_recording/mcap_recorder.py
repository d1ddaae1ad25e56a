"""Record everything in a run to an MCAP file."""

import json
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import mujoco
import numpy as np

from bt_manip.bt import NodeStatus, instance_to_xml
from bt_manip.cell import parse_size
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import Parameter
from bt_manip.record import identify, is_special, live_state, take_snapshot, versions, whole_file
from bt_manip.runner import PendingSteps, Run, RunEvent, RunObserver, StepLog
from bt_manip_recording.log_lines import log_line
from bt_manip_recording.tool_paths import tool_path

if TYPE_CHECKING:
    from bt_manip_recording.camera_images import CameraImages
    from bt_manip_recording.foxglove import SceneMessages
    from bt_manip_recording.mcap_file import McapFile

TOPICS = {
    "tree": "/tree/nodes",
    "status": "/tree/status",
    "message": "/tree/messages",
    "edit": "/tree/edits",
    "blackboard": "/blackboard",
    "entity": "/entities",
    "contact": "/contacts",
    "motion": "/motions",
    "controller": "/controllers",
    "cycle": "/cycles",
    "intervention": "/interventions",
}
"""Topics of the recorded events, by their kind."""

CAMERAS = "/cameras"
"""Topic of the cameras."""

SNAPSHOTS = "/snapshots"
"""Topic of the snapshots from which `Continuation` starts."""

SNAPSHOT_INTERVAL = 5.0
"""Longest simulated time between two snapshots in a recording [s]."""

STATE = (
    '{"force":[%.6g,%.6g,%.6g],"torque":[%.6g,%.6g,%.6g],"grip_forces":[%s],"held":%s,'
    '"gripped":%s,"saturated_steps":%d,"speed_scale":%.6g}'
)
"""State of a robot after a tick [N, N m]; formatted in a fifth of a JSON encoder's time."""


class McapRecorder(RunObserver):
    """Write scene, tree, joints, contacts and log to an MCAP file, for Foxglove.

    Joints, references and torques are recorded at every control step, the rest at every tick.
    All times are simulated times; only the metadata say on which date the run started.

    Args:
        path: The file to write.
        cameras: Full names of the cameras whose images are recorded, separated by commas.
        image_size: Their width and height [pixels].
        image_fps: Images per simulated second.

    Raises:
        BtManipError: If the path is missing.
    """

    suffix: ClassVar[str] = ".mcap"
    kinds = tuple(TOPICS)

    _file: "McapFile"  # from `run_started` on
    _scene: "SceneMessages"  # from the first `after_compile` on

    def __init__(  # noqa: D417 (options are declared in their annotations)
        self,
        path: Path | None,
        *,
        cameras: Annotated[
            str, Parameter("Full names of cameras whose images are recorded, separated by commas")
        ] = "",
        image_size: Annotated[str, Parameter("Their width and height", "pixels")] = "640x400",
        image_fps: Annotated[
            float, Parameter("Images per simulated second", "Hz", above=0.0)
        ] = 5.0,
    ) -> None:
        if path is None:
            raise BtManipError("a recording needs a file to be written to: --record FILE.mcap")
        self._path = path
        self._open = ExitStack()  # closes what `run_started` opens
        self._images: CameraImages | None = None
        if cameras:
            from bt_manip_recording import camera_images

            names, size = cameras.split(","), parse_size(image_size)
            self._images = camera_images.CameraImages(names, size, image_fps)

    def check(self, run: Run) -> None:
        """Check that the cameras can be rendered."""
        if self._images is not None:
            self._images.bind(run.station.cell, first=True)

    def run_started(self, run: Run) -> None:
        """Open the file and identify the run."""
        from bt_manip_recording.mcap_file import McapFile

        self._run, self._cell, self._tree = run, run.station.cell, run.tree
        self._station = run.station
        self._shown: Mapping[str, Any] = {}  # the appearance of the entities, by name
        self._layout: dict[str, Any] | None = None
        self._poses: list[tuple[float, int, bytes]] = []  # time, number of ticks, poses
        self._robots: list[RobotChannel] = []
        file = self._file = McapFile(self._path, self._encode)
        self._open.callback(file.close)
        describe_run(file, run)
        file.add_topic(SNAPSHOTS)
        run.log.keep_digest()  # snapshots have it
        logs = run.log.steps()
        self._models = {n: one.arm.model.copy() for n, one in self._station.robots.items()}
        self._robots = [
            RobotChannel(file, self._cell, one, logs[name])
            for name, one in self._station.robots.items()
        ]
        sources = run.station.parts.by_kind().get("message_sources")  # None: not a plugin of it
        makers = [sources.maker(name, "__call__") for name in sources.in_order()] if sources else []
        self._sources = [make(run, self._add_message) for make in makers]

    def after_compile(self) -> None:
        """Bind to the new model; write the geometry of new entities."""
        from bt_manip_recording.foxglove import SceneMessages, cameras_of

        first = not self._shown
        with self._file.lock:
            self._encode()
            if self._images is not None:
                self._images.bind(self._cell)
            cell = self._cell
            self._scene = SceneMessages(cell.model, cell.data, cell.entities)
            for robot in self._robots:
                robot.bind()
        self._write_scene()
        self._file.add("/tf_static", self._now, self._scene.fixed_frames(self._now))
        self._file.add_json(CAMERAS, self._now, cameras_of(self._scene.scene))
        if first:
            self._copy_poses()

    def handle(self, event: RunEvent) -> None:
        """Write an event, and its line in the log."""
        add_event(self._file, event)
        if event.kind == "motion":
            self._draw_path(event.data["robot"], event.data["moving"], nanoseconds(event.time))

    def cycle_started(self, cycle: int) -> None:
        """Write the randomized values, and in the first cycle the layout."""
        self._write_scene()
        self._write_images()
        if self._layout is None:
            self._write_layout()
            self._write_snapshot()

    def before_tick(self) -> None:
        """Count the ticks: messages have the number of ticks so far as their sequence number."""
        self._file.sequence += 1

    def after_tick(self) -> None:
        """Copy the poses and the states of the robots; write a chunk if it is full."""
        time = self._cell.time
        self._copy_poses()
        for robot in self._robots:
            robot.end_tick(time)
        self._write_images()
        for write in self._sources:
            write()
        if self._run.cycle != self._snapshot_cycle:
            self._write_snapshot()
        elif time - self._snapshot_time >= SNAPSHOT_INTERVAL - 0.5 * self._cell.dt:
            # A run that is interrupted goes on without ticks.
            if self._tree.nodes[0].engine_status is NodeStatus.RUNNING:
                self._write_snapshot()
        self._file.end_tick(nanoseconds(time))

    def cycle_ended(self, status: str, reason: str) -> None:
        """Write the layout, which shows the objects that have come."""
        self._write_layout()

    def run_ended(self) -> None:
        """Write the layout, which shows topics that have come, and close the file."""
        if self._layout is not None:
            self._write_layout()
        if self._images is not None:
            self._images.close()
        self._open.close()

    def _copy_poses(self) -> None:
        self._poses.append((self._cell.time, self._file.sequence, self._scene.copy_poses()))

    def _encode(self) -> None:
        """Add the messages of the copied states; called under the lock of the file.

        Encoding many at once takes half of the time of encoding each in its tick, between other
        code.
        """
        poses = self._poses[:]  # the thread of the run may add one meanwhile
        del self._poses[: len(poses)]
        if poses:
            times, numbers, copies = zip(*poses, strict=True)
            frames = self._scene.movable_frames([nanoseconds(time) for time in times], copies)
            self._file.add_all("/tf", np.array(times), frames, numbers)
        for robot in self._robots:
            robot.encode()

    @property
    def _now(self) -> int:
        return nanoseconds(self._cell.time)

    def _add_message(self, topic: str, message: Any) -> None:
        """Add a message of a registered source: a dict or a protobuf message."""
        if isinstance(message, dict):
            self._file.add_json(topic, self._now, message)
        else:
            self._file.add_topic(topic, type(message))
            self._file.add(topic, self._now, message.SerializeToString())

    def _draw_path(self, name: str, moving: bool, time: int) -> None:
        """Draw the planned path of the tool while a robot moves [ns]."""
        from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

        from bt_manip_recording.foxglove import path_line, removal

        topic, trajectory = f"{TOPICS['motion']}/{name}", self._station.robots[name].arm.trajectory
        self._file.add_topic(topic, SceneUpdate)
        if moving and trajectory is not None:
            points = tool_path(self._models[name], trajectory)
            self._file.add(topic, time, path_line(name, time, points))
        else:
            self._file.add(topic, time, removal())

    def _write_images(self) -> None:
        if self._images is not None:
            self._images.write(self._file, self._now)

    def _write_snapshot(self) -> None:
        self._snapshot_cycle, self._snapshot_time = self._run.cycle, self._cell.time
        self._file.add_json(SNAPSHOTS, self._now, take_snapshot(self._run))

    def _write_layout(self) -> None:
        """Write the layout beside the recording if it has changed."""
        from bt_manip_recording.foxglove_layout import foxglove_layout

        robots = {
            name: list(one.robot.description.arm_joints)
            for name, one in self._station.robots.items()
        }
        leaves = {link.uid: link.name for link in self._tree.nodes if not link.children}
        layout = foxglove_layout(robots, leaves, self._file.topics)
        if layout != self._layout and not is_special(self._path):
            self._layout = layout
            path = self._path.with_suffix(".layout.json")
            with suppress(OSError), whole_file(path, sync=False) as file:  # run and file go on
                file.write(json.dumps(layout, indent=1).encode())

    def _write_scene(self) -> None:
        """Write the geometry of entities that are new, or have new colours; delete the others."""
        from bt_manip_recording.foxglove import add_scene

        self._shown = add_scene(self._file, self._scene.scene, self._shown, self._now)


class RobotChannel:
    """Records one robot: joints at every control step, wrist and gripper at every tick.

    Args:
        file: The file.
        cell: The `bt_manip.cell.Cell`.
        commanded: The `bt_manip.runner.CommandedRobot`.
        log: Copies its control steps.
    """

    def __init__(self, file: "McapFile", cell: Any, commanded: Any, log: StepLog) -> None:
        from bt_manip_recording.protobuf import FREE, control_step_template

        self._file, self._cell, self._commanded = file, cell, commanded
        self._saturated_before = commanded.controller.saturated_steps
        self._joints = add_joints(file, commanded)
        self._state = f"/robots/{commanded.name}/state"
        file.add_topic(self._state)
        self._log = log
        log.readers.append(self._copy_steps)
        self._template, self._free = control_step_template(len(commanded.robot.limits.lower)), FREE
        self._copied: tuple[PendingSteps, int] = log.pending, 0  # how many of which
        self._steps = PendingSteps([], [], [])
        self._ticks: list[tuple[float, bytes, tuple[Any, ...]]] = []

    def bind(self) -> None:
        """Bind to the current model of the cell."""
        robot, data = self._commanded.robot, self._cell.data
        self._data = data
        body, site = robot.wrist_body_id, robot.tool_site_id
        root = self._cell.model.body_rootid[body]
        self._wrist: Any = (
            data.cfrc_int[body], data.subtree_com[root], data.site_xpos[site], data.site_xmat[site]
        )  # fmt: skip

    def end_tick(self, time: float) -> None:
        """Copy the state of wrist and gripper at a simulated time [s]."""
        commanded, gripper = self._commanded, self._commanded.gripper
        # A step leaves out cfrc_int where the model has no force sensor.
        mujoco.mj_rnePostConstraint(self._cell.model, self._data)
        held = () if gripper is None else gripper.held
        forces, gripped, saturated = live_state(self._cell, commanded)
        saturated -= self._saturated_before
        state = forces, held, gripped, saturated, commanded.arm.speed_scale
        self._ticks.append((time, b"".join(self._wrist), state))

    def _copy_steps(self, pending: PendingSteps) -> None:
        """Copy new pending steps of the log."""
        with self._file.lock:
            known, start = self._copied
            new = slice(start if known is pending else 0, len(pending.touches))
            self._copied = pending, new.stop
            self._steps.times.extend(pending.times[new])
            self._steps.rows.extend(pending.rows[new])
            self._steps.touches.extend(pending.touches[new])

    def encode(self) -> None:
        """Add the messages of the copied states."""
        self._copy_steps(self._log.pending)
        times, rows, touches = self._steps
        if times:
            numbers = np.frombuffer(b"".join(rows)).reshape(len(times), -1)
            messages = self._template.serialize(numbers)
            messages[:, self._free] = [touch.free for touch in touches]
            self._file.add_all(self._joints, np.array(times), messages)
            self._steps = PendingSteps([], [], [])
        ticks = self._ticks[:]
        del self._ticks[: len(ticks)]
        if not ticks:
            return
        wrenches = tool_wrenches(np.frombuffer(b"".join(wrist for _, wrist, _ in ticks)))
        texts = []
        for (_, _, (forces, held, gripped, *rest)), wrench in zip(ticks, wrenches, strict=True):
            grip = ",".join(["%.17g"] * len(forces)) % forces
            names = json.dumps(held), json.dumps(gripped)
            texts.append((STATE % (*wrench, grip, *names, *rest)).encode())
        self._file.add_all(self._state, np.array([time for time, _, _ in ticks]), texts)


def describe_run(file: "McapFile", run: Run) -> None:
    """Add what identifies a run, its tree, and the topics that all recordings have."""
    from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
    from foxglove_schemas_protobuf.Log_pb2 import Log

    request = run.request
    identity = {"tree": request.tree.name, "seed": request.seed, "versions": versions()}
    identity |= identify(run)
    file.add_metadata("run", {key: json.dumps(value) for key, value in identity.items()})
    file.add_metadata("date", {"started": datetime.now(UTC).isoformat(timespec="seconds")})
    file.add_metadata("tree", {"xml": instance_to_xml(run.tree)})
    for topic in ("/tf", "/tf_static"):
        file.add_topic(topic, FrameTransforms)
    file.add_topic("/log", Log)
    for topic in TOPICS.values():
        file.add_topic(topic)


def add_event(file: "McapFile", event: RunEvent) -> None:
    """Add an event, and its line in the log."""
    time, line = nanoseconds(event.time), log_line(event)
    file.add_json(TOPICS[event.kind], time, event.data)
    if line is not None:
        from bt_manip_recording.foxglove import log_message

        file.add("/log", time, log_message(time, line[0], event.kind, line[1]))


def add_joints(file: "McapFile", commanded: Any) -> str:
    """Add the topic of the control steps of a robot; return its name."""
    from bt_manip_recording.protobuf import control_step_class

    topic = f"/robots/{commanded.name}/joints"
    joints, limits = commanded.robot.description.arm_joints, commanded.robot.limits
    about = {"joints": list(joints), **limits.get_state()}
    file.add_topic(topic, control_step_class(), {k: json.dumps(v) for k, v in about.items()})
    return topic


def tool_wrenches(wrists: np.ndarray) -> list[list[float]]:
    """Return the wrench of the last link on the gripper at each tick, as `Robot.wrist_wrench`.

    Args:
        wrists: MuJoCo's ``cfrc_int``, ``subtree_com``, ``site_xpos`` and ``site_xmat``, flat.

    Returns:
        Force and torque in the tool frame of each tick [N, N m].
    """
    torque, force, com, tool, rotation = np.split(wrists.reshape(-1, 21), (3, 6, 9, 12), axis=1)
    torque = torque + np.cross(com - tool, force)
    R_wt = rotation.reshape(-1, 3, 3)
    in_tool = [np.einsum("nji,nj->ni", R_wt, vectors) for vectors in (force, torque)]
    return np.concatenate(in_tool, axis=1).tolist()


def nanoseconds(time: float) -> int:
    """Return a time [s] in nanoseconds, as MCAP counts it."""
    return round(time * 1e9)
