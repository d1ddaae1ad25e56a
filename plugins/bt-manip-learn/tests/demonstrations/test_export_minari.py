"""What a Minari dataset cannot be made of is refused; Minari itself reads one in tests/clients."""

import builtins

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.demonstrations import write_minari


def test_without_minari_the_extra_is_named(store, tmp_path, monkeypatch):
    real = builtins.__import__

    def without(name, *args, **options):
        if name.startswith("minari"):
            raise ImportError(name)
        return real(name, *args, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(BtManipError, match=r"pip install 'bt-manip-learn\[minari\]'"):
        write_minari(store, tmp_path / "pick-v0", "joint_targets")


def test_an_unknown_kind_of_actions_is_refused(store, tmp_path):
    with pytest.raises(BtManipError, match="no actions 'torques'"):
        write_minari(store, tmp_path / "pick-v0", "torques")
