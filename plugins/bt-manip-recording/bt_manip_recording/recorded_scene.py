"""The recorded scene at a time."""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from bt_manip.exceptions import BtManipError
from bt_manip_recording.foxglove import shapes_of
from bt_manip_recording.mcap_recorder import CAMERAS
from bt_manip_recording.recording import Recording
from bt_manip_recording.visuals import SceneCamera, VisualShape

SCENE_TOPICS = "/scene/"
"""Beginning of the topics of entities."""

SAME_TIME = 1e-9
"""Times closer than this are the same [s]: recorded times are whole nanoseconds."""


class RecordedScene:
    """The scene of a recording after the last tick that ended at or before a time.

    It is a `bt_manip_recording.SceneSource`. `seek` moves it to another time, forwards or
    backwards, in less than a millisecond; then `entities` tells which entities are there, and
    `poses` where their bodies are. All frames that ever occur are in `frames`, so what is derived
    from it (the bodies of an `mujoco.MjSpec`, the nodes of a viewer) can be made once::

        scene = RecordedScene(Recording("run.mcap"))
        for time in np.arange(scene.times[0], scene.times[-1], 1 / 25):
            scene.seek(time)
            poses = dict(zip(scene.frames, scene.poses(), strict=True))
            present = scene.entities()

    Attributes:
        times: Start of the run, and the times at which its ticks ended [s].
        ticks: Number of ticks that had begun at these times.
        frames: Names of the frames of all bodies with a visible shape or a camera, or fixed.
        index: The present index of `times`.

    Raises:
        BtManipError: If the recording has no complete chunk.
    """

    def __init__(self, recording: Recording) -> None:
        self._poses: list[bytes] = []
        self._appearances: dict[str, list[tuple[int, SceneUpdate]]] = {}
        self._shapes: dict[tuple[str, int], dict[str, list[VisualShape]]] = {}
        self._views: list[tuple[int, Any]] = []  # ticks; cameras, centre and extent
        topics = [
            t for t in recording.topics if t.startswith((SCENE_TOPICS, "/tf")) or t == CAMERAS
        ]
        times, ticks, frames = [], [], {"world": None}
        fixed: list[tuple[int, FrameTransforms]] = []
        with recording.decoding():
            for tick, time, topic, data in recording.numbered_messages(*topics):
                if topic == "/tf":
                    times.append(time)
                    ticks.append(tick)
                    self._poses.append(data)
                    continue
                if topic == "/tf_static":
                    fixed.append((tick, FrameTransforms.FromString(data)))
                    names = [one.child_frame_id for one in fixed[-1][1].transforms]
                elif topic == CAMERAS:
                    cameras = [_camera(**one) for one in data["cameras"]]
                    self._views.append((tick, (cameras, data["centre"], data["extent"])))
                    names = [one.frame for one in cameras]
                else:
                    update = SceneUpdate.FromString(data)
                    self._appearances.setdefault(topic.removeprefix(SCENE_TOPICS), []).append(
                        (tick, update)
                    )
                    names = [one.frame_id for one in update.entities]
                frames.update(dict.fromkeys(names))
        if not (times and fixed and self._views):
            raise BtManipError(f"{recording.path} has no complete chunk: it has no scene")
        self.frames: Sequence[str] = tuple(frames)
        self.times, self.ticks = np.array(times), np.array(ticks)
        self._numbers = {name: number for number, name in enumerate(frames)}
        none = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (len(frames), 1))
        self._fixed = [(tick, self._place(message, none.copy())) for tick, message in fixed]
        self._recording = recording
        self.index = 0

    @property
    def time(self) -> float:
        """The time of the shown frame [s]."""
        return float(self.times[self.index])

    def seek(self, time: float) -> None:
        """Go to the end of the last tick that ended at or before a time [s]."""
        after = int(np.searchsorted(self.times, time + SAME_TIME, side="right"))
        self.index = max(after - 1, 0)

    @property
    def cameras(self) -> list[SceneCamera]:
        """The cameras of the cell at this time."""
        return self._latest(self._views)[0]

    @property
    def centre(self) -> np.ndarray:
        """Centre of the cell [m]."""  # (3,)
        return np.array(self._latest(self._views)[1])

    @property
    def extent(self) -> float:
        """Size of the cell [m]."""
        return float(self._latest(self._views)[2])

    def entities(self) -> dict[str, int]:
        """Return the present entities, with the number of changes of their appearance."""
        found = {name: self._number(updates) for name, updates in self._appearances.items()}
        return {
            n: i for n, i in found.items() if i >= 0 and not self._appearances[n][i][1].deletions
        }

    def shapes(self, entity: str) -> dict[str, list[VisualShape]]:
        """Return the visible shapes of a present entity, by the frame of their body."""
        key = entity, self.entities()[entity]
        if key not in self._shapes:
            with self._recording.decoding():
                self._shapes[key] = shapes_of(self._appearances[entity][key[1]][1])
        return self._shapes[key]

    def poses(self) -> np.ndarray:
        """Return the poses of all frames; absent frames have an old pose, or none."""
        with self._recording.decoding():
            message = FrameTransforms.FromString(self._poses[self.index])
        return self._place(message, self._latest(self._fixed).copy())

    def _number(self, changes: Sequence[tuple[int, Any]]) -> int:
        """Return the index of the last change so far; -1 if there is none."""
        return bisect_right(changes, int(self.ticks[self.index]), key=lambda one: one[0]) - 1

    def _latest(self, changes: Sequence[tuple[int, Any]]) -> Any:
        return changes[max(self._number(changes), 0)][1]

    def _place(self, message: FrameTransforms, poses: np.ndarray) -> np.ndarray:
        for one in message.transforms:
            number = self._numbers.get(one.child_frame_id)
            if number is not None:
                p, q = one.translation, one.rotation
                poses[number] = p.x, p.y, p.z, q.w, q.x, q.y, q.z
        return poses


def _camera(position: Sequence[float], quat_wxyz: Sequence[float], **fields: Any) -> SceneCamera:
    return SceneCamera(position=np.array(position), quat_wxyz=np.array(quat_wxyz), **fields)
