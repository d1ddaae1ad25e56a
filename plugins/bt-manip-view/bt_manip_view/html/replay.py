"""3D replay of a recorded run, in viser's player as one HTML page."""

from typing import Any

import numpy as np

from bt_manip_recording import RecordedScene, Recording, running_leaves
from bt_manip_view.page.framing import view_axes
from bt_manip_view.page.scene import SceneView
from bt_manip_view.page.server import close_server, open_server

RATE = 20.0
"""Poses per second of simulated time in a replay."""

MAX_REPLAY_POSES = 1200
"""Largest number of poses in a replay, enough for 60 s; longer runs have fewer per second."""

LABEL_HEIGHT = 0.9
"""Height of the label over the centre of the image; 1 is the upper edge."""


def replay_html(recording: Recording) -> tuple[str, float]:
    """Return the replay of a recording as HTML, and its start time [s]."""
    scene = RecordedScene(recording)
    first, last = float(scene.times[0]), float(scene.times[-1])
    duration = last - first
    rate = min(RATE, MAX_REPLAY_POSES / max(duration, 1e-9))
    server = open_server(0)
    try:
        view = SceneView(server)
        view.bind(scene)
        label = server.scene.add_label(
            "/running", "", position=_top(server.initial_camera), anchor="top-center",
            font_screen_scale=1.3,
        )  # fmt: skip
        serializer = server.get_scene_serializer()
        shown = scene.entities()
        times = np.linspace(first, last, max(2, round(duration * rate) + 1)).tolist()
        running = running_leaves(recording, times)
        for before, time, leaves in zip([first, *times], times, running, strict=False):
            serializer.insert_sleep(time - before)
            scene.seek(time)
            if (present := scene.entities()) != shown:
                shown = present
                view.bind(scene)
            else:
                view.update()
            label.text = f"{time:.2f} s  {', '.join(leaf.name for leaf in leaves)}"
        return serializer.as_html(), first
    finally:
        close_server(server)


def _top(camera: Any) -> np.ndarray:
    """Return the point at the top of a camera's image, at the depth of its centre [m]."""
    up = view_axes(np.subtract(camera.look_at, camera.position))[:, 1]
    return camera.look_at + LABEL_HEIGHT * np.tan(camera.fov / 2.0) * up
