"""Fetching from Fuel: by name, version and referral, from the cache, and two at once."""

import shutil
import ssl
import subprocess
import sys
import threading

import pytest

from bt_manip.models import ModelError, load_model
from bt_manip.models import find_model as find_any_model
from bt_manip_fuel.fuel.address import FuelAddress, fuel_address
from bt_manip_fuel.fuel.client import fetch_model, find_model

from .fuel_server import BALL, Answer, FuelServer, model_zip


def test_an_address_says_owner_name_and_version():
    gazebo = "https://fuel.gazebosim.org"
    table = FuelAddress(gazebo, "OpenRobotics", "Table")
    assert fuel_address("fuel:OpenRobotics/Table") == table
    assert fuel_address("fuel:OpenRobotics/Table/tip") == table
    assert fuel_address("fuel:OpenRobotics/Table/3") == table.at(3)
    assert fuel_address(f"{gazebo}/OpenRobotics/models/Table") == table
    assert fuel_address(f"{gazebo}/1.0/OpenRobotics/models/Table/3") == table.at(3)
    spaces = fuel_address(f"{gazebo}/1.0/openrobotics/models/wood%20cube%205cm")
    assert spaces.name == "wood cube 5cm"
    assert spaces.zip_url.endswith("/models/wood%20cube%205cm/tip/wood%20cube%205cm.zip?link=true")
    assert str(table.at(3)) == "fuel:OpenRobotics/Table/3"


@pytest.mark.parametrize(
    "text",
    [
        "fuel:Table", "fuel:a/b/c/d", "fuel:a/b/0", "fuel:a/b/latest", "fuel:../b", "fuel:a/..",
        "fuel:a/%2e%2e", "fuel:a/b%2fc", "fuel:a/b%00c", "fuel:/", "fuel:a/ ",
        "https://fuel.gazebosim.org/OpenRobotics/worlds/Empty", "http://example.com/a/models/b",
    ],
)  # fmt: skip
def test_what_is_no_address_is_refused_before_anything_is_asked(text):
    with pytest.raises(ModelError):
        fuel_address(text)


def test_a_model_is_fetched_by_name_and_lies_where_gazebo_looks(server, cache, monkeypatch):
    monkeypatch.setenv("BT_MANIP_FUEL_TOKEN", "secret")
    server.add("OpenRobotics", "Wood Ball", model_zip(BALL), version=3)
    found = find_any_model("fuel:OpenRobotics/Wood Ball")
    host = server.url.removeprefix("http://").replace(":", "_")
    folder = cache.root / host / "openrobotics" / "models" / "wood ball" / "3"
    assert found.path == folder / "model.sdf"
    assert found.address == "fuel:OpenRobotics/Wood Ball/3"
    assert found.name == "Wood_Ball"
    assert server.requests[0][1]["private-token"] == "secret"
    assert {p.name for p in cache.root.iterdir()} == {host}


def test_a_model_is_fetched_by_version_and_the_highest_here_is_the_newest(server, cache):
    for version in (2, 10):
        server.add("someone", "thing", model_zip(BALL), version=version)
    thing = fuel_address("fuel:someone/thing")
    for version in (2, 10):
        address, folder = find_model(thing.at(version))
        assert (address.version, folder.name) == (version, str(version))
    assert [address.version for address in cache.models()] == [2, 10]
    asked = len(server.requests)
    assert find_model(thing)[0].version == 10
    assert len(server.requests) == asked


def test_a_newer_version_is_fetched_when_asked_for_and_only_then(server):
    thing = fuel_address("fuel:someone/thing")
    server.add("someone", "thing", model_zip(BALL), version=1)
    fetch_model(thing)
    told = []
    fetch_model(thing, lambda *state: told.append(state))  # the server states version 1 again
    assert told == []
    server.add("someone", "thing", model_zip(BALL), version=2)
    assert find_model(thing)[0].version == 1
    assert fetch_model(thing)[0].version == 2


def test_a_server_that_sends_no_version_has_sent_the_first_or_the_asked_one(server):
    server.says(Answer(model_zip(BALL)))
    assert find_model(fuel_address("fuel:someone/thing"))[0].version == 1
    server.answers["/1.0/someone/models/thing/7/thing.zip"] = Answer(model_zip(BALL))
    assert find_model(fuel_address("fuel:someone/thing/7"))[0].version == 7


def test_a_referral_is_followed_and_the_token_stays_with_its_server(
    server, other_server, monkeypatch
):
    monkeypatch.setenv("BT_MANIP_FUEL_TOKEN", "secret")
    other_server.answers["/bucket/x.zip"] = Answer(model_zip(BALL), kind="binary/octet-stream")
    link = f"{other_server.url}/bucket/x.zip?signed=1"
    headers = {"X-Ign-Resource-Version": "4"}
    server.says(Answer(f"{link}\n".encode(), kind="text/plain; charset=utf-8", headers=headers))
    assert find_model(fuel_address("fuel:someone/thing"))[0].version == 4
    assert server.requests[0][1]["private-token"] == "secret"
    assert "private-token" not in other_server.requests[0][1]


