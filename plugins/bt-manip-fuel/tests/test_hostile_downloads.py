"""What a server may send that must be refused: one clear error, and nothing left on the disk."""

import gzip
import io
import stat
import struct
import zipfile
from collections.abc import Callable, Mapping

import pytest

from bt_manip.models import ModelError, find_model
from bt_manip_fuel.fuel.address import fuel_address
from bt_manip_fuel.fuel.archive import ZipLimits
from bt_manip_fuel.fuel.client import FuelClient

from .fuel_server import BALL, CONFIG, Answer, model_zip, zip_of

GOOD = model_zip(BALL)


@pytest.fixture
def refused(server, cache):
    """Ask for a model that must be refused; give the message."""

    def refuse(**options: object) -> str:
        client = FuelClient(cache, progress=lambda *_: None, **options)
        with pytest.raises(ModelError) as caught:
            client.find(fuel_address("fuel:someone/thing"))
        assert not cache.root.exists()
        text = str(caught.value)
        assert text.startswith("fuel:someone/thing was not fetched: ")
        assert text.isprintable()
        assert ".bt_manip_" not in text
        return text

    return refuse


def test_a_cut_connection(server, refused):
    server.says(Answer(GOOD[: len(GOOD) // 2], announced=len(GOOD)))
    assert "cut" in refused()


def test_a_zip_that_ends_in_the_middle(server, refused):
    server.says(Answer(GOOD[: len(GOOD) // 2]))
    assert "broken" in refused()


def test_no_zip_at_all(server, refused):
    server.says(Answer(b"<html>Sorry</html>"))
    assert "broken" in refused()


def test_an_answer_that_says_itself_that_it_is_no_zip(server, refused):
    server.says(Answer(b"<html>Sorry</html>", kind="text/html"))
    assert "expected a zip, got 'text/html'" in refused()


def test_an_answer_that_is_packed_once_more(server, refused):
    packed = gzip.compress(GOOD)
    server.says(Answer(packed, headers={"Content-Encoding": "gzip"}))
    assert "packed as 'gzip'" in refused()


def stored_zip(content: str) -> bytearray:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("model.config", CONFIG.format(name="thing"))
        archive.writestr("model.sdf", content)
    return bytearray(out.getvalue())


def test_a_zip_whose_checksum_is_wrong(server, refused):
    data = stored_zip(BALL)
    data[data.index(b"sphere")] ^= 1
    server.says(Answer(bytes(data)))
    assert "CRC" in refused()


@pytest.mark.parametrize("change", [-7, 7])
def test_a_zip_whose_length_is_wrong(server, refused, change):
    data = stored_zip(BALL)
    entry = data.rindex(b"PK\x01\x02")  # the last one of the directory: model.sdf
    (size,) = struct.unpack_from("<I", data, entry + 24)
    struct.pack_into("<I", data, entry + 24, size + change)
    server.says(Answer(bytes(data)))
    refused()


@pytest.mark.parametrize(("status", "words"), [(404, "no such model"), (500, "500")])
def test_a_server_that_has_nothing(server, refused, status, words):
    server.says(Answer(status=status, body=b"{}", kind="application/json"))
    assert words in refused()


@pytest.mark.parametrize("status", [401, 403])
def test_a_private_model_without_a_token(server, refused, status):
    server.says(Answer(status=status))
    assert "token" in refused()


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
    assert "expected a zip, got 'text/plain'" in refused()


@pytest.mark.parametrize("place", ["file:///etc/passwd", "ftp://127.0.0.1/x.zip", "gopher://a/b"])
def test_a_referral_to_another_scheme(server, refused, place):
    server.says(Answer(place.encode(), kind="text/plain"))
    assert "not https or http" in refused()


def test_a_redirect_to_another_scheme(server, refused):
    server.says(Answer(status=302, headers={"Location": "file:///etc/passwd"}))
    assert "not https or http" in refused()


@pytest.mark.parametrize("text", [b"", b"two words", b"\x1b[2J", b"\xff\xfe", b"x" * 100_000])
def test_a_referral_that_is_no_address(server, refused, text):
    server.says(Answer(text, kind="text/plain"))
    refused()


@pytest.mark.parametrize("version", ["0", "-1", "latest", "1e3", "../../1", "9" * 30])
def test_a_version_that_is_none(server, refused, version):
    server.says(Answer(GOOD, headers={"X-Ign-Resource-Version": version}))
    assert "version" in refused()


def test_another_version_than_the_asked_one(server, cache):
    headers = {"X-Ign-Resource-Version": "2"}
    server.answers["/1.0/someone/models/thing/3/thing.zip"] = Answer(GOOD, headers=headers)
    with pytest.raises(ModelError, match="version 2 for version 3"):
        find_model("fuel:someone/thing/3")
    assert not cache.root.exists()


def odd_zip(name: str, change: Callable[[zipfile.ZipInfo], None] = lambda _: None) -> bytes:
    """Make a zip of a whole model and one entry more."""
    out = io.BytesIO(GOOD)
    with zipfile.ZipFile(out, "a") as archive:
        info = zipfile.ZipInfo("placeholder")
        info.filename = info.orig_filename = name
        change(info)
        archive.writestr(info, b"/etc/passwd")
    return out.getvalue()


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


def test_a_link(server, refused):
    def link(info: zipfile.ZipInfo) -> None:
        info.create_system = 3
        info.external_attr = (stat.S_IFLNK | 0o777) << 16

    server.says(Answer(odd_zip("meshes", link)))
    assert "it is a link" in refused()


@pytest.mark.parametrize("kind", [stat.S_IFIFO, stat.S_IFCHR, stat.S_IFSOCK])
def test_what_is_neither_file_nor_folder(server, refused, kind):
    def special(info: zipfile.ZipInfo) -> None:
        info.create_system = 3
        info.external_attr = (kind | 0o666) << 16

    server.says(Answer(odd_zip("pipe", special)))
    assert "neither file nor folder" in refused()


@pytest.mark.parametrize("name", ["a\x07b", "a\nb", "a\x1b[2Jb", "a\x7fb", "a\x85b", "a\u202eb"])
def test_a_file_name_with_control_characters(server, refused, name):
    server.says(Answer(odd_zip(name)))
    assert "control characters" in refused()


def test_a_file_name_that_goes_on_after_its_end(server, refused):
    data = odd_zip("model.sdfX").replace(b"model.sdfX", b"model.sdf\0")
    server.says(Answer(data))
    assert "control characters" in refused()


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_name_that_is_there_twice(server, refused):
    server.says(Answer(odd_zip("model.sdf")))
    assert "two entries" in refused()


def test_a_file_where_a_folder_has_to_be(server, refused):
    server.says(Answer(odd_zip("model.sdf/x")))
    refused()


def test_a_zip_bomb(server, refused):
    data = model_zip(BALL, **{"meshes/x.stl": bytes(40 * 2**20)})
    assert len(data) < 100_000
    server.says(Answer(data))
    assert "bomb" in refused()


def test_a_bomb_that_hides_its_size(server, refused):
    data = bytearray(model_zip(BALL, **{"zzz": bytes(4 * 2**20)}))
    entry = data.rindex(b"PK\x01\x02")
    struct.pack_into("<I", data, entry + 24, 100)
    server.says(Answer(bytes(data)))
    refused()


@pytest.mark.parametrize("limits", [ZipLimits(files=2), ZipLimits(total=500)])
def test_more_than_a_model_has(server, refused, limits):
    server.says(Answer(model_zip(BALL, other="x" * 600)))
    assert "more than" in refused(limits=limits)


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
    files: Mapping[str, str] = {"model.config": config, "model.sdf": BALL}
    server.says(Answer(zip_of(files)))
    message = refused()
    assert "model.config" in message
    assert "root:" not in message


def test_an_external_entity_is_not_even_asked_for(server, refused, other_server):
    place = f'<!ENTITY x SYSTEM "{other_server.url}/x">'
    server.says(Answer(zip_of({"model.config": entity(place), "model.sdf": BALL})))
    assert "DOCTYPE" in refused()
    assert other_server.requests == []


def test_a_zip_without_a_model(server, refused):
    server.says(Answer(zip_of({"readme.txt": "hello"})))
    assert "model.config" in refused()


def test_a_refused_version_leaves_the_others_alone(server, cache):
    server.add("someone", "thing", GOOD, version=1)
    _, folder = find_model("fuel:someone/thing"), cache.folder(fuel_address("fuel:someone/thing"))
    server.add("someone", "thing", b"rubbish", version=2)
    with pytest.raises(ModelError):
        find_model("fuel:someone/thing/2")
    assert [p.name for p in folder.iterdir()] == ["1"]
    assert [p.name for p in cache.root.iterdir()] == [folder.relative_to(cache.root).parts[0]]
