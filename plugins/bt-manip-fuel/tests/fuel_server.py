"""A Fuel server of our own on the loopback address, and models for it."""

import io
import json
import threading
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import unquote, urlsplit

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.models import bundled_path, load_model

CONFIG = """<?xml version="1.0"?>
<model><name>{name}</name><version>1</version>
  <sdf version="1.4">older.sdf</sdf><sdf version="1.10">model.sdf</sdf></model>
"""


@dataclass
class Answer:
    """What the server says to one address."""

    body: bytes = b""
    status: int = 200
    kind: str = "application/zip"
    headers: Mapping[str, str] = field(default_factory=dict)
    announced: int | None = None  # bytes, where that is a lie


class FuelServer:
    """Answers as Gazebo's server does, and as one does that means harm."""

    def __init__(self) -> None:
        self.answers: dict[str, Answer | Callable[[], Answer]] = {}
        self.requests: list[tuple[str, dict[str, str]]] = []
        server = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                path = unquote(urlsplit(self.path).path)
                server.requests.append((path, {k.lower(): v for k, v in self.headers.items()}))
                answer = server.answers.get(path, Answer(status=404, body=b"{}"))
                answer = answer() if callable(answer) else answer
                length = len(answer.body) if answer.announced is None else answer.announced
                self.send_response(answer.status)
                self.send_header("Content-Type", answer.kind)
                self.send_header("Content-Length", str(length))
                for key, value in answer.headers.items():
                    self.send_header(key, value)
                self.end_headers()
                self.wfile.write(answer.body)

            def log_message(self, *_: object) -> None:
                pass

        self.http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.http.server_port}"
        self._thread = threading.Thread(
            target=self.http.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True
        )
        self._thread.start()

    def add(self, owner: str, name: str, data: bytes, version: int = 1) -> None:
        """Keep a version of a model, which is then the newest."""
        base = f"/1.0/{owner}/models/{name}"
        details = json.dumps({"name": name, "owner": owner, "version": version}).encode()
        self.answers[base] = Answer(details, kind="application/json")
        answer = Answer(data, headers={"X-Ign-Resource-Version": str(version)})
        self.answers[f"{base}/tip/{name}.zip"] = answer
        self.answers[f"{base}/{version}/{name}.zip"] = answer

    def says(self, answer: Answer | Callable[[], Answer], name: str = "thing") -> None:
        """Answer so when the model ``someone/thing`` is asked for."""
        self.answers[f"/1.0/someone/models/{name}/tip/{name}.zip"] = answer

    def stop(self) -> None:
        self.http.shutdown()
        self.http.server_close()
        self._thread.join()


def compiled(address: str, **options: str) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """Return a compiled model, and the warnings but those of missing masses."""
    made = load_model(address, **options)
    warnings = tuple(text for text in made.warnings if "default is 1 kg" not in text)
    return mujoco.MjModel.from_xml_string(made.xml, dict(made.assets)), warnings


def zip_of(files: Mapping[str, str | bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def model_zip(sdf: str, name: str = "thing", **files: str | bytes) -> bytes:
    """Make the zip of a model as Fuel has it."""
    return zip_of({"model.config": CONFIG.format(name=name), "model.sdf": sdf, **files})


BALL = """<sdf version="1.10"><model name="ball"><link name="link">
<collision name="c"><geometry><sphere><radius>0.02</radius></sphere></geometry></collision>
</link></model></sdf>"""


def bundled_sdf(name: str, *, static: bool, raised: float = 0.0) -> str:
    """Write one of the project's own models in SDF, from what MuJoCo makes of it.

    Args:
        name: The bundled model, of one body.
        static: Whether it says that it does not move.
        raised: How far its link is above the model's origin [m].
    """
    model = mujoco.MjModel.from_xml_path(str(bundled_path(f"{name}/{name}.xml")))
    body = 1
    T = _pose(model.body_ipos[body], model.body_iquat[body])
    ixx, iyy, izz = model.body_inertia[body].tolist()
    parts = [
        f"<inertial><pose>{T}</pose><mass>{model.body_mass[body]:.12g}</mass><inertia>"
        f"<ixx>{ixx:.12g}</ixx><iyy>{iyy:.12g}</iyy><izz>{izz:.12g}</izz></inertia></inertial>"
    ]
    for geom in np.flatnonzero(model.geom_contype):
        size = model.geom_size[geom]
        if model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_BOX):
            x, y, z = (2 * size).tolist()
            shape = f"<box><size>{x:.12g} {y:.12g} {z:.12g}</size></box>"
        else:
            assert model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_CAPSULE)
            r, length = float(size[0]), float(2 * size[1])
            shape = f"<capsule><radius>{r:.12g}</radius><length>{length:.12g}</length></capsule>"
        place = _pose(model.geom_pos[geom], model.geom_quat[geom])
        inside = f"<pose>{place}</pose><geometry>{shape}</geometry>"
        mu = model.geom_friction[geom, 0]
        surface = f"<surface><friction><ode><mu>{mu:.12g}</mu></ode></friction></surface>"
        parts.append(f"<collision name='c{geom}'>{inside}{surface}</collision>")
        parts.append(f"<visual name='v{geom}'>{inside}</visual>")
    return (
        f"<sdf version='1.10'><model name='{name}'><static>{str(static).lower()}</static>"
        f"<link name='link'><pose>0 0 {raised} 0 0 0</pose>{''.join(parts)}</link></model></sdf>"
    )


def _pose(position: np.ndarray, quat_wxyz: np.ndarray) -> str:
    w, x, y, z = quat_wxyz.tolist()
    rpy = pin.rpy.matrixToRpy(pin.Quaternion(w, x, y, z).matrix())
    return " ".join(f"{c:.12g}" for c in (*position, *rpy))