def test_a_redirect_is_followed_without_the_token_to_other_servers(
    server, other_server, monkeypatch
):
    monkeypatch.setenv("BT_MANIP_FUEL_TOKEN", "secret")
    other_server.answers["/x.zip"] = Answer(data := model_zip(BALL))
    server.says(Answer(status=302, headers={"Location": f"{other_server.url}/x.zip"}))
    told = []
    find_model(fuel_address("fuel:someone/thing"), lambda *state: told.append(state))
    assert "private-token" not in other_server.requests[0][1]
    assert told[-1] == ("thing", len(data), len(data))


def test_everything_works_again_when_the_server_is_gone(server):
    server.add("someone", "thing", model_zip(BALL))
    before = load_model("fuel:someone/thing")
    server.stop()
    server.stop = lambda: None  # the fixture would stop it again
    assert load_model("fuel:someone/thing") == before
    with pytest.raises(ModelError, match="no connection"):
        load_model("fuel:someone/else")


def test_two_processes_at_once_get_the_one_model(server, cache):
    other_is_here, both_are_here = threading.Event(), threading.Barrier(2)

    def answer() -> Answer:
        other_is_here.set()
        both_are_here.wait(timeout=20)
        return Answer(model_zip(BALL))

    server.says(answer)
    code = "from bt_manip.models import find_model; print(find_model('fuel:someone/thing').path)"
    other = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert other_is_here.wait(timeout=60)
    path = find_any_model("fuel:someone/thing").path
    assert (other.communicate(timeout=30)[0].strip(), other.returncode) == (str(path), 0)
    assert path.read_text() == BALL
    assert not [p for p in cache.root.iterdir() if p.name.startswith(".")]


def test_what_a_crash_left_behind_is_replaced(server, cache):
    server.add("someone", "thing", model_zip(BALL))
    thing = fuel_address("fuel:someone/thing")
    left = cache.folder(thing) / "1"
    left.mkdir(parents=True)
    (left / "half").touch()
    assert cache.find(thing) is None
    assert [p.name for p in sorted(find_model(thing)[1].iterdir())] == [
        "model.config", "model.sdf",
    ]  # fmt: skip


def test_a_model_includes_another_one_of_fuel(server):
    server.add("someone", "ball", model_zip(BALL))
    sdf = f"""<sdf version="1.10"><model name="two"><link name="base"/>
    <include><uri>{server.url}/1.0/someone/models/ball</uri><pose>0 0 1 0 0 0</pose></include>
    <joint name="j" type="fixed"><parent>base</parent><child>ball::link</child></joint>
    </model></sdf>"""
    server.add("someone", "two", model_zip(sdf))
    assert 'name="ball::link"' in load_model("fuel:someone/two").xml


def test_a_model_may_name_meshes_of_its_own(server):
    import trimesh

    cube = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl")
    uris = ("meshes/cube.stl", "model://My%20Thing/meshes/cube.stl",
            f"{server.url}/1.0/someone/models/my thing/tip/files/meshes/cube.stl")  # fmt: skip
    visuals = "".join(
        f"<visual name='v{i}'><geometry><mesh><uri>{uri}</uri></mesh></geometry></visual>"
        for i, uri in enumerate(uris)
    )
    sdf = f"<sdf version='1.10'><model name='m'><link name='l'>{visuals}</link></model></sdf>"
    server.add("someone", "my thing", model_zip(sdf, **{"meshes/cube.stl": cube}))
    assert load_model("fuel:someone/my thing").xml.count('type="mesh"') == 3


@pytest.mark.parametrize(
    "uri", ["../../secret.stl", "/etc/secret.stl", "file:///etc/secret.stl", "model://other/a.stl",
            "model://thing/../../../x.stl", "package://other/a.stl"],
)  # fmt: skip
def test_a_model_from_the_network_names_no_files_of_the_machine(server, tmp_path, uri):
    (tmp_path / "secret.stl").touch()
    shape = f"<geometry><mesh><uri>{uri}</uri></mesh></geometry>"
    sdf = f"""<sdf version="1.10"><model name="m"><link name="l">
    <visual name="v">{shape}</visual></link></model></sdf>"""
    server.add("someone", "thing", model_zip(sdf))
    with pytest.raises(ModelError, match=r"model\.sdf:2: .*(leaves|may not)"):
        load_model("fuel:someone/thing")


def test_a_certificate_that_nobody_vouches_for_is_not_trusted(tmp_path, monkeypatch):
    if shutil.which("openssl") is None:
        pytest.skip("no openssl to make a certificate with")
    key, cert = tmp_path / "key.pem", tmp_path / "cert.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj",
         "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", cert],
        check=True, capture_output=True,
    )  # fmt: skip
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    running = FuelServer()
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(cert, key)
    running.http.socket = context.wrap_socket(running.http.socket, server_side=True)
    monkeypatch.setenv("BT_MANIP_FUEL_URL", running.url.replace("http:", "https:"))
    running.add("someone", "thing", model_zip(BALL))
    monkeypatch.setenv("GZ_FUEL_CACHE_PATH", str(tmp_path / "cache"))
    try:
        with pytest.raises(ModelError, match="certificate is not trusted"):
            find_model(fuel_address("fuel:someone/thing"))
        monkeypatch.setenv("REQUESTS_CA_BUNDLE", str(cert))  # now somebody does
        assert find_model(fuel_address("fuel:someone/thing"))[0].version == 1
    finally:
        running.stop()
