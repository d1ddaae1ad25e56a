"""Models of MuJoCo Menagerie by address: from a folder, and from a server that may be wrong."""

import dataclasses
import hashlib
import io
import socket
import tarfile
import threading
import time
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.cell import Cell
from bt_manip.cell.objects import ModelObject
from bt_manip.models import ModelError, find_model
from bt_manip.robots.model_building import build_model
from bt_manip_contracts import verify

OTHERS = (
    "franka_emika_panda",
    "franka_fr3",
    "kuka_iiwa_14",
    "ufactory_xarm7",
    "universal_robots_ur5e",
)
PLAIN = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


@pytest.mark.parametrize(
    "name", ["robotiq_2f85", *(pytest.param(name, marks=pytest.mark.soak) for name in OTHERS)]
)
def test_a_model_stands_in_a_cell_and_pinocchio_agrees_with_mujoco(name, menagerie, monkeypatch):
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    found = find_model(f"menagerie:{name}")
    assert found.path.parent == menagerie / name
    cell = Cell()
    thing = ModelObject(f"menagerie:{name}")
    assert thing.free is False
    cell.add(thing, spatial.pose((0.2, -0.1, 1.0), (0.9, 0.1, 0.2, -0.3)))
    alone = mujoco.MjModel.from_xml_path(str(found.path))
    assert cell.model.nv == alone.nv
    assert cell.model.body_mass.sum() == pytest.approx(alone.body_mass.sum(), rel=1e-9)
    kinds = [int(kind) for kind in cell.model.jnt_type]
    assert set(kinds) <= set(PLAIN)
    joints = [cell.model.joint(i).name for i in range(cell.model.njnt)]
    model = build_model(cell.model, joints=joints)
    assert verify(cell.model, model, rng=np.random.default_rng(0), n=10).worst < 1e-9
    cell.step(100)
    assert np.abs(cell.data.qvel).max() < 10


def test_another_model_of_a_robot_and_a_wrong_name(menagerie, monkeypatch):
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    assert find_model("menagerie:franka_emika_panda/hand").path.name == "hand.xml"
    with pytest.raises(ModelError, match="did you mean 'franka_emika_panda'"):
        find_model("menagerie:franka_panda")
    with pytest.raises(ModelError, match="has no model 'handd'; did you mean 'hand'"):
        find_model("menagerie:franka_emika_panda/handd")
    with pytest.raises(ModelError, match="not found under MENAGERIE_ROOT"):
        find_model("menagerie:unitree_g1")


XML = b"<mujoco><worldbody><body><geom size='.1'/></body></worldbody></mujoco>"


def archive(name: str, file: str, content: bytes = XML) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:xz") as tar:
        info = tarfile.TarInfo(f"{name}/{file}")
        info.size = len(content)
        tar.addfile(info, io.BytesIO(content))
    return out.getvalue()


@pytest.fixture
def served(tmp_path: Path) -> Path:
    (tmp_path / "served").mkdir()
    return tmp_path / "served"


@pytest.fixture
def server(served: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ThreadingHTTPServer]:
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    handler = partial(SimpleHTTPRequestHandler, directory=str(served))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        yield server
        server.shutdown()


@pytest.fixture
def archived(server, served, tmp_path, monkeypatch):
    """Serve a model of which the installed package knows the checksum; give its archive."""
    import mujoco_menagerie

    known = mujoco_menagerie.get("kuka_iiwa_14")
    data = archive(known.name, known.entry(known.default_model).file)
    changed = dataclasses.replace(
        known, sha256=hashlib.sha256(data).hexdigest(), download_size=len(data)
    )
    registry = mujoco_menagerie.bundled()
    monkeypatch.setitem(registry.robots, known.name, changed)
    monkeypatch.setenv("MENAGERIE_BASE_URL", f"http://127.0.0.1:{server.server_port}")
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "menagerie"))
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)
    for variable in ("http_proxy", "HTTP_PROXY"):
        monkeypatch.delenv(variable, raising=False)
    (served / changed.asset).write_bytes(data)
    return served / changed.asset


def left(tmp_path) -> list[str]:
    """List what a refused download has left, but for the empty files that are locks."""
    files = (p for p in (tmp_path / "menagerie").rglob("*") if p.is_file())
    return [p.name for p in files if p.parent.name != "locks"]


def test_a_model_is_downloaded_checked_and_there_when_the_server_has_it_no_longer(archived):
    told = []
    found = find_model("menagerie:kuka_iiwa_14", lambda *state: told.append(state))
    assert found.path.read_bytes() == XML
    assert told[-1][1:] == (archived.stat().st_size,) * 2
    archived.unlink()
    assert find_model("menagerie:kuka_iiwa_14") == found


def test_a_wrong_checksum_or_no_model_on_the_server_is_refused_and_nothing_is_left(
    archived, tmp_path
):
    wrong = bytearray(archived.read_bytes())
    wrong[len(wrong) // 2] ^= 1
    archived.write_bytes(bytes(wrong))
    with pytest.raises(ModelError, match="does not match the digest"):
        find_model("menagerie:kuka_iiwa_14")
    assert left(tmp_path) == []
    archived.unlink()
    with pytest.raises(ModelError, match="404"):
        find_model("menagerie:kuka_iiwa_14")
    assert left(tmp_path) == []


@pytest.mark.parametrize("listens", [True, False])
def test_without_an_answer_it_fails_within_two_seconds_and_says_what_helps(
    archived, monkeypatch, listens
):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        if not listens:
            silent.close()
        monkeypatch.setenv("MENAGERIE_BASE_URL", f"http://{address}/assets")
        start = time.monotonic()
        with pytest.raises(ModelError, match=f"{address}.*; set MENAGERIE_ROOT to a folder"):
            find_model("menagerie:kuka_iiwa_14")
        assert time.monotonic() - start < 2.5
