"""The recorder writes a line per tick."""

import pytest
from bt_manip.exceptions import BtManipError
from bt_manip.runner import prepare, request_of

from bt_manip_gear.gear import Gear

TREE = """
<root BTCPP_format="4"><BehaviorTree ID="wait"><Sleep msec="100"/></BehaviorTree></root>
"""


def test_it_writes_where_the_tool_is(tmp_path, parts):
    tree, file = tmp_path / "wait.xml", tmp_path / "run.gear"
    tree.write_text(TREE)
    run = prepare(request_of(str(tree), parts), parts)
    run.execute([Gear(file)])
    lines = [[float(x) for x in line.split()] for line in file.read_text().splitlines()]
    assert lines[-1][0] == pytest.approx(run.station.cell.time, abs=1e-3)
    assert lines[-1][1:] == pytest.approx(run.station.robot.tool_pose.translation, abs=1e-5)


def test_without_a_file_it_says_how_to_give_one():
    with pytest.raises(BtManipError, match="gear=FILE"):
        Gear(None)
