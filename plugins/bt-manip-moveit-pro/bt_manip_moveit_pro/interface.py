"""Leaves for messages, files, services and the time.

MoveIt Pro's user interface is missing here: leaves that ask a user fail.
"""

import logging
from pathlib import Path
from typing import Any

from bt_manip.behaviours import CellBehaviour
from bt_manip.bt import Input, Output, Status
from bt_manip.files import read_text
from bt_manip_moveit_pro.leaf import Leaf
from bt_manip_moveit_pro.values import PoseStamped, expect

LOG = logging.getLogger("bt_manip.moveit_pro")
MAX_BYTES = 20_000_000
"""Largest file that is read."""


class LogMessage(Leaf):
    """Log a message, and keep it as feedback."""

    log_level = Input(str, default="info", doc="debug, info, warn or error")
    message = Input(doc="the message")

    def _run(self) -> None:
        level = logging.getLevelNamesMapping().get(self.log_level.upper())
        if level is None:
            raise ValueError("the level of a message is one of debug, info, warn, error")
        self.feedback_message = str(self.message)
        LOG.log(level, "%s", self.feedback_message)


class IsUserAvailable(Leaf):
    """Fail: no user is asked; trees then skip their approvals."""

    def _run(self) -> None:
        self.fail("no user is asked")


class CreateStringMessage(Leaf):
    """Write a text."""

    data = Input(str, doc="the text")
    string = Output(str, doc="the text")

    def _run(self) -> None:
        self.string = self.data


class UnpackStringMessage(Leaf):
    """Write a text."""

    string = Input(str, doc="the text")
    data = Output(str, doc="the text")

    def _run(self) -> None:
        self.data = self.string


class PublishString(Leaf):
    """Log a text: there are no topics."""

    ignored = "queue_size use_best_effort"
    topic = Input(str, doc="name of the topic")
    message = Input(doc="the text")

    def _run(self) -> None:
        LOG.info("%s: %s", self.topic, self.message)


class ListControllers(Leaf):
    """Write an empty list: controllers of ros2_control are not used."""

    ignored = "type state"
    controller_list = Output(doc="names of controllers")

    def _run(self) -> None:
        self.controller_list = []


class SetAdmittanceParameters(Leaf):
    """Write an empty message: parameters of admittance controllers are not used."""

    ignored = "config_file_name"
    admittance_parameters_msg = Output(doc="an empty message")

    def _run(self) -> None:
        self.admittance_parameters_msg = {}


class SetMujocoState(Leaf):
    """Fail: the state of the simulation is not set during a cycle."""

    def _run(self) -> None:
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


def read_messages(name: str) -> list[Any]:
    """Return the documents of a YAML file.

    Raises:
        ValueError: If it is not YAML.
        OSError: If it cannot be read.
    """
    import yaml

    try:
        documents = yaml.safe_load_all(read_text(Path(name).expanduser(), MAX_BYTES))
        return [message for message in documents if message is not None]
    except yaml.YAMLError as error:
        raise ValueError(f"{name} is not YAML: {error}") from None


class LoadPoseStampedVectorFromYaml(Leaf):
    """Read poses from a YAML file: PoseStamped messages, as documents or as one list."""

    file_path = Input(str, doc="path of the file, in the current folder")
    output = Output(doc="the poses")

    def _run(self) -> None:
        documents = read_messages(self.file_path)
        if len(documents) == 1 and isinstance(documents[0], list):
            documents = documents[0]
        self.output = [PoseStamped.from_message(message) for message in documents]


class LoadPoseStampedFromYaml(Leaf):
    """Read a pose from a YAML file: a PoseStamped message."""

    file_path = Input(str, doc="path of the file, in the current folder")
    output = Output(doc="the pose")

    def _run(self) -> None:
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

    def _run(self) -> None:
        import yaml

        message = expect(self.message, PoseStamped).as_message()
        path = Path(self.yaml_filename).expanduser()
        path = path if path.suffix else path.with_suffix(".yaml")
        with path.open("w" if self.overwrite else "a") as file:
            file.write("---\n" + yaml.safe_dump(message, sort_keys=False))


class ReadTextFileAsString(Leaf):
    """Read a text file."""

    text_filename = Input(str, doc="path of the file, in the current folder")
    string_file_contents = Output(str, doc="its text")

    def _run(self) -> None:
        path = Path(self.text_filename).expanduser()
        self.string_file_contents = read_text(path, MAX_BYTES)
