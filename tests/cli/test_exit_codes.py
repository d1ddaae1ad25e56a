"""Exit codes are said in one module, and commands name them."""

import ast
import os
from functools import partial
from pathlib import Path

import pytest

import bt_manip
from bt_manip.cli import exit_codes
from bt_manip.evaluation import WorkerDiedError, call_in_process
from bt_manip.exceptions import BtManipError

PACKAGE = Path(bt_manip.__file__).parent
CODES = {value for name, value in vars(exit_codes).items() if isinstance(value, int)}


def numbers_for_codes(source: str) -> list[str]:
    """Give statements that end a command with a number, and constants that are named again."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and ast.unparse(node.returns or node) == "int":
            returned = [one.value for one in ast.walk(node) if isinstance(one, ast.Return)]
            found += [ast.unparse(one) for one in returned if isinstance(one, ast.Constant)]
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "sys.exit":
            found += [ast.unparse(one) for one in node.args if isinstance(one, ast.Constant)]
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in vars(exit_codes):
            found.append(ast.unparse(node))
    return found


def test_the_codes_are_those_of_the_documentation():
    assert CODES == {0, 1, 2, 3, 130}


def test_a_process_that_died_is_a_fault_and_no_bad_input():
    with pytest.raises(WorkerDiedError) as died:
        call_in_process("the undisturbed cycle", partial(os._exit, 7))
    assert exit_codes.exit_code_of(died.value) == exit_codes.FAULT
    assert exit_codes.exit_code_of(BtManipError("no such tree")) == exit_codes.BAD_INPUT


@pytest.mark.parametrize("source", ["FAULT = 3", "sys.exit(2)", "def f() -> int: return 1"])
def test_a_code_that_is_said_again_is_found(source):
    assert numbers_for_codes(source)


def test_commands_name_their_exit_codes():
    files = [PACKAGE / "__main__.py", *sorted((PACKAGE / "cli").glob("*.py"))]
    found = {file.name: numbers_for_codes(file.read_text()) for file in files}
    del found["exit_codes.py"]
    assert {name: numbers for name, numbers in found.items() if numbers} == {}


def test_every_help_text_about_exit_codes_comes_from_there():
    files = sorted((PACKAGE / "cli").glob("*.py"))
    assert [file.name for file in files if "Exit codes:" in file.read_text()] == ["exit_codes.py"]
