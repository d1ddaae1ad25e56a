"""The scripting language: a Pratt parser that compiles a script to functions.

From loose to tight: ``:= = += -= *= /=``, ``?:``, ``||``, ``&&``, comparisons (chained),
``| ^``, ``&``, ``+ - ..``, ``* /``, and the prefixes ``- ~ !``. Statements may be separated by
``;``; the value of the last one is the value of the script.
"""

from typing import Final

from bt_manip.bt.literals import parse_real
from bt_manip.bt.port_types import DOUBLE, INT64, STRING
from bt_manip.bt.script.evaluation import (
    Environment,
    Expression,
    Name,
    Value,
    assignment,
    chain,
    comparison,
    constant,
    ternary,
    unary,
)
from bt_manip.bt.script.tokens import Token, tokenize
from bt_manip.exceptions import ScriptError, shortened, shown

MAX_SCRIPT_NESTING: Final = 64
"""How deep parentheses, prefixes, assignments and ternaries may be nested."""

_ASSIGNMENTS: Final = (":=", "=", "+=", "-=", "*=", "/=")
_COMPARISONS: Final = ("==", "!=", "<", ">", "<=", ">=")
_POWER: Final = {
    **dict.fromkeys(_ASSIGNMENTS, 2),
    "?": 4,
    "||": 6,
    "&&": 8,
    **dict.fromkeys(_COMPARISONS, 10),
    "|": 12,
    "^": 12,
    "&": 14,
    "+": 16,
    "-": 16,
    "..": 16,
    "*": 18,
    "/": 18,
}
_TERNARY: Final = 4
_COMPARISON: Final = 10
_PREFIX: Final = 20


class ParsedScript:
    """A compiled script.

    Attributes:
        text: Its source.
        reads: The names of the variables that it reads.
        writes: The names of the variables that it assigns.
    """

    def __init__(
        self, text: str, statements: list[Expression], reads: set[str], writes: set[str]
    ) -> None:
        self.text = text
        self.reads = frozenset(reads)
        self.writes = frozenset(writes)
        self._first = tuple(statements[:-1])
        self._last = statements[-1]

    def evaluate(self, env: Environment) -> Value:
        """Run the script, and give the value of its last statement; errors are `ScriptError`."""
        try:
            for statement in self._first:
                statement(env)
            return self._last(env)
        except ScriptError as error:
            raise ScriptError(f"error in script [{shortened(self.text)}]: {error}") from None


def parse_script(text: str, *, double_quotes: bool = False) -> ParsedScript:
    """Parse a script, if wanted with strings between double quotes too, as in MoveIt Pro.

    Raises:
        ScriptError: If it is empty or invalid.
    """
    parser = _Parser(tokenize(text, double_quotes=double_quotes))
    statements = parser.statements()
    if not statements:
        raise ScriptError("the script is empty")
    return ParsedScript(text, statements, parser.reads, parser.writes)


class _Parser:
    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._next = 0
        self._depth = 0
        self.reads: set[str] = set()
        self.writes: set[str] = set()

    def statements(self) -> list[Expression]:
        statements = []
        while self._token.kind != "end":
            statements.append(self._expression(0))
            while self._is(";"):
                self._advance()
        return statements

    @property
    def _token(self) -> Token:
        return self._tokens[self._next]

    def _is(self, symbol: str) -> bool:
        return self._token.kind == "operator" and self._token.text == symbol

    def _advance(self) -> Token:
        token = self._token
        self._next += 1
        return token

    def _expect(self, symbol: str) -> None:
        if not self._is(symbol):
            token = self._token
            raise ScriptError(
                f"expected '{symbol}' at position {token.position}, found {shown(token.text)}"
            )
        self._advance()

    def _expression(self, least: int) -> Expression:
        self._depth += 1
        if self._depth > MAX_SCRIPT_NESTING:
            raise ScriptError(f"nested deeper than {MAX_SCRIPT_NESTING} levels")
        left = self._prefix()
        while self._token.kind == "operator":
            symbol = self._token.text
            power = _POWER.get(symbol, -1)
            if power < 0 or power < least:
                break
            if symbol in _ASSIGNMENTS:
                self._advance()
                left = self._assignment(left, symbol)
                break
            if symbol == "?":
                self._advance()
                then = self._expression(0)
                self._expect(":")
                left = ternary(self._read(left), then, self._expression(_TERNARY))
                break
            if power == _COMPARISON:
                left = comparison(self._read(left), self._operands(power))
            else:
                left = chain(self._read(left), self._operands(power))
        self._depth -= 1
        return self._read(left)

    def _operands(self, power: int) -> list[tuple[str, Expression]]:
        operands = []
        while self._token.kind == "operator" and _POWER.get(self._token.text) == power:
            symbol = self._advance().text
            operands.append((symbol, self._expression(power + 1)))
        return operands

    def _assignment(self, left: Expression, symbol: str) -> Expression:
        if isinstance(left, Name):
            self.writes.add(left.key)
            if symbol not in (":=", "="):
                self.reads.add(left.key)
        return assignment(left, symbol, self._expression(0))

    def _read(self, operand: Expression) -> Expression:
        if isinstance(operand, Name):
            self.reads.add(operand.key)
        return operand

    def _prefix(self) -> Expression:
        token = self._advance() if self._token.kind != "end" else self._token
        if token.kind == "operator":
            if token.text in ("-", "~", "!"):
                return unary(token.text, self._expression(_PREFIX))
            if token.text == "(":
                inner = self._expression(0)
                self._expect(")")
                return inner
        elif token.kind == "integer":
            return constant(_integer(token.text), INT64)
        elif token.kind == "real":
            try:
                return constant(parse_real(token.text), DOUBLE)
            except ValueError as error:
                raise ScriptError(f"{error}, at position {token.position}") from None
        elif token.kind == "string":
            return constant(token.text, STRING)
        elif token.kind == "name":
            if token.text in ("true", "false"):
                return constant(float(token.text == "true"), DOUBLE)
            return Name(token.text)
        raise ScriptError(
            f"expected an operand at position {token.position}, found {shown(token.text)}"
        )


def _integer(text: str) -> int:
    if text[:2] in ("0x", "0X"):
        value = int(text, 16)
    else:
        digits = text.lstrip("0")
        value = int(digits or "0") if len(digits) < 20 else 1 << 63
    return value if value < 1 << 63 else 0  # as in the engine, where it does not fit
