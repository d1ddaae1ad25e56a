"""The camera of the page shows all that a task is about, also with two robots or many objects."""

import pytest

from .framing import check_framing


@pytest.mark.soak
@pytest.mark.parametrize("tree", ["two_arms", "sort_blocks"])
def test_all_that_a_task_is_about_is_inside_the_picture(start, open_window, tree):
    program = start("run", tree, "--view", "--real-time", "1", "--cycles", "0", "--seed", "3")
    window = open_window(program.url)
    window.wait_for_scene()
    window.wait_for_text("cycle 1, ")
    check_framing(window, tree)
    window.page.context.close()
    program.close()
