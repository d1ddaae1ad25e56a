"""Leaves for the user interface, messages, files and services of MoveIt Pro.

There is no such interface here: leaves that only show something do nothing, and approvals are
given.
"""

import logging
from pathlib import Path
from typing import Any, ClassVar

from bt_manip.behaviours import CellBehaviour
from bt_manip.bt import Input, Output, Status
from bt_manip.exceptions import BtManipError
from bt_manip.files import read_text
from bt_manip_moveit_pro.leaf import Leaf
from bt_manip_moveit_pro.values import PoseStamped

LOG = logging.getLogger("bt_manip.moveit_pro")
MAX_BYTES = 20_000_000
"""Largest file that is read."""


class VisualizePose(Leaf):
    """Succeed: poses are not shown."""

    ignored = "pose marker_name marker_size marker_lifetime marker_text"


class VisualizePath(Leaf):
    """Succeed: paths are not shown."""

    ignored = "path marker_name marker_lifetime pose_marker_size show_poses"


class VisualizeMesh(Leaf):
    """Succeed: meshes are not shown."""

    ignored = "mesh_path mesh_pose mesh_name marker_lifetime"


class PublishMarkers(Leaf):
    """Succeed: markers are not shown."""

    ignored = "marker_type marker_namespace marker_scale_xyz marker_poses"


class SwitchUIPrimaryView(Leaf):
    """Succeed: there are no views to switch."""

    ignored = "primary_view_name"


class ClearSnapshot(Leaf):
    """Succeed: motions are planned in the cell as it is, not in a snapshot of it."""


class LogMessage(Leaf):
    """Log a message."""

    LEVELS: ClassVar = {"debug": 10, "info": 20, "warn": 30, "warning": 30, "error": 40}
    log_level = Input(str, default="info", doc="debug, info, warn or error")
    message = Input(doc="the message")

    def run(self) -> None:
        """Log it, and keep it as feedback."""
        self.feedback_message = str(self.message)
        level = self.LEVELS.get(self.log_level.lower())
        if level is None:
            raise ValueError(f"the level of a message is one of {', '.join(self.LEVELS)}")
        LOG.log(level, "%s", self.feedback_message)


class BreakpointSubscriber(Leaf):
    """Succeed: use breakpoints of the page or of Groot2."""

    ignored = "breakpoint_topic message"


class IsUserAvailable(Leaf):
    """Fail: no user is asked; trees then skip their approvals."""

    def run(self) -> None:
        """Fail."""
        self.fail("no user is asked")


class WaitForUserPathApproval(Leaf):
    """Succeed: paths are approved."""

    ignored = "path"


class CreateStringMessage(Leaf):
    """Write a text."""

    data = Input(str, doc="the text")
    string = Output(str, doc="the text")

    def run(self) -> None:
        """Write it."""
        self.string = self.data


class UnpackStringMessage(Leaf):
    """Write a text."""

    string = Input(str, doc="the text")
    data = Output(str, doc="the text")

    def run(self) -> None:
        """Write it."""
        self.data = self.string


class PublishString(Leaf):
    """Log a text: there are no topics."""

    ignored = "queue_size use_best_effort"
    topic = Input(str, doc="name of the topic")
    message = Input(doc="the text")

    def run(self) -> None:
        """Log it."""
        LOG.info("%s: %s", self.topic, self.message)


class PublishEmpty(Leaf):
    """Succeed: there are no topics."""

    ignored = "topic queue_size use_best_effort"


class CallTriggerService(Leaf):
    """Succeed: force sensors and drives need no service here."""

    ignored = "service_name response_timeout wait_for_server_available_timeout"


class SwitchController(Leaf):
    """Succeed: a robot keeps the controller of the run.

    Trees of MoveIt Pro name controllers of ros2_control.
    """

    ignored = (
        "activate_controllers deactivate_controllers activate_asap automatic_activation "
        "automatic_deactivation controller_list_action_name controller_switch_action_name "
        "strictness timeout"
    )


class ListControllers(Leaf):
    """Write an empty list: controllers of ros2_control are not used."""

    ignored = "type state"
    controller_list = Output(doc="names of controllers")

    def run(self) -> None:
        """Write it."""
        self.controller_list = []


class SetAdmittanceParameters(Leaf):
    """Succeed: parameters of admittance controllers are not used."""

    ignored = "config_file_name"
    admittance_parameters_msg = Output(doc="an empty message")

    def run(self) -> None:
        """Write an empty message."""
        self.admittance_parameters_msg = {}


