"""Tests of behaviours and trees: trials, start situations, end states, coverage.

Each name is imported on first use, because every pytest session loads `bt_manip.testing.plugin`
where bt-manip is installed.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.testing.all_trees import trees_of as trees_of
    from bt_manip.testing.check import Check as Check
    from bt_manip.testing.end_states import assert_stands_still as assert_stands_still
    from bt_manip.testing.end_states import assert_touches_only as assert_touches_only
    from bt_manip.testing.end_states import assert_tower as assert_tower
    from bt_manip.testing.situations import AT_REST as AT_REST
    from bt_manip.testing.situations import Situations as Situations
    from bt_manip.testing.situations import built_in_situations as built_in_situations
    from bt_manip.testing.situations import play as play
    from bt_manip.testing.stubs import Stub as Stub
    from bt_manip.testing.tree_runs import run_tree as run_tree
    from bt_manip.testing.trial import Trial as Trial

__getattr__ = lazy_exports(__name__)
