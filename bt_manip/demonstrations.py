"""Moved to the package bt-manip-learn."""

raise ImportError(
    "bt_manip.demonstrations is now bt_manip_learn.demonstrations, of the package bt-manip-learn"
)
