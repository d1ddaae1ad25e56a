"""Assignments of the scripting language, and what they do to the type of an entry."""

from collections.abc import Mapping

from bt_manip.bt.blackboard import EMPTY, Entry
from bt_manip.bt.port_types import DOUBLE, STRING, UNTYPED
from bt_manip.bt.script.evaluation import (
    NUMBERS,
    Environment,
    Expression,
    Name,
    Value,
    missing,
    text_as_double,
)
from bt_manip.bt.script.operators import as_text, calculate
from bt_manip.exceptions import BlackboardError, ScriptError


def assignment(target: Expression, symbol: str, source: Expression) -> Expression:
    """Compile ``:=`` (create or assign), ``=`` (assign), ``+= -= *= /=``."""

    def evaluate(env: Environment) -> Value:
        if not isinstance(target, Name):
            raise ScriptError(f"the left operand of [{symbol}] is not a blackboard entry")
        key = target.key
        entry = env.scope.entry(key)
        if entry is None:
            if symbol != ":=":
                raise ScriptError(
                    f"the blackboard entry '{key}' does not exist; [:=] would create it"
                )
            try:
                env.scope.declare(key)
            except BlackboardError as error:
                raise ScriptError(str(error)) from None
            entry = env.scope.entry(key)
            if entry is None:
                raise ScriptError(
                    f"'{key}' is remapped to an entry of the root that does not exist; "
                    "only its own name, with @, creates it"
                )
        value = source(env)
        if value[0] is EMPTY:
            raise ScriptError(f"the right operand of operator [{symbol}] {missing(value)}")
        try:
            if symbol in (":=", "="):
                _assign(entry, value, env.enums)
            else:
                _update(entry, symbol, value)
        except (ValueError, ScriptError) as error:
            raise ScriptError(f"entry '{key}' does not take {value[0]!r}: {error}") from None
        return entry.value, entry.type

    return evaluate


def _assign(entry: Entry, value: Value, enums: Mapping[str, int]) -> None:
    content, type = value
    current = entry.value
    if current is EMPTY and entry.declared is UNTYPED:
        entry.put(content, type)
    elif type.family == "string" and (current is EMPTY or entry.type.family != "string"):
        convert = entry.declared.converter
        if convert is not None:
            entry.put(convert(content), entry.declared)
        elif current is not EMPTY and entry.type.family in NUMBERS:
            entry.put(text_as_double(content, enums), DOUBLE)
        else:
            raise ScriptError(f"a text does not become a {entry.type.name}")
    else:
        entry.copy_in(content, type)


def _update(entry: Entry, symbol: str, value: Value) -> None:
    if entry.value is EMPTY:
        raise ScriptError(f"the left operand of operator [{symbol}] was never written")
    current = (entry.value, entry.type)
    family = value[1].family
    if family in NUMBERS:
        if current[1].family not in NUMBERS:
            raise ScriptError(f"operator [{symbol}] needs a number on its left")
        entry.copy_in(*calculate(symbol[0], current, value))
    elif family == "string":
        if symbol != "+=":
            raise ScriptError(f"operator [{symbol}] does not take a text")
        entry.copy_in(as_text(current) + value[0], STRING)
    else:
        entry.copy_in(*current)
