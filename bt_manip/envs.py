"""Moved to the package bt-manip-learn."""

raise ImportError("bt_manip.envs is now bt_manip_learn.envs, of the package bt-manip-learn")
