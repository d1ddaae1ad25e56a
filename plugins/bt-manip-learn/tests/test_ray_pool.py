"""Addresses of Ray clusters: each works, or is refused in time with the reason."""

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn import RayPool, ray_pool

ray_missing = shutil.which("ray", path=os.path.dirname(sys.executable)) is None
pytestmark = pytest.mark.skipif(ray_missing, reason="Ray is not installed")


def refused(address):
    with pytest.raises(BtManipError) as caught:
        RayPool(Doubler, address)
    return str(caught.value)


class Doubler:
    """A worker."""

    def run(self, episode):
        return 2 * episode


@pytest.mark.parametrize("address", ["localhost", "127.0.0.1:", "a:b", "ray://host:10001"])
def test_an_address_without_a_port_is_refused(address):
    assert (
        refused(address) == f"--ray is HOST:PORT, such as 127.0.0.1:6379, or auto, got '{address}'"
    )


def test_a_host_without_a_server_is_refused():
    assert "there is no cluster at HOST:PORT: [Errno 111]" in refused("127.0.0.1:1")
    assert "no-such-host.invalid:6379: there is no cluster" in refused("no-such-host.invalid:6379")


def test_auto_needs_an_address_in_the_environment_or_a_cluster_that_was_started(
    monkeypatch, tmp_path
):
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setenv("RAY_TMPDIR", str(tmp_path))
    assert "RAY_ADDRESS is not set, and no cluster was started here" in refused("auto")
    (tmp_path / "ray").mkdir()
    (tmp_path / "ray" / "ray_current_cluster").write_text("127.0.0.1:1\n")
    assert "--ray 127.0.0.1:1: there is no cluster" in refused("auto")
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:2")
    assert "--ray 127.0.0.1:2: there is no cluster" in refused("auto")


def test_a_server_that_is_no_cluster_is_refused_in_time(monkeypatch):
    monkeypatch.setattr(ray_pool, "CONNECTION_TIME", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        assert refused(address) == f"--ray {address}: no cluster answered within 1 s"


SCRIPT = """
import sys
from bt_manip.evaluation import run_episodes
from bt_manip_learn import RayPool
from test_ray_pool import Doubler
print(sorted(run_episodes(Doubler, [1, 2, 3], 2, pool=RayPool(Doubler, sys.argv[1]))))
"""


@pytest.mark.soak
@pytest.mark.parametrize("loopback", ["0", "1"])
def test_each_address_of_a_cluster_works(loopback, tmp_path):
    with socket.create_server(("", 0)) as server:
        port = server.getsockname()[1]
    folder = f"/tmp/ray-{port}"  # sockets in it have paths of 107 bytes at most
    env = {**os.environ, "RAY_TMPDIR": folder, "RAY_USAGE_STATS_ENABLED": "0"}
    command = [
        shutil.which("ray", path=os.path.dirname(sys.executable)), "start", "--head", "--block",
        f"--port={port}", "--num-cpus=2", "--object-store-memory=104857600",
        "--include-dashboard=false", "--min-worker-port=0", "--max-worker-port=0",
    ]  # fmt: skip
    started = {**env, "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": loopback}
    with open(tmp_path / "log", "w") as log:
        cluster = subprocess.Popen(command, env=started, stdout=log, stderr=subprocess.STDOUT)
    try:
        while "To terminate the Ray runtime" not in (tmp_path / "log").read_text():
            assert cluster.poll() is None, (tmp_path / "log").read_text()
            time.sleep(0.5)
        for address in (f"127.0.0.1:{port}", f"localhost:{port}", "auto"):
            done = subprocess.run(
                [sys.executable, "-c", SCRIPT, address], env=env, capture_output=True, text=True,
                timeout=120.0, cwd=Path(__file__).parent,
            )  # fmt: skip
            assert done.stdout == "[2, 4, 6]\n", (address, done.stderr)
    finally:
        cluster.terminate()
        cluster.wait(60.0)
        shutil.rmtree(folder, ignore_errors=True)
