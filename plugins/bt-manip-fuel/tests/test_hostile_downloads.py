"""What a server may send that must be refused: one clear error, and nothing left on the disk."""

import gzip
import io
import stat
import struct
import warnings
import zipfile
from collections.abc import Callable

import pytest

from bt_manip.models import ModelError
from bt_manip_fuel.fuel import archive
from bt_manip_fuel.fuel.address import fuel_address
from bt_manip_fuel.fuel.client import find_model

from .fuel_server import BALL, CONFIG, Answer, model_zip, zip_of

GOOD = model_zip(BALL)


@pytest.fixture
def refused(server, cache):
    """Ask for a model that must be refused; give the message."""

    def refuse() -> str:
        with pytest.raises(ModelError) as caught:
            find_model(fuel_address("fuel:someone/thing"))
        assert not cache.root.exists() or not [*cache.root.iterdir()]
        text = str(caught.value)
        assert text.startswith("fuel:someone/thing was not fetched: ")
        assert text.isprintable()
        assert ".bt_manip_" not in text
        return text

    return refuse


def stored_zip() -> bytearray:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("model.config", CONFIG.format(name="thing"))
        archive.writestr("model.sdf", BALL)
    return bytearray(out.getvalue())


def wrong_checksum() -> bytes:
    data = stored_zip()
    data[data.index(b"sphere")] ^= 1
    return bytes(data)


def wrong_length(data: bytes, change: Callable[[int], int]) -> bytes:
    """Change the length of the last entry in the directory of a zip."""
    data = bytearray(data)
    entry = data.rindex(b"PK\x01\x02")
    (size,) = struct.unpack_from("<I", data, entry + 24)
    struct.pack_into("<I", data, entry + 24, change(size))
    return bytes(data)


def odd_zip(name: str, mode: int = 0) -> bytes:
    """Make a zip of a whole model and one entry more."""
    out = io.BytesIO(GOOD)
    with warnings.catch_warnings(), zipfile.ZipFile(out, "a") as archive:
        warnings.simplefilter("ignore")  # of a name that is there twice
        info = zipfile.ZipInfo("placeholder")
        info.filename = info.orig_filename = name
        if mode:
            info.create_system, info.external_attr = 3, mode << 16
        archive.writestr(info, b"/etc/passwd")
    return out.getvalue()


BOMB = model_zip(BALL, **{"meshes/x.stl": bytes(40 * 2**20)})


def text(body: str | bytes) -> Answer:
    """Refer to another place."""
    return Answer(body if isinstance(body, bytes) else body.encode(), kind="text/plain")


def version(number: str) -> Answer:
    return Answer(GOOD, headers={"X-Ign-Resource-Version": number})


