"""Switch2 .. Switch6: a value chooses the child."""

from collections.abc import Mapping
from typing import ClassVar

from bt_manip.bt import literals
from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.port_types import STRING
from bt_manip.bt.ports import Input, Port
from bt_manip.bt.script.evaluation import EPSILON
from bt_manip.bt.status import RUNNING, SKIPPED, NodeStatus
from bt_manip.exceptions import PortError, TreeError


class Switch(Control):
    """Tick the child whose case equals the variable, or else the last child.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | all are reset, SUCCESS                                              |
    | FAILURE | all are reset, FAILURE                                              |
    | RUNNING | RUNNING; the variable is read again at the next tick, and if it     |
    |         | chooses another child then, this one is halted                      |
    | SKIPPED | SKIPPED                                                             |
    | halt    | the running child is halted                                         |

    Cases are equal to the variable as texts, as integers, or as numbers up to 2^-23; names of
    scripting enumerations mean their numbers. Without a variable the last child is ticked.
    """

    memory: ClassVar = ("_running_child",)
    cases: ClassVar[tuple[str, ...]] = ()
    variable = Input(str, doc="the value that the cases are compared with")
    _running_child = -1

    def _tick(self) -> NodeStatus:
        children = self.child_nodes
        if len(children) != len(self.cases) + 1:
            raise TreeError(
                f"must have {len(self.cases) + 1} children, one for each case and one for the "
                f"others, not {len(children)}"
            )
        chosen = self._choose()
        if self._running_child not in (-1, chosen):
            self._halt_child(self._running_child)
        state = children[chosen].execute()
        if state is SKIPPED:
            self._running_child = -1
        elif state is RUNNING:
            self._running_child = chosen
        else:
            self._reset_children()
            self._running_child = -1
        return state

    def _choose(self) -> int:
        try:
            variable = self.read_port("variable")
        except PortError:
            return len(self.cases)
        for index, name in enumerate(self.cases):
            try:
                case = self.read_port(name)
            except PortError:
                continue
            if equal(variable, case, self.runtime.enums):
                return index
        return len(self.cases)

    def _halt(self) -> None:
        self._running_child = -1
        super()._halt()


def equal(value: str, other: str, enums: Mapping[str, int]) -> bool:
    """Return whether a variable and a case are equal: as texts, integers or real numbers."""
    if value == other:
        return True
    numbers = [enums[text] if text in enums else _integer(text) for text in (value, other)]
    if None not in numbers and numbers[0] == numbers[1]:
        return True
    reals = [float(enums[text]) if text in enums else _real(text) for text in (value, other)]
    if reals[0] is None or reals[1] is None:
        return False
    return abs(reals[0] - reals[1]) <= EPSILON


def _integer(text: str) -> int | None:
    try:
        value = literals.parse_integer(text)
    except ValueError:
        return None
    return value if text.removeprefix("-").isdecimal() else None


def _real(text: str) -> float | None:
    try:
        return literals.parse_real(text, whole=True)
    except ValueError:
        return None


def _switch(count: int) -> type[Switch]:
    names = tuple(f"case_{index + 1}" for index in range(count))
    ports: dict[str, Port] = {name: Input(STRING, doc="value of this case") for name in names}
    table = (Switch.__doc__ or "").partition("\n\n")[2]
    body = {
        "__doc__": f"A Switch with {count} cases.\n\n{table}",
        "__module__": __name__,
        "cases": names,
        "least_children": count + 1,
        "most_children": count + 1,
        **ports,
    }
    return type(f"Switch{count}", (Switch,), body)


Switch2 = _switch(2)
Switch3 = _switch(3)
Switch4 = _switch(4)
Switch5 = _switch(5)
Switch6 = _switch(6)
