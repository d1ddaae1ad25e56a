"""Ports: one declaration for Python, documents and the blackboard."""

import re
from enum import Enum

import pytest

from bt_manip.bt import (
    Action,
    InOut,
    Input,
    Output,
    Status,
    Tree,
    literals,
)
from bt_manip.bt.port_types import STRING, cast, port_type
from bt_manip.exceptions import PortError


class Mode(Enum):
    SLOW = 1
    FAST = 2


class Point(tuple):
    """A type of a behaviour's own."""


def parse_point(text):
    x, _, y = text.partition(",")
    return Point((float(x), float(y)))


class Move(Action):
    target = Input(Point, parse=parse_point, format=lambda p: f"{p[0]},{p[1]}", doc="where")
    speed = Input(float, default=0.5, doc="how fast [m/s]")
    mode = Input(Mode, default=Mode.SLOW)
    names = Input(list[str], default="a;b")
    count = InOut(int, default="{=}")
    in_ = Input(bool, default=False)
    reached = Output(Point)
    anything = Input()

    def update(self):
        self.reached = self.target
        return Status.SUCCESS


def bound(**ports):
    node = Move(**ports)
    Tree(node, enums={"QUICK": 2})
    return node


def test_a_literal_is_read_as_the_ports_type():
    node = bound(target="1,2", speed="0.25", mode="FAST", names="x;y;z", in_="true")

    assert node.target == (1.0, 2.0)
    assert (node.speed, node.mode, node.names, node.in_) == (0.25, Mode.FAST, ["x", "y", "z"], True)


def test_a_python_value_is_as_good_as_its_text():
    node = bound(target=Point((1.0, 2.0)), speed=1, mode=Mode.FAST, names=["x"])

    assert node.target == (1.0, 2.0) and node.speed == 1.0 and type(node.speed) is float
    assert node.port_text("target") == "1.0,2.0"


@pytest.mark.parametrize(
    ("type", "default", "message"),
    [
        (int, 2.5, "2.5 is not an integer"),
        (float, "fast", "no default of a port of type double"),
        (bool, "maybe", "no default of a port of type bool"),
        (str, 3, "expected std::string, found 3"),
        (list[float], ["a"], "no default of a port of type std::vector<double>"),
        (Mode, "SIDEWAYS", "'SIDEWAYS' is not one of SLOW, FAST"),
        (Point, 7, "expected Point, found 7"),
    ],
)
def test_a_default_of_another_type_is_refused_where_it_is_declared(type, default, message):
    with pytest.raises(PortError, match=re.escape(message)):
        Input(type, default=default)


@pytest.mark.parametrize(
    ("type", "default"),
    [
        (int, None), (int, "{key}"), (int, "{=}"), (float, 1), (float, "0.5"), (Mode, "FAST"),
        (Mode, Mode.SLOW), (list[int], "1;2"), (list[int], (1, 2)), (Point, None),
    ],
)  # fmt: skip
def test_a_default_is_a_value_a_text_an_entry_or_nothing(type, default):
    assert Input(type, default=default).default is default


def test_a_pointer_reads_the_entry_and_same_name_is_short_for_it():
    node = bound(target="{goal}", count="{=}", speed=" {v} ")
    node.scope["goal"] = Point((3.0, 4.0))
    node.scope["count"] = 2
    node.scope["v"] = "0.75"

    assert (node.target, node.count, node.speed) == ((3.0, 4.0), 2, 0.75)


def test_an_enumeration_is_read_by_name_number_or_scripting_name():
    for text in ("FAST", "2", "QUICK"):
        assert bound(target="0,0", mode=text).mode is Mode.FAST


@pytest.mark.parametrize(
    ("ports", "message"),
    [
        ({}, "port 'anything' of Move::1: nothing was given"),
        ({"anything": "{goal}"}, "the blackboard entry 'goal' was never written"),
        ({"anything": "{gone}"}, "the blackboard entry 'gone' does not exist"),
    ],
)
def test_a_port_that_cannot_be_read_says_why(ports, message):
    node = bound(target="0,0", **ports)
    node.scope.unset("gone")

    with pytest.raises(PortError, match=message):
        _ = node.anything


