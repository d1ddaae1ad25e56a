"""A field of a dataclass is declared once, and read, written, checked and listed from there."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import BtManipError
from bt_manip.robots import RobotDescription, RobotError, panda
from bt_manip.toml import (
    Key,
    TomlFile,
    TomlTable,
    check_fields,
    documented,
    entries_of,
    plain,
    pose_entries,
    read_fields,
    read_part,
    toml_text,
    write_fields,
)


@documented
@dataclass(frozen=True)
class Wheel:
    """A wheel."""

    radius: Annotated[float, Key("Radius", "m", above=0.0)] = 0.1


@documented
@dataclass(frozen=True)
class Cart:
    """A cart."""

    names: Annotated[tuple[str, ...], Key("Names of its axles")]
    loads: Annotated[tuple[float, ...], Key("Loads", "N", at_least=0.0, size="names")]
    colour: Annotated[str | None, Key("Colour")] = None
    count: Annotated[int, Key("Number of carts")] = 1
    locked: Annotated[bool, Key("Whether the brake is on")] = False
    wheel: Annotated[Wheel, Key("Its wheel")] = Wheel()
    pairs: Annotated[tuple[tuple[str, str], ...], Key("Coupled axles")] = ()
    T: Annotated[pin.SE3, Key("Its pose", "m, rad", table="place")] = field(
        default_factory=pin.SE3.Identity
    )
    label: str = ""


FULL = Cart(
    ("front", "rear"), (1.0, 2e-7), 'a "red" one', 3, True, Wheel(0.25), (("front", "rear"),),
    spatial.pose((0.1, 0.0, -0.2), (0.0, 0.0, 0.6, 0.8)),
)  # fmt: skip


def read(path: Path, text: str) -> Cart:
    path.write_text(text)
    return Cart(**read_fields(Cart, TomlFile(path, "cart", BtManipError).whole))


@pytest.mark.parametrize("cart", [FULL, Cart(("axle",), (3.0,))])
def test_what_is_written_is_read_as_the_same(cart, tmp_path):
    again = read(tmp_path / "cart.toml", toml_text(write_fields(cart), {}, "a cart"))
    assert replace(again, T=cart.T) == cart
    assert again.T.isApprox(cart.T, 1e-11)
    assert write_fields(Cart(("axle",), (3.0,))) == {"names": ["axle"], "loads": [3.0]}


def test_comments_stand_above_their_keys():
    notes = {"loads": "Of each axle.", "wheel": "Measured.", "wheel.radius": "Without a tyre."}
    lines = toml_text(write_fields(FULL), notes, "a cart").splitlines()
    assert lines[0] == "# a cart"
    assert lines[lines.index("# Of each axle.") + 1] == "loads = [1.0, 2e-07]"
    assert lines[lines.index("# Measured.") + 1] == "[wheel]"
    assert lines[lines.index("# Without a tyre.") + 1] == "radius = 0.25"


def test_all_wrong_keys_are_said_at_once(tmp_path):
    text = 'loads = [-1.0]\nnames = ["a"]\ncuont = 2\nlocked = 1\n[wheel]\nradius = 0\n'
    with pytest.raises(BtManipError) as error:
        read(tmp_path / "cart.toml", text)
    lines = str(error.value).splitlines()
    assert [line.split("'")[1] for line in lines] == ["loads", "locked", "wheel.radius", "cuont"]
    assert "did you mean 'count'" in lines[-1] and "cart.toml:3:" in lines[-1]


def test_what_is_made_in_python_is_checked_like_a_file():
    with pytest.raises(RobotError, match="my cart: key 'loads' is a list of 2 numbers, got 1"):
        check_fields(replace(FULL, loads=(1.0,)), "my cart", RobotError)


@dataclass(frozen=True)
class Sizes:
    """Lists of bounded lengths."""

    two: Annotated[tuple[float, ...], Key("Two", size=2)] = ()
    few: Annotated[tuple[float, ...], Key("Two to four", size=(2, 4))] = ()
    names: Annotated[tuple[str, ...], Key("Any")] = ()
    pair: Annotated[tuple[str, ...], Key("Two", size=2)] = ()
    some: Annotated[tuple[str, ...], Key("Two to three", size=(2, 3))] = ()
    most: Annotated[float, Key("Bounded", at_most=2.0)] = 0.0
    whole: Annotated[int, Key("Bounded", at_least=2, at_most=5)] = 2


@pytest.mark.parametrize(
    ("key", "valid", "invalid", "message"),
    [
        ("two", ("[1, 2]",), ("[1]", "[1, 2, 3]"), "is a list of 2 numbers, got"),
        ("few", ("[1, 2]", "[1, 2, 3, 4]"), ("[1]", "[1, 2, 3, 4, 5]"), "a list of 2 to 4 numbers"),
        (
            "names",
            ('["a"]', '["a", "b", "c"]'),
            ("[]", '["a", "a"]'),
            "a list of at least one name",
        ),
        ("pair", ('["a", "b"]',), ('["a"]', '["a", "b", "c"]'), "is a list of 2 names, each once"),
        (
            "some",
            ('["a", "b"]', '["a", "b", "c"]'),
            ('["a"]', '["a", "b", "c", "d"]'),
            "2 to 3 names",
        ),
        ("most", ("2", "-1e10"), ("2.1", "-1.1e10", "inf", "true"), "is a .*number"),
        ("whole", ("2", "5"), ("1", "6", "2.0"), "is a .*number"),
    ],
)
def test_lists_and_numbers_are_accepted_within_their_bounds(tmp_path, key, valid, invalid, message):
    def table(text: str) -> TomlTable:
        (tmp_path / "sizes.toml").write_text(f"{key} = {text}\n")
        return TomlFile(tmp_path / "sizes.toml", "sizes", BtManipError).whole

    for text in valid:
        value = read_fields(Sizes, table(text))[key]
        assert write_fields(Sizes(**{key: value})) == {key: plain(value)} or value == 2
    for text in invalid:
        with pytest.raises(BtManipError, match=f"sizes.toml:1: key '{key}' .*{message}"):
            read_fields(Sizes, table(text))


def test_a_part_without_a_key_that_it_needs_is_none(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text("[cart]\ncolour = 'red'\n")
    table = TomlFile(path, "cart", BtManipError).whole.table("cart")
    assert read_part(Cart, table) is None


def test_declared_keys_are_in_the_docstring():
    assert "    Attributes:\n        radius: Radius [m].\n" in Wheel.__doc__


def test_a_new_field_of_a_robots_description_is_one_line(tmp_path):
    """The line of `mass` below is all that reading, checking, writing and listing need."""

    @dataclass(frozen=True)
    class Heavier(RobotDescription):
        mass: Annotated[float, Key("Mass of the arm", "kg", above=0.0)] = 10.0

    made = Heavier(**{**vars(panda()), "mass": 17.5})
    path = tmp_path / "panda.toml"
    path.write_text(toml_text(write_fields(made, tmp_path), {"mass": "Of the data sheet."}, "one"))
    assert "\n# Of the data sheet.\nmass = 17.5\n" in path.read_text()
    table = TomlFile(path, "robot description", RobotError).whole
    assert Heavier(**read_fields(Heavier, table)).mass == 17.5
    mass = entries_of(Heavier)[-1]
    assert (mass.name, mass.form, mass.unit, mass.bounds) == ("mass", "number", "kg", "above 0")
    with pytest.raises(RobotError, match="'panda': key 'mass' is a positive number .kg., got -1"):
        replace(made, mass=-1.0)


def test_a_pose_is_written_without_what_is_of_the_identity():
    turned = (0.7, 0.1, 0.5, 0.5)
    assert pose_entries(spatial.pose((0.0, 0.0, 0.0))) == {}
    assert pose_entries(spatial.pose((1.0, 0.0, 0.0))) == {"position": [1.0, 0.0, 0.0]}
    entries = pose_entries(spatial.pose((0.0, 1e-11, 1e-13), turned))
    assert entries == {"position": [0.0, 1e-11, 0.0], "quat_wxyz": pytest.approx(turned)}
