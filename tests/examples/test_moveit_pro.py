"""The objective of MoveIt Pro among the examples runs here."""

from pathlib import Path

import pytest

from bt_manip.bt import ReadingOptions
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.runner import RunLoop, RunRequest, find_tree, prepare

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "moveit_pro"


def request(tree):
    return RunRequest(
        find_tree(str(tree), {}),
        scene=str(FOLDER / "cell.toml"),
        reading=ReadingOptions(dialect="auto", mapping=FOLDER / "mapping.toml"),
    )


def test_the_cube_is_carried_to_the_basket():
    run = prepare(request(FOLDER / "pick_and_place.xml"), load_plugins().parts)
    with RunLoop(run) as loop:
        ended = loop.cycle()
    assert ended.succeeded, ended.reason
    cube, basket = (run.station.cell.pose(name).translation for name in ("cube", "basket"))
    assert abs(cube[:2] - basket[:2]).max() < 0.15


def test_an_unknown_waypoint_is_refused_before_anything_moves(tmp_path):
    text = (FOLDER / "pick_and_place.xml").read_text()
    (tmp_path / "slip.xml").write_text(text.replace('"At Cube"', '"At Cub"'))
    with pytest.raises(BtManipError, match="no configuration is named 'At Cub'; did you mean"):
        prepare(request(tmp_path / "slip.xml"), load_plugins().parts)
