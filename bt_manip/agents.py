"""Moved to the package bt-manip-learn."""

raise ImportError("bt_manip.agents is now bt_manip_learn.agents, of the package bt-manip-learn")
