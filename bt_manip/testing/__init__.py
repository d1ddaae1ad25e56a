"""A pytest plugin and what it brings: trials, start situations, contracts, coverage of trees.

Nothing is handed on here: `bt_manip.testing.plugin` is loaded by every pytest session on a machine
that has bt-manip, and whatever this module imports would be loaded with it.
"""
