"""What no file can be made of is refused."""

import sys
from functools import partial

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.demonstrations import (
    DemonstrationStore,
    write_demonstration_table,
    write_lerobot,
    write_minari,
    write_robomimic,
)

from .conftest import IDENTITY


@pytest.mark.parametrize(
    "write",
    [
        write_demonstration_table,
        partial(write_robomimic, actions="joint_targets"),
        partial(write_lerobot, actions="joint_targets", python=sys.executable),
    ],
)
def test_an_empty_folder_is_refused(tmp_path, write):
    empty = DemonstrationStore.create(tmp_path / "empty", IDENTITY)
    with pytest.raises(BtManipError, match="has no demonstrations to export"):
        write(empty, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("write", [write_minari, write_robomimic])
def test_an_unknown_kind_of_actions_is_refused(store, tmp_path, write):
    with pytest.raises(BtManipError, match="no actions 'joint_target', but joint_targets, "):
        write(store, tmp_path / "pick-v0", "joint_target")
    assert not (tmp_path / "pick-v0").exists()


def test_without_minari_the_extra_is_named(store, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "minari", None)
    with pytest.raises(BtManipError, match=r"pip install 'bt-manip-learn\[minari\]'"):
        write_minari(store, tmp_path / "pick-v0", "joint_targets")
