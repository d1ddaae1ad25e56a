"""The ticks of a recording, in memory."""

import numpy as np

from bt_manip.runner import RunEvent
from bt_manip_recording.mcap_recorder import TOPICS
from bt_manip_recording.protobuf import control_step_class
from bt_manip_recording.recorded_scene import SAME_TIME, RecordedScene
from bt_manip_recording.recording import Recording


class Timeline:
    """The states of a recorded run between its ticks, for a viewer that shows any of them.

    State 0 is that before the first tick, state i that after the i-th tick. Each state follows from
    the previous one by events, as an `EventStream` emits them during the run.

    Attributes:
        scene: The scene; its `index` is that of a state.
        times: Simulated time of each state [s].

    Raises:
        BtManipError: If the recording has no complete chunk.
    """

    def __init__(self, recording: Recording) -> None:
        self.scene = RecordedScene(recording)
        self.times, ticks = self.scene.times, self.scene.ticks
        kinds = {topic: kind for kind, topic in TOPICS.items()}
        joints = {f"/robots/{robot}/joints": robot for robot in recording.joints}
        index = {round(time * 1e9): i for i, time in enumerate(self.times.tolist())}
        parse = control_step_class().FromString
        shapes = {robot: (len(self.times), 2, len(n)) for robot, n in recording.joints.items()}
        self._joints = {robot: np.full(shape, np.nan) for robot, shape in shapes.items()}
        self._events: list[RunEvent] = []
        numbers: list[int] = []  # ticks that had begun before each event
        topics = [topic for topic in (*kinds, *joints) if topic in recording.topics]
        with recording.decoding():
            for number, time, topic, data in recording.numbered_messages(*topics):
                if topic in kinds:
                    self._events.append(RunEvent(time, kinds[topic], data))
                    numbers.append(number)
                elif (i := index.get(round(time * 1e9))) is not None:
                    step = parse(data)
                    self._joints[joints[topic]][i] = step.q, step.q_ref
        self._ends: list[int] = []  # number of events before each state
        end = 0
        for time, tick in zip(self.times.tolist(), ticks.tolist(), strict=True):
            # While the arms of an interrupted run stop, time goes on without ticks.
            while (
                end < len(numbers)
                and numbers[end] <= tick
                and self._events[end].time <= time + SAME_TIME
            ):
                end += 1
            self._ends.append(end)

    def events(self, before: int, index: int) -> list[RunEvent]:
        """Return the events that lead from a state to a later one.

        Args:
            before: Number of the earlier state; -1 is before all events.
            index: Number of the later state.
        """
        return self._events[self._ends[before] if before >= 0 else 0 : self._ends[index]]

    def joints(
        self, first: int, end: int
    ) -> tuple[np.ndarray, dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Return the joints of each robot in the states from ``first`` to before ``end``.

        In state 0 they are NaN: joints are recorded after control steps.

        Returns:
            Simulated times [s], and positions and references by robot [rad].
        """  # (n,), (n, nq) each
        rows = {robot: table[first:end] for robot, table in self._joints.items()}
        return self.scene.times[first:end], {n: (r[:, 0], r[:, 1]) for n, r in rows.items()}
