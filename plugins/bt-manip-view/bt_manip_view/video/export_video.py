"""Videos rendered from a recording."""

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from bt_manip.cell import WORLD, Arena, FrameRenderer, camera_number
from bt_manip_recording import PLANE_THICKNESS

from .video_recorder import PIXEL_SAMPLES, SHADOW_SIZE, VideoFile, check_video, overlay_text

if TYPE_CHECKING:
    from bt_manip_recording import RecordedScene, Recording

SAME_TIME = 1e-9
"""Largest difference of equal times [s]."""

GEOM_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}


class SceneModel:
    """A model of MuJoCo that shows a recorded scene; floor, sky and lights are the arena's.

    Each frame is a mocap body. Shapes of entities that are not there, or have another appearance
    now, are transparent.
    """

    def __init__(self, scene: "RecordedScene") -> None:
        self._scene = scene
        spec = mujoco.MjSpec.from_string(Arena().mjcf_model.to_xml_string())
        for camera in spec.cameras:
            spec.delete(camera)
        # Without their names, since one of them is "world", too.
        bodies = {name: spec.worldbody.add_body(mocap=True) for name in scene.frames}
        geoms: dict[tuple[str, int], list[mujoco.MjsGeom]] = {}  # by entity and its appearance
        for time in scene.times.tolist():
            scene.seek(time)
            for one in scene.cameras:
                if spec.camera(one.name) is None:
                    bodies[one.frame].add_camera(
                        name=one.name, pos=one.position, quat=one.quat_wxyz, fovy=one.fovy
                    )
            for appearance in scene.entities().items():
                if appearance not in geoms:
                    geoms[appearance] = self._add(spec, bodies, appearance[0])
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._geoms = {appearance: [one.id for one in some] for appearance, some in geoms.items()}
        self._alpha = self.model.geom_rgba[:, 3].copy()

    def update(self) -> None:
        """Take over the present state of the scene."""
        poses, present = self._scene.poses(), self._scene.entities()
        self.data.mocap_pos[:], self.data.mocap_quat[:] = poses[:, :3], poses[:, 3:]
        for (entity, number), geoms in self._geoms.items():
            shown = present.get(entity) == number
            self.model.geom_rgba[geoms, 3] = self._alpha[geoms] if shown else 0.0

    def _add(
        self, spec: mujoco.MjSpec, bodies: dict[str, mujoco.MjsBody], entity: str
    ) -> list[mujoco.MjsGeom]:
        """Add the present shapes of an entity."""
        added = []
        for frame, shapes in self._scene.shapes(entity).items():
            for shape in shapes:
                if entity == WORLD and shape.size[2] == PLANE_THICKNESS:
                    continue  # the arena has a floor, with its texture
                geom = bodies[frame].add_geom(
                    type=GEOM_TYPES[shape.kind],
                    pos=shape.position,
                    quat=shape.quat_wxyz,
                    rgba=shape.rgba,
                    contype=0,
                    conaffinity=0,
                )
                if shape.triangles is None:
                    x, y, z = np.array(shape.size) / 2.0
                    geom.size = (x, z, 0.0) if shape.kind == "cylinder" else (x, y, z)
                else:
                    geom.meshname = f"mesh {len(spec.meshes)}"
                    spec.add_mesh(
                        name=geom.meshname,
                        uservert=shape.triangles.vertices.ravel(),
                        userface=shape.triangles.faces.ravel(),
                        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # they may be flat
                    )
                added.append(geom)
        return added


def write_video(
    recording: "Recording",
    path: Path,
    *,
    camera: str = "overview",
    size: str = "1280x720",
    fps: float = 25.0,
    overlay: bool = True,
) -> None:
    """Render a recording to a video; each frame is the state after a tick, at its time.

    Args:
        recording: The recording.
        path: The file: ``.mp4`` or ``.gif``.
        camera: Full name of a recorded camera.
        size: Width and height [pixels], both even in a ``.mp4``.
        fps: Frames per simulated second; at most one for each tick is written.
        overlay: Whether to show the time and the running leaves.

    Raises:
        BtManipError: If something of this is impossible, or the video cannot be written.
    """
    from bt_manip_recording import RecordedScene, running_leaves  # slow, and plugins load this

    _, extent = check_video(path, size, fps)
    scene = RecordedScene(recording)
    with recording.decoding():
        shown = SceneModel(scene)
    number = camera_number(shown.model, camera)
    times = frame_times(scene.times, fps)
    running = running_leaves(recording, times)
    renderer = FrameRenderer(shown.model, *extent, shadow_size=SHADOW_SIZE, samples=PIXEL_SAMPLES)
    with closing(renderer), closing(VideoFile(path, *extent, fps)) as video:
        for time, leaves in zip(times.tolist(), running, strict=True):
            scene.seek(time)
            shown.update()
            text = overlay_text(time, [leaf.name for leaf in leaves]) if overlay else ""
            video.add(time - scene.times[0], renderer.frame(shown.data, number, text))


def frame_times(times: np.ndarray, fps: float) -> np.ndarray:
    """Return the times of the shown ticks [s]: the last tick before each frame is due."""
    # times: (n,); returned: (m,)
    elapsed = times - times[0]
    first = np.ceil((elapsed - SAME_TIME) * fps)  # number of the first frame that may show a tick
    return times[np.diff(first, append=np.floor(elapsed[-1] * fps + 1e-6) + 1.0) > 0.0]