REFUSED = {
    "a cut connection": ("IncompleteRead", Answer(GOOD[: len(GOOD) // 2], announced=len(GOOD))),
    "a zip that ends in the middle": ("broken", Answer(GOOD[: len(GOOD) // 2])),
    "no zip": ("broken", Answer(b"<html>Sorry</html>")),
    "a page": ("expected a zip, got 'text/html'", Answer(b"<html>", kind="text/html")),
    "a zip packed once more": (
        "packed as 'gzip'", Answer(gzip.compress(GOOD), headers={"Content-Encoding": "gzip"})
    ),
    "a wrong checksum": ("CRC", Answer(wrong_checksum())),
    "a shorter length": ("", Answer(wrong_length(stored_zip(), lambda size: size - 7))),
    "a longer length": ("", Answer(wrong_length(stored_zip(), lambda size: size + 7))),
    "nothing": ("no such model", Answer(status=404, body=b"{}", kind="application/json")),
    "an error": ("500", Answer(status=500, body=b"{}", kind="application/json")),
    "no token": ("token", Answer(status=401)),
    "a wrong token": ("token", Answer(status=403)),
    "a referral to a file": ("not https or http", text("file:///etc/passwd")),
    "a referral to FTP": ("not https or http", text("ftp://127.0.0.1/x.zip")),
    "a redirect to a file": (
        "not https or http", Answer(status=302, headers={"Location": "file:///etc/passwd"})
    ),
    "an empty referral": ("", text("")),
    "a referral to words": ("", text("two words")),
    "a referral to control characters": ("", text("\x1b[2J")),
    "a referral to bytes": ("", text(b"\xff\xfe")),
    "a long referral": ("", text("x" * 100_000)),
    "version 0": ("version", version("0")),
    "version -1": ("version", version("-1")),
    "a word as version": ("version", version("latest")),
    "a path as version": ("version", version("../../1")),
    "a long version": ("version", version("9" * 30)),
    "a link": ("it is a link", Answer(odd_zip("meshes", stat.S_IFLNK | 0o777))),
    "a pipe": ("neither file nor folder", Answer(odd_zip("pipe", stat.S_IFIFO | 0o666))),
    "a device": ("neither file nor folder", Answer(odd_zip("pipe", stat.S_IFCHR | 0o666))),
    "a name twice": ("File exists", Answer(odd_zip("model.sdf"))),
    "a file where a folder is": ("", Answer(odd_zip("model.sdf/x"))),
    "a name that goes on after its end": (
        "control characters",
        Answer(odd_zip("model.sdfX").replace(b"model.sdfX", b"model.sdf\0")),
    ),
    "a bomb": ("bomb", Answer(BOMB)),
    "a bomb that hides its size": (
        "", Answer(wrong_length(model_zip(BALL, zzz=bytes(4 * 2**20)), lambda size: 100))
    ),
    "no model": ("model.config", Answer(zip_of({"readme.txt": "hello"}))),
}  # fmt: skip
REFUSED |= {
    name: ("control characters", Answer(odd_zip(name)))
    for name in ("a\x07b", "a\nb", "a\x1b[2Jb", "a\x7fb", "a\x85b", "a\u202eb")
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_answer_that_is_no_model(server, refused, name):
    words, answer = REFUSED[name]
    server.says(answer)
    assert words in refused()


@pytest.mark.parametrize(
    "name",
    [
        "../evil", "a/../../evil", "meshes/../../../evil", "/etc/evil", "//server/evil",
        "C:/evil", "..\\evil", "a\\b",
    ],
)  # fmt: skip
def test_a_path_that_climbs_out(server, refused, tmp_path, name):
    server.says(Answer(odd_zip(name)))
    assert "its path" in refused()
    assert not list(tmp_path.rglob("evil"))


def test_a_redirect_loop(server, refused):
    here = "/1.0/someone/models/thing/tip/thing.zip"
    server.says(Answer(status=302, headers={"Location": "/elsewhere"}))
    server.answers["/elsewhere"] = Answer(status=307, headers={"Location": f"{here}?link=true"})
    assert "circle" in refused()


def test_redirects_without_end(server, refused):
    server.says(Answer(status=302, headers={"Location": "/0"}))
    for i in range(20):
        server.answers[f"/{i}"] = Answer(status=302, headers={"Location": f"/{i + 1}"})
    assert "more than 5 times" in refused()
    assert len(server.requests) < 10


def test_a_referral_that_refers_again(server, refused):
    server.answers["/next"] = Answer(f"{server.url}/next?again".encode(), kind="text/plain")
    server.says(Answer(f"{server.url}/next".encode(), kind="text/plain"))
    assert "circle" in refused()


def test_another_version_than_the_asked_one(server, cache):
    headers = {"X-Ign-Resource-Version": "2"}
    server.answers["/1.0/someone/models/thing/3/thing.zip"] = Answer(GOOD, headers=headers)
    with pytest.raises(ModelError, match="version 2 for version 3"):
        find_model(fuel_address("fuel:someone/thing/3"))
    assert not cache.root.exists()


@pytest.mark.parametrize(("limit", "most"), [("MAX_FILES", 2), ("MAX_TOTAL", 500)])
def test_more_than_a_model_has(server, refused, monkeypatch, limit, most):
    monkeypatch.setattr(archive, limit, most)
    server.says(Answer(model_zip(BALL, other="x" * 600)))
    assert "more than" in refused()


def test_a_refused_version_leaves_the_others_alone(server, cache):
    thing = fuel_address("fuel:someone/thing")
    server.add("someone", "thing", GOOD, version=1)
    find_model(thing)
    server.add("someone", "thing", b"rubbish", version=2)
    with pytest.raises(ModelError):
        find_model(thing.at(2))
    assert [path.name for path in cache.folder(thing).iterdir()] == ["1"]
    assert len([*cache.root.iterdir()]) == 1  # the folder of the server


def entity(text: str) -> str:
    return f'<!DOCTYPE model [{text}]><model><sdf version="1.9">&x;</sdf></model>'


@pytest.mark.parametrize(
    "config",
    [
        "not XML at all", "<model><sdf>", "", "<model/>", "<model><sdf>../x.sdf</sdf></model>",
        "<model><sdf>/etc/passwd</sdf></model>", "<model><sdf>absent.sdf</sdf></model>",
        "<model><sdf></sdf></model>", entity('<!ENTITY x SYSTEM "file:///etc/passwd">'),
        entity('<!ENTITY x "model.sdf">'),
        entity('<!ENTITY y "yyyyyyyyyy"><!ENTITY x "&y;&y;&y;&y;&y;&y;">'),
    ],
)  # fmt: skip
def test_a_model_config_that_is_none(server, refused, config):
    server.says(Answer(zip_of({"model.config": config, "model.sdf": BALL})))
    message = refused()
    assert "model.config" in message
    assert "root:" not in message


def test_an_external_entity_is_not_even_asked_for(server, refused, other_server):
    place = f'<!ENTITY x SYSTEM "{other_server.url}/x">'
    server.says(Answer(zip_of({"model.config": entity(place), "model.sdf": BALL})))
    assert "DOCTYPE" in refused()
    assert other_server.requests == []
