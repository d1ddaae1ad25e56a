"""Exit codes."""

import os
from functools import partial

import pytest

from bt_manip.cli import exit_codes
from bt_manip.evaluation import WorkerDiedError, call_in_process
from bt_manip.exceptions import BtManipError


def test_a_process_that_died_is_a_fault_and_no_bad_input():
    with pytest.raises(WorkerDiedError) as died:
        call_in_process("the undisturbed cycle", partial(os._exit, 7))
    assert exit_codes.exit_code_of(died.value) == exit_codes.FAULT
    assert exit_codes.exit_code_of(BtManipError("no such tree")) == exit_codes.BAD_INPUT
