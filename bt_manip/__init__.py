"""Behaviour trees for manipulation: tasks, robot cells and plugins."""

from bt_manip.hookspecs import hookimpl as hookimpl
