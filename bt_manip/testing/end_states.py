"""Assertions on the state of the physics at the end of a task."""

from bt_manip.cell import Cell, as_object, why_not_at_rest

LEVEL = 2e-3  # [m]


def assert_stands_still(cell: Cell, *names: str) -> None:
    """Assert that objects do not move.

    Raises:
        AssertionError: When one does.
    """
    for name in names:
        reason = why_not_at_rest(cell, name)
        assert not reason, reason


def assert_touches_only(cell: Cell, name: str, *others: str) -> None:
    """Assert that an object touches all of these, and nothing else.

    Raises:
        AssertionError: When it does otherwise.
    """
    partners = {label.partition("/")[0] for label in cell.contacts.partners(name)}
    assert partners == set(others), (
        f"'{name}' touches {', '.join(sorted(partners)) or 'nothing'}, "
        f"expected {', '.join(sorted(others)) or 'nothing'}"
    )


def assert_tower(cell: Cell, names: list[str], on: str) -> None:
    """Assert that objects form a tower at rest and touch nothing else.

    Args:
        cell: The cell.
        names: The objects from the bottom to the top.
        on: Support of the lowest object.

    Raises:
        AssertionError: When they do not.
    """
    assert_stands_still(cell, *names)
    stack = [on, *names]
    for i, name in enumerate(names):
        assert_touches_only(cell, name, *stack[i : i + 3 : 2])
    for lower, upper in zip(names, names[1:], strict=False):
        rise = cell.pose(upper).translation[2] - cell.pose(lower).translation[2]
        expected = sum(as_object(cell.find(name)).rest_height for name in (lower, upper))
        assert abs(rise - expected) <= LEVEL, (
            f"'{upper}' is {1000 * rise:.1f} mm above '{lower}', expected {1000 * expected:.1f} mm"
        )
