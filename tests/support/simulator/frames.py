"""A camera of a simulator, which serves its frames as the README of bt-manip-camera describes.

It runs in the environment of a simulator, with NumPy and MuJoCo and nothing of this project.
"""

import contextlib
import multiprocessing
import select
import socket
import struct
import threading
import time

import mujoco
import numpy as np

NOISE, SMOOTH = 1.5e-3, 2e-3  # [m] at 0.65 m: of each pixel, and varying slowly over the image


def start_camera(model, data, in_physics, host, name, size):
    """Let a process of its own serve a frame to each client, and return its port.

    Args:
        model: The cell.
        data: Its state.
        in_physics: Calls a function between two steps, and returns its result.
        host: Address to serve at.
        name: Name of the camera in the model.
        size: Width and height [pixels].
    """
    processes = multiprocessing.get_context("spawn")
    here, there = processes.Pipe()
    arguments = there, model, host, name, size
    processes.Process(target=serve_frames, args=arguments, daemon=True).start()
    there.close()
    port = here.recv()

    def answer():
        while here.recv():
            here.send(in_physics(data.qpos.copy))

    threading.Thread(target=answer, daemon=True).start()
    return port


def serve_frames(physics, model, host, name, size):
    """Serve frames of the states that a connection gives, until it ends."""
    data, rng, (width, height) = mujoco.MjData(model), np.random.default_rng(0), size
    model.vis.quality.offsamples = 0  # slow without a graphics card, as shadows are
    renderer = mujoco.Renderer(model, height, width)
    focal_length = 0.5 * height / np.tan(0.5 * np.radians(model.camera(name).fovy[0]))
    server = socket.create_server((host, 0))
    physics.send(server.getsockname()[1])
    while physics not in select.select([server, physics], [], [])[0]:
        client, _ = server.accept()
        with client, contextlib.suppress(OSError):
            exposed = time.monotonic()
            physics.send(True)
            data.qpos[:] = physics.recv()
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, name)
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
            colour = renderer.render().copy()
            renderer.enable_depth_rendering()
            depth = with_noise(renderer.render(), rng)
            renderer.disable_depth_rendering()
            age = time.monotonic() - exposed
            client.sendall(struct.pack("<4sHHdd", b"BTF1", *size, focal_length, age))
            client.sendall(depth.astype("<f4").tobytes() + colour.tobytes())


def with_noise(depth, rng):
    """Return depths as of a real camera, 0 where they are unknown [m]."""
    height, width = depth.shape
    across, down = np.linspace(0.0, 4.0, width), np.linspace(0.0, 3.0, height)
    rows = np.array([np.interp(across, range(5), row) for row in rng.normal(size=(4, 5))])
    smooth = np.array([np.interp(down, range(4), column) for column in rows.T]).T
    error = NOISE * rng.normal(size=depth.shape) + SMOOTH * smooth
    return np.where(depth < 10.0, np.maximum(depth + (depth / 0.65) ** 2 * error, 0.0), 0.0)
