"""The scripting language: what it calculates, beside the traces, and what it refuses."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.port_types import BOOL, DOUBLE, INT, STRING
from bt_manip.bt.script import parse_script
from bt_manip.bt.script.evaluation import Environment
from bt_manip.exceptions import ScriptError

ENUMS = {"RED": 1, "GREEN": 2}


@pytest.fixture
def scope():
    scope = Blackboard()
    scope.write("i", 5, INT)
    scope.write("d", 1.5, DOUBLE)
    scope.write("b", True, BOOL)
    scope.write("s", "text", STRING)
    return scope


def evaluate(text, scope=None):
    return parse_script(text).evaluate(Environment(scope or Blackboard(), ENUMS))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("'a' < 'b'", 1.0),
        ("2 == '2.0'", 1.0),
        ("-1 / 0", -math.inf),
        ("9223372036854775808", 0),
    ],
)
def test_an_expression_beyond_the_traces_has_a_value(text, value):
    result, _ = evaluate(text)

    assert result == value and type(result) is type(value)


def test_zero_by_zero_is_no_number():
    assert math.isnan(evaluate("0 / 0")[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the script is empty"),
        ("x ==", "expected an operand at position 4"),
        ("(1", r"expected '\)' at position 2"),
        ("1 ? 2", "expected ':' at position 5"),
        ('x := "a"', "invalid token '\"' at position 5; strings stand between single quotes"),
        ("x := 'a", "the closing quote is missing"),
        ("5 % 2", "no such operator"),
        ("65.", r"invalid token '65\.'"),
        ("3foo", "invalid token '3foo'"),
        (".5", r"invalid token '\.'"),
        ("1e999", "does not fit a double"),
        ("(" * 100, "nested deeper than 64 levels"),
        ("-" * 100 + "1", "nested deeper than 64 levels"),
    ],
)
def test_what_is_no_script_is_refused_with_its_position(text, message):
    with pytest.raises(ScriptError, match=message):
        parse_script(text)


def test_a_long_chain_of_operators_is_no_nesting():
    assert evaluate(" + ".join(["1"] * 5000))[0] == 5000.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nope", "variable not found: nope"),
        ("nope = 1", r"does not exist; \[:=\] would create it"),
        ("a := 1 .. 2", r"right operand .* is nothing: \[..\] joins texts"),
        ("'a' && 1", "does not take"),
        ("!'a'", "needs a number"),
        ("2 && 1", "no truth value"),
        ("1.5 & 1", "needs integers"),
        ("'abc' == 1", "is not a number"),
        ("9007199254740993 + 1", "too large for a double"),
        ("1 + 1 := 3", "left operand of .* is not a blackboard entry"),
        ("s -= 'x'", "does not take a text"),
        ("i = 2.5", "is not an integer"),
        ("s = 3", "does not become"),
        ("s += 3", "needs a number on its left"),
        ("i = 'abc'", "is not an integer"),
    ],
)
def test_what_cannot_be_evaluated_says_why(scope, text, message):
    with pytest.raises(ScriptError, match=message):
        evaluate(text, scope)


def test_a_script_knows_what_it_reads_and_writes():
    script = parse_script("a := b + c; d += 1; (e)")

    assert script.reads == {"b", "c", "d", "e"}
    assert script.writes == {"a", "d"}


def test_double_quotes_are_strings_only_where_the_dialect_has_them():
    script = parse_script("\"it's \" .. 'x'", double_quotes=True)

    assert script.evaluate(Environment(Blackboard(), {}))[0] == "it's x"


@given(st.text(alphabet="ab1.5'\"+-*/&|^~!<>=?:();, \n@_xe{}", max_size=40))
def test_no_text_raises_anything_but_a_script_error(text):
    try:
        parse_script(text).evaluate(Environment(Blackboard(), ENUMS))
    except ScriptError:
        pass


@pytest.mark.parametrize("code", ["t += t", "t := t .. t"])
def test_a_text_that_doubles_is_refused_before_it_fills_the_memory(scope, code):
    evaluate("t := 'abcdefgh'", scope)
    with pytest.raises(ScriptError, match="a text is longer than 1000000 characters") as raised:
        for _ in range(100):
            evaluate(code, scope)
    assert len(str(raised.value)) < 240


def test_long_scripts_and_values_are_cut_in_messages(scope):
    text = "x" * 10_000
    for code in (f"t := '{text}'; t - 1", f"'{text}' * 2", f"{text} + 1", f"1 + '{text}"):
        with pytest.raises(ScriptError) as raised:
            evaluate(code, scope)
        assert len(str(raised.value)) < 300
        assert "..." in str(raised.value)
