"""Checks of a whole tree before it runs: what can happen on every way through it."""

from bt_manip.bt.analysis.checks import check_tree as check_tree