class ResetMujocoKeyframe(Leaf):
    """Succeed: a cycle begins with the scene as it is described."""

    ignored = "keyframe_name response_timeout wait_for_server_available_timeout"


class SetMujocoState(Leaf):
    """Fail: the state of the simulation is not set during a cycle."""

    def run(self) -> None:
        """Fail."""
        self.fail("the state of the simulation is not set during a cycle")


class WaitForDuration(CellBehaviour):
    """Wait, in simulated time."""

    delay_duration = Input(float, default=0.0, doc="how long", unit="s", at_least=0.0)

    def update(self) -> Status:
        """Wait until the time has passed."""
        over = self.elapsed >= self.delay_duration - 1e-9
        return Status.SUCCESS if over else Status.RUNNING


class StopwatchBegin(CellBehaviour):
    """Write the present simulated time."""

    timepoint = Output(float, doc="the time", unit="s")

    def update(self) -> Status:
        """Write it."""
        self.timepoint = self.cell.time
        return Status.SUCCESS


class StopwatchEnd(CellBehaviour):
    """Log the simulated time since another one."""

    timepoint = Input(float, doc="the time of the start", unit="s")

    def update(self) -> Status:
        """Log it."""
        self.feedback_message = f"{self.cell.time - self.timepoint:.3f} s"
        LOG.info("%s", self.feedback_message)
        return Status.SUCCESS


class BiasedCoinFlip(CellBehaviour):
    """Succeed at random, from the seed of the run."""

    success_probability = Input(float, default=0.5, doc="probability of success", at_least=0.0)

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell and the random generator."""
        super().setup(**infrastructure)
        self._rng = infrastructure["rng"]

    def update(self) -> Status:
        """Flip."""
        if self._rng.random() < self.success_probability:
            return Status.SUCCESS
        return self.fail("the coin fell on the other side")


# ---------------------------------------------------------------------- files


def path_of(name: str, suffix: str = "") -> Path:
    """Return the path of a file, relative to the current folder, ``~`` included."""
    path = Path(name).expanduser()
    return path if path.suffix or not suffix else path.with_suffix(suffix)


def read_messages(name: str) -> list[Any]:
    """Return the documents of a YAML file.

    Raises:
        ValueError: If it is not YAML.
        BtManipError: If it cannot be read.
    """
    import yaml

    path = path_of(name)
    try:
        return [m for m in yaml.safe_load_all(read_text(path, MAX_BYTES)) if m is not None]
    except OSError as error:
        raise BtManipError(f"{path}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise ValueError(f"{path} is not YAML: {error}") from None


class LoadPoseStampedVectorFromYaml(Leaf):
    """Read poses from a YAML file: PoseStamped messages, as documents or as one list."""

    file_path = Input(str, doc="path of the file, in the current folder")
    output = Output(doc="the poses")

    def run(self) -> None:
        """Read them."""
        documents = read_messages(self.file_path)
        if len(documents) == 1 and isinstance(documents[0], list):
            documents = documents[0]
        self.output = [PoseStamped.from_message(message) for message in documents]


class LoadPoseStampedFromYaml(Leaf):
    """Read a pose from a YAML file: a PoseStamped message."""

    file_path = Input(str, doc="path of the file, in the current folder")
    output = Output(doc="the pose")

    def run(self) -> None:
        """Read it."""
        documents = read_messages(self.file_path)
        if not documents:
            raise ValueError(f"{self.file_path} is empty")
        self.output = PoseStamped.from_message(documents[0])


class SavePoseStampedToYaml(Leaf):
    """Write a pose to a YAML file."""

    ignored = "namespace"
    message = Input(doc="the pose")
    yaml_filename = Input(str, doc="path of the file, in the current folder")
    overwrite = Input(bool, default=True, doc="whether a file is replaced; else it is continued")

    def run(self) -> None:
        """Write it."""
        import yaml

        pose = self.message
        if not isinstance(pose, PoseStamped):
            raise ValueError(f"a pose is expected, not {type(pose).__name__}")
        text = "---\n" + yaml.safe_dump(pose.as_message(), sort_keys=False)
        with path_of(self.yaml_filename, ".yaml").open("w" if self.overwrite else "a") as file:
            file.write(text)


class ReadTextFileAsString(Leaf):
    """Read a text file."""

    text_filename = Input(str, doc="path of the file, in the current folder")
    string_file_contents = Output(str, doc="its text")

    def run(self) -> None:
        """Read it."""
        self.string_file_contents = read_text(path_of(self.text_filename), MAX_BYTES)
