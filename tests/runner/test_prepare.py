"""Runs are prepared from a request, in a new station or in one that is there."""

import pytest

from bt_manip.runner import RunRequest, find_tree, prepare, prepare_station

TREE = """
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><MoveToConfiguration configuration="above"/></BehaviorTree>
</root>
"""
ABOVE = (0.3, -0.7, 0.1, -2.2, 0.0, 1.6, 0.8)


@pytest.fixture
def request_above(tmp_path):
    path = tmp_path / "tree.xml"
    path.write_text(TREE)
    return RunRequest(find_tree(str(path), {}), configurations={"above": ABOVE})


def test_a_run_continues_in_the_given_station(request_above, parts):
    station = prepare_station(request_above, parts)
    prepare(request_above, parts, station=station).execute()
    first = station.cell.time
    assert station.arm.q == pytest.approx(ABOVE)
    again = prepare(request_above, parts, station=station)
    again.execute()
    assert again.station is station
    assert first < station.cell.time < first + 0.1  # the arm is there already