def test_a_value_that_does_not_fit_is_refused_at_once():
    with pytest.raises(
        PortError, match="port 'speed' of Move: expected double, found \\(None, None\\)"
    ):
        Move(target="0,0", speed=(None, None))
    with pytest.raises(PortError, match="port 'speed' of Move: 'fast' is not a number"):
        Move(target="0,0", speed="fast")


def test_an_unknown_port_offers_the_nearest_one():
    with pytest.raises(PortError, match="Move has no port 'tagret'; did you mean 'target'"):
        Move(tagret="0,0")


def test_an_output_writes_the_entry_with_its_type():
    node = bound(target="1,2", reached="{there}")
    node.execute()

    assert node.scope["there"] == (1.0, 2.0)
    assert node.scope.entry("there").declared == port_type(Point)


def test_an_input_cannot_be_written():
    with pytest.raises(AttributeError, match="port 'speed' of Move is an input"):
        bound(target="0,0").speed = 3.0


def test_an_output_must_point_to_an_entry():
    node = bound(target="1,2", reached="1,1")

    with pytest.raises(PortError, match="is no entry to write to"):
        node.write_port("reached", Point((0.0, 0.0)))


def test_a_list_that_was_read_can_be_changed_without_harm():
    node = bound(target="0,0", names="x;y")
    node.names.append("z")

    assert node.names == ["x", "y"]


@pytest.mark.parametrize("name", ["status", "skip_if"])
def test_a_port_cannot_take_a_name_that_is_needed(name):
    with pytest.raises(TypeError, match=f"a port cannot be named '{name}'"):
        type("Bad", (Action,), {name: Input(int)})


class TestLiterals:
    """Numbers are read as by the engine: the number at the start counts."""

    @pytest.mark.parametrize(
        ("text", "value"),
        [("12abc", 12), ("3.9", 3), ("-2147483648", -(1 << 31)), ("2147483647", (1 << 31) - 1)],
    )
    def test_an_integer_is_read_from_the_start(self, text, value):
        assert literals.parse_integer(text) == value

    @pytest.mark.parametrize("text", ["", "+1", " 1", "2147483648", "-2147483649", "9" * 5000])
    def test_what_is_no_integer_is_refused(self, text):
        with pytest.raises(ValueError):
            literals.parse_integer(text)

    @pytest.mark.parametrize(
        ("text", "value"), [("1.5x", 1.5), (".5", 0.5), ("5.", 5.0), ("2e3", 2000.0), ("1e", 1.0)]
    )
    def test_a_real_number_is_read_from_the_start(self, text, value):
        assert literals.parse_real(text) == value

    @pytest.mark.parametrize("text", ["", "x", "1e999", "1e-999", "+1.0"])
    def test_what_is_no_real_number_is_refused(self, text):
        with pytest.raises(ValueError):
            literals.parse_real(text)

    def test_lists_are_split_at_semicolons_or_written_as_json(self):
        assert port_type(list[int]).parse("1;2;") == [1, 2]
        assert port_type(list[float]).parse("json:[1, 2.5]") == [1.0, 2.5]
        assert port_type(list[str]).parse("") == []
        assert port_type(list[str]).parse("a;;b") == ["a", "", "b"]

    @pytest.mark.parametrize("text", ["1;" * 100_001, f"json:[{'1,' * 100_000}1]"])
    def test_lists_that_are_too_long_are_refused(self, text):
        with pytest.raises(ValueError, match="100001 items; at most 100000"):
            port_type(list[int]).parse(text)

    @pytest.mark.parametrize(
        ("python", "value"),
        [
            (int, -3),
            (float, 1e-300),
            (str, "a b"),
            (list[float], [0.1, 2.0]),
            (list[str], ["a", ""]),
            (list[str], ["a;b"]),
            (Mode, Mode.FAST),
        ],
    )
    def test_what_is_written_reads_as_the_same_value(self, python, value):
        kind = port_type(python)

        assert kind.parse(kind.format(value)) == value

    def test_a_number_becomes_a_text_as_in_the_engine(self):
        assert cast(3.5, port_type(float), STRING) == "3.500000"
